//! The shots inside the program.

use super::*;

/// The keys that a shot's text shows, those in comments too: dotted, with the text after the sign.
fn shown(text: &str) -> Vec<(String, bool, &str)> {
    let mut table = String::new();
    let mut keys = Vec::new();
    for line in text.lines() {
        if let Some(header) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            keys.push((header.to_owned(), false, ""));
            table = format!("{header}.");
        }
        let (line, comment) = line.strip_prefix("# ").map_or((line, false), |line| (line, true));
        let name = |key: &str| !key.is_empty() && key.chars().all(|c| c.is_ascii_lowercase() || c == '_');
        if let Some((key, rest)) = line.split_once(" = ").filter(|(key, _)| name(key)) {
            keys.push((format!("{table}{key}"), comment, rest));
        }
    }
    keys
}

#[test]
fn built_in_shots_name_every_key_of_their_effects() {
    for (name, _) in BUILTIN {
        let shot = program::load(name, &[]).expect("a built-in shot");
        let text = program::builtin_text(name).expect("a built-in shot");
        let shown = shown(&text);
        let times = |key: &str| shown.iter().filter(|(shown, ..)| shown == key).count();
        let effect = |key: &str, table: &str| key == table || key.starts_with(&format!("{table}."));
        let is_left_out = |key: &str| {
            (["camera.file", "camera.name", "camera.animation"].contains(&key) && !shot.has("blur"))
                || key.starts_with("smoke.emitter.")
                || program::tables().iter().any(|table| effect(key, table.name) && !shot.has(table.name))
        };
        for dial in Keys::new(&program::tables()).all() {
            assert_eq!(times(&dial.key), usize::from(!is_left_out(&dial.key)), "{name}: {}", dial.key);
        }
    }
}

#[test]
fn comments_change_no_value_and_say_range_and_default() {
    for (name, text) in BUILTIN {
        let printed = program::builtin_text(name).expect("a built-in shot");
        let read = |text: &str| text.parse::<toml::Table>().expect(name);
        assert_eq!(read(&printed), read(text), "{name}");
        assert!(printed.lines().all(|line| line.chars().count() <= 120), "{name}");
    }
    let printed = program::builtin_text("builtin:smoke").expect("a built-in shot");
    let line = "sigma = 12.0                    # pixels at 1080 lines, 0 (off) or 0.1 to 64; default 8.";
    assert!(printed.lines().any(|printed| printed.starts_with(line)), "{printed}");
}

#[test]
fn built_in_shots_say_the_defaults() {
    let defaults = load("[smoke]\n[flame]", &[]).expect("a shot");
    for (name, _) in BUILTIN {
        let shot = program::load(name, &[]).expect("a built-in shot");
        assert_eq!((shot.fps, shot.frames), (24.0, [1, 48]), "{name}");
        // What each shot sets for itself; all else that it shows is the default.
        if let Some(Smoke { settings, .. }) = shot.part() {
            let Settings { particles, lifetime, fade, radius, radius_smoothing, scale, groups, hysteresis, .. } =
                *settings;
            let Settings { sigma, smallest, .. } = *settings;
            let defaults = &smoke_of(&defaults).settings;
            // Beside a fire it is night, and the smoke stays above the fire.
            let own = if shot.has("flame") { settings } else { defaults };
            if *name == "builtin:paper_smoke" {
                let [soft, hard] = [defaults, settings].map(|s| (s.mask, s.outline.operator, s.fade, s.tone_softness));
                assert!(
                    soft.0 != hard.0 && soft.1 != hard.1 && (hard.2, hard.3) == (0, 0.0) && shot.light(1).fill == 0.0
                );
                continue;
            }
            let expected = Settings {
                particles,
                lifetime,
                fade,
                radius,
                radius_smoothing,
                scale,
                groups,
                hysteresis,
                sigma,
                smallest,
                emitter: own.emitter,
                tones: settings.tones.clone(),
                outline: crate::smoke::settings::Outline {
                    strength: own.outline.strength,
                    width: settings.outline.width,
                    ..defaults.outline
                },
                ..defaults.clone()
            };
            assert_eq!(*settings, expected, "{name}");
        }
        if let Some(Flame { settings, .. }) = shot.part() {
            let crate::flame::Settings {
                spread,
                size,
                threshold,
                falloff,
                adaptation,
                intensity,
                light,
                reach,
                look,
                stretch,
                repetitions,
                octaves,
                emission,
                count,
                embers,
                ..
            } = *settings;
            let expected = crate::flame::Settings {
                spread,
                size,
                threshold,
                falloff,
                adaptation,
                intensity,
                light,
                reach,
                look,
                stretch,
                repetitions,
                octaves,
                emission,
                count,
                embers,
                ..flame_of(&defaults).settings.clone()
            };
            assert_eq!(*settings, expected, "{name}");
            assert_eq!(
                (settings.is_cel(), stretch > 0.0),
                (*name != "builtin:paper_flame", settings.is_cel()),
                "{name}"
            );
            assert_eq!(settings.light > 0.0, shot.has("smoke"), "{name}: fire lights smoke where there is some");
        }
        if let Some(Blur { scene, animations, images, passes, cuts, shares, share_map, settings }) = shot.part() {
            assert_eq!(*scene, scene::Source::Builtin(crate::simulate::mesh::Builtin::Run));
            assert_eq!((&animations[..], images, passes, cuts), (&[][..], &None, &None, &None));
            assert_eq!((&shares[..], share_map), (&[][..], &None));
            let tooth_width = Some(crate::blur::Settings::default().tooth_width());
            let expected = match *name == "builtin:paper_blur" {
                true => crate::blur::Settings::paper(),
                false => crate::blur::Settings { tooth_width, ..crate::blur::Settings::default() },
            };
            assert_eq!(*settings, expected, "{name}");
        }
    }
}

