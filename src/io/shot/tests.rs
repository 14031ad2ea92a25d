use std::fs;

use super::*;
use crate::io::tests::Folder;
use crate::smoke::settings;

fn load(text: &str, sets: &[&str]) -> Result<Shot, ShotError> {
    let folder = Folder::new();
    let path = folder.0.join("shot.toml");
    fs::write(&path, text).expect("temporary folder");
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    Shot::load(path.to_str().expect("UTF-8"), &sets)
}

/// The message of a shot that must be refused, without the folder of its file.
fn refused(text: &str, sets: &[&str]) -> String {
    let message = load(text, sets).expect_err(text).to_string();
    message.split_once("/shot.toml").map_or(message.clone(), |(_, rest)| format!("shot.toml{rest}"))
}

#[test]
fn an_empty_smoke_table_has_every_default() {
    let shot = load("[smoke]", &[]).expect("a shot");
    assert_eq!((shot.size, shot.frames, shot.fps, shot.seed), ([512, 512], [1, 48], 24.0, 0));
    assert_eq!(shot.background, Background::Colour([0.55, 0.70, 0.90]));
    assert_eq!((shot.camera(7), shot.light(7)), (Camera::default(), Light::default()));
    assert_eq!(shot.smoke.settings, Settings::default());
    assert_eq!(
        (shot.smoke.volume.as_str(), &shot.smoke.grids, shot.smoke.hold),
        ("builtin:plume", &Grids::default(), false)
    );
}

#[test]
fn built_in_shots_name_every_key_and_say_its_default() {
    let defaults = load("[smoke]", &[]).expect("a shot");
    for (name, text) in BUILTIN {
        let shot = Shot::load(name, &[]).expect("a built-in shot");
        // What each shot sets for itself; all else that it shows is the default.
        let Settings { particles, lifetime, radius, scale, groups, hysteresis, sigma, .. } = shot.smoke.settings;
        let expected = Settings {
            particles,
            lifetime,
            radius,
            scale,
            groups,
            hysteresis,
            sigma,
            ..defaults.smoke.settings.clone()
        };
        assert_eq!(shot.smoke.settings, expected, "{name}");
        assert_eq!((shot.light(1), shot.fps, shot.frames), (defaults.light(1), 24.0, [1, 48]), "{name}");
        for (key, _) in keys::KEYS.iter().filter(|(key, _)| *key != "camera.file" && !key.starts_with("smoke.emitter."))
        {
            let leaf = key.rsplit('.').next().unwrap_or(key);
            let shown = text.lines().any(|line| {
                let line = line.trim_start_matches("# ");
                line.starts_with(&format!("{leaf} = ")) || line == format!("[{key}]")
            });
            assert!(shown, "{name} does not show {key}");
        }
    }
}

#[test]
fn what_built_in_shots_show_commented_out_is_valid_too() {
    for (name, text) in BUILTIN {
        let mut table = String::new();
        let mut tried = 0;
        for line in text.lines() {
            if let Some(header) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                table = format!("{header}.");
            }
            let Some((key, rest)) = line.strip_prefix("# ").and_then(|l| l.split_once(" = ")) else { continue };
            let value = rest.split_once(" # ").map_or(rest, |(value, _)| value).trim();
            Shot::load(name, &[format!("{table}{key}={value}")]).expect(line);
            tried += 1;
        }
        let lifetime = Shot::load(name, &[]).expect("a built-in shot").smoke.settings.lifetime;
        let expected = if lifetime.is_some() { 5 } else { 6 };
        assert_eq!(tried, expected, "{name}: position, two grids, emitter, lifetime unless it is set, group_depth");
    }
}

#[test]
fn the_list_of_keys_is_that_of_the_settings() {
    // Serde names all fields of a structure in the message about an unknown one.
    let fields = |table: &str| {
        let message = toml::from_str::<settings::Settings>(table).expect_err("unknown").message().to_owned();
        let names: Vec<String> = message.split('`').skip(3).step_by(2).map(str::to_owned).collect();
        assert!(names.len() > 1, "{message}");
        names
    };
    let known = |table: &str| {
        let keys = keys::KEYS.iter().map(|(key, _)| *key).filter(|key| keys::parent(key) == Some(table));
        keys.map(|key| key.rsplit('.').next().unwrap_or(key).to_owned()).collect::<Vec<_>>()
    };
    let inputs = ["volume", "density_grid", "velocity_grid", "hold"];
    let settings: Vec<String> = known("smoke").into_iter().filter(|key| !inputs.contains(&key.as_str())).collect();
    assert_eq!(settings, fields("zzz = 1"));
    assert_eq!(known("smoke.outline"), fields("outline = { zzz = 1 }"));
    assert_eq!(known("smoke.emitter"), fields("emitter = { zzz = 1 }"));
}

#[test]
fn unknown_keys_name_file_line_and_the_nearest_key() {
    for (text, message) in [
        ("[smoke]\n\nsigmaa = 4", "shot.toml:3: smoke.sigmaa: unknown key; did you mean smoke.sigma?"),
        ("sise = [8, 8]\n[smoke]", "shot.toml:1: sise: unknown key; did you mean size?"),
        (
            "[smoke.outline]\ncolor = [0, 0, 0]",
            "shot.toml:2: smoke.outline.color: unknown key; did you mean smoke.outline.colour?",
        ),
        (
            "[smoke]\noutline = { with = 2 }",
            "shot.toml:2: smoke.outline.with: unknown key; did you mean smoke.outline.width?",
        ),
        ("[smok]", "shot.toml:1: smok: unknown key; did you mean smoke?"),
    ] {
        assert_eq!(refused(text, &[]), message);
    }
}

#[test]
fn wrong_values_name_file_line_key_and_what_is_allowed() {
    for (text, place, allowed) in [
        ("[smoke]\nsigma = 100", "shot.toml:2: smoke.sigma = 100: ", "0.1 to 64"),
        ("[smoke]\nsigma = \"soft\"", "shot.toml:2: smoke.sigma = \"soft\": ", "0.1 to 64"),
        ("[smoke]\nsigma = nan", "shot.toml:2: smoke.sigma = NaN: ", "0.1 to 64"),
        ("[smoke]\nparticles = -1", "shot.toml:2: smoke.particles = -1: ", "0 to 1000000"),
        ("[smoke]\nparticles = 99999999999999999999", "shot.toml:2: smoke.particles = ", "0 to 1000000"),
        ("[smoke]\nplacement = \"cover\"", "shot.toml:2: smoke.placement = cover: ", "not built yet"),
        ("[smoke]\nshadow = \"soft\"", "shot.toml:2: smoke.shadow = \"soft\": ", "\"exact\", \"map\" or \"none\""),
        ("[smoke]\noutline = 3", "shot.toml:2: smoke.outline = 3: ", "a table"),
        ("[smoke]\noutline.width = 0.5", "shot.toml:2: smoke.outline.width = 0.5: ", "1 to 16"),
        ("[smoke]\noutline.colour = [0, 0]", "shot.toml:2: smoke.outline.colour = [0, 0]: ", "[red, green, blue]"),
        ("[smoke]\nemitter = { min = [0, 0, 0] }", "shot.toml:2: smoke.emitter = { ... }: ", "max"),
        ("[smoke]\nsigma = { x = 1 }", "shot.toml:2: smoke.sigma = { ... }: ", "0.1 to 64"),
        ("[smoke]\ntones = []", "shot.toml:2: smoke.tones = 0 tones: ", "1 to 256"),
        ("[smoke]\ntones = [[0.5, [1, 1, 1]], [0.2, [1, 1, 1]]]", "shot.toml:2: smoke.tones = ", "ascending"),
        ("[smoke]\nvolume = \"builtin:plum\"", "shot.toml:2: smoke.volume = \"builtin:plum\": ", "builtin:plume"),
        ("smoke = 3", "shot.toml:1: smoke = 3: ", "a table"),
        ("size = [0, 64]\n[smoke]", "shot.toml:1: size = [0, 64]: ", "1 to 16384"),
        ("size = [1000000, 64]\n[smoke]", "shot.toml:1: size = [1000000, 64]: ", "1 to 16384"),
        ("size = [64.0, 64]\n[smoke]", "shot.toml:1: size = [64.0, 64]: ", "whole numbers"),
        ("frames = [4, 1]\n[smoke]", "shot.toml:1: frames = [4, 1]: ", "first not above last"),
        ("fps = 0\n[smoke]", "shot.toml:1: fps = 0: ", "0.001 to"),
        ("seed = -1\n[smoke]", "shot.toml:1: seed = -1: ", "0 to 4294967295"),
        ("background = [1, 2]\n[smoke]", "shot.toml:1: background = [1, 2]: ", "linear"),
        ("background = [nan, 0, 0]\n[smoke]", "shot.toml:1: background = [nan, 0, 0]: ", "linear"),
        ("[smoke]\n[camera]\nvertical_fov = 180", "shot.toml:3: camera.vertical_fov = 180: ", "below 180"),
        ("[smoke]\n[camera]\neye = [[2, [0, 1, 4]], [1, [0, 1, 5]]]", "shot.toml:3: camera.eye = ", "ascending"),
        ("[smoke]\n[camera]\neye = [0, 1, 0]", "shot.toml:2: camera.target = ", "differ from camera.eye"),
        ("[smoke]\n[camera]\nfile = \"a.glb\"", "shot.toml:3: camera.file = \"a.glb\": ", "not supported yet"),
        ("[smoke]\n[light]\nambient = 2", "shot.toml:3: light.ambient = 2: ", "0 to 1"),
        ("[smoke]\n[light]\ndirection = [0, 0, 0]", "shot.toml:3: light.direction = ", "not all 0"),
    ] {
        let message = refused(text, &[]);
        assert!(message.starts_with(place) && message[place.len()..].contains(allowed), "{text}\n{message}");
    }
}