/// Keys of kinds of lines, which are those of all lines if they are not given.
const LINES: [&str; 6] = [
    "smoke.outline.silhouette.strength",
    "smoke.outline.silhouette.width",
    "smoke.outline.silhouette.colour",
    "smoke.outline.inner.strength",
    "smoke.outline.inner.width",
    "smoke.outline.inner.colour",
];

#[test]
fn what_built_in_shots_show_commented_out_is_valid_too() {
    for (name, _) in BUILTIN {
        let shot = program::load(name, &[]).expect("a built-in shot");
        let text = program::builtin_text(name).expect("a built-in shot");
        let mut tried = Vec::new();
        for (key, _, rest) in shown(&text).into_iter().filter(|(_, comment, _)| *comment) {
            let value = rest.split_once(" # ").map_or(rest, |(value, _)| value).trim();
            match program::load(name, &[format!("{key}={value}")]) {
                // Sprites have a size in metres already.
                Err(error) if key == "flame.size_pixels" => {
                    assert!(error.to_string().contains("not together with flame.size"), "{error}");
                }
                // The built-in scene has none.
                Err(error) if ["blur.animation", "camera.animation", "camera.name"].contains(&&key[..]) => {
                    assert!(error.to_string().contains("glTF"), "{error}")
                }
                // Of passes there is none without the others.
                Err(error) if key.starts_with("blur.passes.") => {
                    assert!(error.to_string().contains("colour, depth and motion together"), "{error}");
                }
                loaded => drop(loaded.expect(&key)),
            }
            tried.push(key);
        }
        let mut expected =
            vec!["light.position", "light.second.direction", "light.second.position", "output.config", "output.space"];
        expected.extend((!shot.has("blur")).then_some("camera.orthographic"));
        if let Some(Smoke { settings, .. }) = shot.part() {
            expected.extend([
                "smoke.on",
                "smoke.density_grid",
                "smoke.velocity_grid",
                "smoke.velocity_scale",
                "smoke.volume_fps",
                "smoke.up",
                "smoke.group_depth",
                "smoke.tones_above",
            ]);
            expected.extend(settings.emitter.is_none().then_some("smoke.emitter"));
            expected.extend(settings.lifetime.is_none().then_some("smoke.lifetime"));
            expected.extend(settings.detail.is_none().then_some("smoke.detail"));
            expected.extend(LINES);
        }
        if let Some(Flame { settings, .. }) = shot.part() {
            expected.extend(["flame.on", "flame.size_pixels"]);
            expected.extend(settings.reach.is_none().then_some("flame.reach"));
            expected.extend(settings.emission.is_none().then_some("flame.emission"));
            expected.extend(settings.embers.rise.is_none().then_some("flame.embers.rise"));
        }
        if shot.has("blur") {
            expected.extend(keys::INSTEAD_OF_FILE);
            expected.extend(["blur.passes.colour", "blur.passes.depth", "blur.passes.id", "blur.passes.motion"]);
            expected.extend([
                "blur.animation",
                "blur.cuts",
                "blur.images",
                "blur.share_map",
                "blur.shares",
                "camera.animation",
                "camera.name",
            ]);
            expected.push(if name.contains("paper") { "blur.tooth_width" } else { "blur.teeth" });
        }
        expected.sort_unstable();
        tried.sort_unstable();
        assert_eq!(tried, expected, "{name}");
    }
}