#[test]
fn what_is_not_built_is_said() {
    assert_eq!(
        refused("[smoke]\n[flame]", &[]),
        "shot.toml:2: flame: the effect [flame] is not built yet; there is [smoke]"
    );
    assert_eq!(
        refused("blur.length = 3", &[]),
        "shot.toml:1: blur: the effect [blur] is not built yet; there is [smoke]"
    );
    assert!(refused("size = [8, 8]", &[]).contains("holds no effect"));
}

#[test]
fn text_that_is_not_toml_names_the_line() {
    assert!(refused("[smoke]\nsigma = = 4", &[]).starts_with("shot.toml:2: "));
    assert!(refused("[smoke]\nsigma = 4\nsigma = 5", &[]).starts_with("shot.toml:3: "));
    let folder = Folder::new();
    let path = folder.0.join("shot.toml");
    fs::write(&path, b"[smoke]\n\xff").expect("temporary folder");
    let message = Shot::load(path.to_str().expect("UTF-8"), &[]).expect_err("binary").to_string();
    assert!(message.contains("not UTF-8 text at byte 8"), "{message}");
}

#[test]
fn a_missing_shot_is_unreadable_and_a_missing_built_in_suggests_one() {
    let missing = Shot::load("/nonexistent/shot.toml", &[]).expect_err("missing");
    assert!(matches!(&missing, ShotError::Read { .. }) && missing.to_string().contains("/nonexistent/shot.toml"));
    let message = Shot::load("builtin:smok", &[]).expect_err("unknown").to_string();
    assert!(message.contains("did you mean builtin:smoke?"), "{message}");
}

#[test]
fn keys_can_be_overridden() {
    let text = "[smoke]\nsigma = 2\n[light]\ndirection = [0, -1, 0]";
    let sets = [
        "smoke.sigma=8",
        "smoke.shadow=map",
        "smoke.outline.width = 3",
        "camera.far=inf",
        "size=[64, 32]",
        "light.position=[1, 2, 3]",
        "background=none",
        "smoke.fade=1_0",
    ];
    let shot = load(text, &sets).expect("a shot");
    let settings = &shot.smoke.settings;
    assert_eq!((settings.sigma, settings.shadow, settings.fade), (8.0, settings::Shadow::Map, 10));
    assert_eq!((settings.outline.width, settings.outline.strength), (3.0, 1.0));
    assert_eq!((shot.size, shot.camera(1).far, &shot.background), ([64, 32], f64::INFINITY, &Background::None));
    assert_eq!(shot.light(1).source, LightSource::Position(DVec3::new(1.0, 2.0, 3.0)));
    for (set, message) in [
        ("smoke.sigmaa=4", "--set smoke.sigmaa=4: smoke.sigmaa: unknown key; did you mean smoke.sigma?"),
        ("smoke.sigma", "--set smoke.sigma: expected KEY=VALUE, for example smoke.sigma=4"),
        ("smoke.sigma=100", "--set smoke.sigma: smoke.sigma = 100: allowed: pixels, 0 (off) or 0.1 to 64"),
        ("smoke=3", "--set smoke: smoke = 3: allowed: a table"),
        ("size.x=3", "--set size.x=3: size.x: unknown key; did you mean size?"),
    ] {
        assert_eq!(refused(text, &[set]), message);
    }
    assert!(refused(text, &["size=[1,"]).starts_with("--set size=[1,: "));
    assert!(refused("[smoke]\n[light]\ndirection=[0,-1,0]\nposition=[0,1,0]", &[]).contains("not both"));
}

#[test]
fn keyframes_move_camera_and_light() {
    let text = "[smoke]\n[camera]\neye = [[1, [0, 1, 4]], [5, [4, 1, 4]]]\nfar = [[1, 10], [3, inf]]\n\
                [light]\nambient = [[1, 0], [5, 1]]\nposition = [[1, [0, 0, 0]], [5, [0, 8, 0]]]";
    let shot = load(text, &[]).expect("a shot");
    assert_eq!([1, 2, 5, 9].map(|f| shot.camera(f).eye.x), [0.0, 1.0, 4.0, 4.0]);
    assert_eq!([1, 3].map(|f| shot.camera(f).far), [10.0, f64::INFINITY]);
    assert_eq!(shot.light(2), Light { source: LightSource::Position(DVec3::new(0.0, 2.0, 0.0)), ambient: 0.25 });
    let through = "[smoke]\n[camera]\ntarget = [0, 1, 0]\neye = [[1, [0, 1, 4]], [9, [0, 1, -4]]]";
    assert!(refused(through, &[]).contains("(at frame 5)"), "{}", refused(through, &[]));
}

#[test]
fn paths_are_relative_to_the_shot() {
    let folder = Folder::new();
    fs::create_dir(folder.0.join("shots")).expect("temporary folder");
    let file = folder.0.join("shots/a.toml");
    fs::write(&file, "background = \"sky.png\"\n[smoke]\ntones = \"t.png\"\nvolume = \"v.####.npz\"")
        .expect("temporary folder");
    let load = || Shot::load(file.to_str().expect("UTF-8"), &[]);
    let missing = load().expect_err("no tones yet");
    assert!(matches!(&missing, ShotError::Input(e) if e.path == folder.0.join("shots/t.png")), "{missing}");

    let pixels = [
        [0, 0, 0, 255],
        [0, 0, 0, 255],
        [255, 255, 255, 255],
        [255, 0, 0, 255],
        [9, 9, 9, 9],
        [9, 9, 9, 9],
        [9, 9, 9, 9],
        [9, 9, 9, 9],
    ];
    crate::io::image::write_png8(&folder.0.join("shots/t.png"), [4, 2], &pixels).expect("temporary folder");
    let shot = load().expect("a shot");
    let tones: Vec<_> = shot.smoke.settings.tones.iter().map(|t| (t.from, t.colour)).collect();
    assert_eq!(tones, [(0.0, [0.0; 3]), (0.5, [1.0; 3]), (0.75, [1.0, 0.0, 0.0])]);
    assert_eq!(shot.background, Background::Image(folder.0.join("shots/sky.png")));
    assert_eq!(shot.folder, folder.0.join("shots"));
    let mut volumes = shot.volumes().expect("a pattern");
    assert_eq!(volumes.frame(3).expect_err("missing").path, folder.0.join("shots/v.0003.npz"));
}
