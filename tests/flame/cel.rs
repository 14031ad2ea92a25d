//! The look "cel" on a device, against the reference in f64, and against itself.

use celfx::data::Particles;
use celfx::effect::Effort;
use celfx::flame::reference::cel;
use celfx::flame::settings::{Glow, Look, Method, Mode, Tones};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;
use celfx::toon::{Line, Tone};

use crate::common::flame::{FlameRig, desc, embers, particles, scene};
use crate::common::scenes::camera;
use crate::determinism::bits;
use crate::oracle::{Shot, control};

const SIZE: [u32; 2] = [85, 67];

fn base() -> Settings {
    Settings { repetitions: 8, count: 6.0, spread: Some(0.15), size: Some(0.3), ..Settings::default() }
}

/// Pixels of half the picture have a wall before them.
fn wall(size: [u32; 2]) -> Vec<f32> {
    let depth = |place: u32| if place % size[0] < size[0] / 2 { 1.0 } else { f32::INFINITY };
    (0..size[0] * size[1]).map(depth).collect()
}

/// Compares a rendered frame stage by stage, each with what the device has of the one before.
#[track_caller]
fn compare(name: &str, rig: &mut FlameRig, depth: Option<&[f32]>) {
    let (settings, size) = (rig.desc().settings.clone(), rig.desc().size);
    let mean = rig.mean();
    let is_hidden = |place: usize| depth.is_some_and(|depth| depth[place].is_finite()) && mean[place][3] == 0.0;
    let hidden: Vec<bool> = (0..mean.len()).map(is_hidden).collect();
    let heat: Vec<f64> = mean.iter().map(|mean| mean[0].into()).collect();
    let smooth: Vec<f64> = rig.heat().into_iter().map(f64::from).collect();
    // Sums of products of single precision, small ones first.
    let expected = cel::smooth(size, &heat, &hidden, &settings);
    let worst = |pairs: &mut dyn Iterator<Item = (f64, f64)>| pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let error = worst(&mut smooth.iter().copied().zip(expected));
    assert!(error < 2e-6, "{name}: heat is {error} off");
    // Quotients of single precision, of which none that counts is above a line's width.
    let drawn = cel::draw(size, &smooth, &hidden, &settings);
    let flat = |found: Vec<[f32; 4]>, expected: &[[f64; 4]]| {
        worst(&mut found.as_flattened().iter().map(|v| f64::from(*v)).zip(expected.as_flattened().iter().copied()))
    };
    let error = flat(rig.tone(), &drawn.tone);
    assert!(error < 1e-5, "{name}: tones are {error} off");
    let error = worst(&mut rig.outline().into_iter().map(f64::from).zip(drawn.outline.iter().copied()));
    assert!(error < 1e-5, "{name}: the line is {error} off");
    let error = flat(rig.effect(), &drawn.picture);
    assert!(error < 1e-5, "{name}: the picture is {error} off");
}

#[test]
fn stages_are_those_of_the_reference() {
    let given = embers(40, 1);
    let fat = Line { strength: 0.7, width: 5.5, colour: [0.5, 0.25, 2.0] };
    let one = Tones(vec![Tone::new(900.0, [3.0, 2.0, 1.0])]);
    for (name, settings, size) in [
        ("usual", base(), SIZE),
        ("expected", Settings { mode: Mode::Expected, ..base() }, SIZE),
        ("drawn", Settings { method: Method::Raster, ..base() }, SIZE),
        ("not smoothed", Settings { sigma: 0.0, ..base() }, SIZE),
        ("a little", Settings { sigma: 0.1, ..base() }, [33, 16]),
        ("once, hard", Settings { repetitions: 1, tone_softness: 0.0, ..base() }, SIZE),
        ("one tone", Settings { tones: one, intensity: 2.0, outline: fat, tone_softness: 3.0, ..base() }, SIZE),
        ("wider than the picture", Settings { sigma: 64.0, ..base() }, [47, 21]),
        ("a pixel", base(), [1, 1]),
    ] {
        let Some(mut rig) = FlameRig::new(desc(size, 40, settings)) else { return };
        rig.frame(&given, camera(20.0));
        compare(name, &mut rig, None);
        if name == "usual" {
            let shares: Vec<f32> = rig.tone().iter().map(|tone| tone[3]).collect();
            assert!(shares.contains(&0.0) && shares.contains(&1.0) && rig.outline().iter().any(|ink| *ink > 0.9));
        }
    }
}

/// What the scene hides has no fire and no line beside it, and does not cool what is next to it.
#[test]
fn walls_cut_through_shapes() {
    let given = embers(40, 1);
    let depth = wall(SIZE);
    for mode in [Mode::Stochastic, Mode::Expected] {
        let settings = Settings { mode, count: 40.0, ..base() };
        let scene = Some(SceneFormat::Buffer);
        let Some(mut rig) = FlameRig::new(Desc { scene, ..desc(SIZE, 40, settings.clone()) }) else { return };
        rig.render(&Shot { depth: Some(&depth), ..Shot::new(&given, camera(0.0)) }.scene());
        compare("a wall", &mut rig, Some(&depth));
        let effect = rig.effect();
        assert!((0..effect.len()).all(|place| depth[place] == f32::INFINITY || effect[place] == [0.0; 4]));
        let Some(mut free) = FlameRig::new(desc(SIZE, 40, settings)) else { return };
        free.frame(&given, camera(0.0));
        let middle = (SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2) as usize;
        assert!(free.heat()[middle] > 0.3 && (rig.heat()[middle] - free.heat()[middle]).abs() < 0.1);
        assert!(rig.outline()[middle] == 0.0, "a line beside the wall");
    }
}

/// What is brighter than 1 shines on what is around it, in either look, beyond the tiles that have fire.
#[test]
fn light_glows() {
    let given = particles(&[[-0.4, 0.3, 0.0, 2500.0], [-0.38, 0.31, 0.1, 2900.0]]);
    let size = [140, 90];
    for look in [Look::Cel, Look::Light] {
        for glow in [Glow { strength: 0.5, sigma: 5.0 }, Glow { strength: 3.0, sigma: 15.0 }] {
            let dark = Settings { look, intensity: 4.0, spread: Some(0.05), size: Some(0.2), ..base() };
            let glowing = desc(size, 2, Settings { glow, ..dark.clone() });
            let (Some(mut with), Some(mut without), Some(mut whole)) = (
                FlameRig::new(glowing.clone()),
                FlameRig::new(desc(size, 2, dark)),
                FlameRig::with_effort(glowing, Effort::Everything),
            ) else {
                return;
            };
            [&mut with, &mut without, &mut whole].into_iter().for_each(|rig| rig.frame(&given, camera(0.0)));
            let picture: Vec<[f64; 4]> = without.effect().iter().map(|pixel| pixel.map(f64::from)).collect();
            let expected = cel::glow(size, &picture, &glow);
            let pairs = with.effect().into_iter().zip(&expected);
            let apart = |(found, expected): ([f32; 4], &[f64; 4])| {
                (0..4).map(|c| (f64::from(found[c]) - expected[c]).abs()).fold(0.0, f64::max)
            };
            let error = pairs.map(apart).fold(0.0, f64::max);
            let brightest = picture.as_flattened().iter().copied().fold(0.0, f64::max);
            assert!(brightest > 1.5, "{brightest} does not glow");
            // As of smoothed heat, of as much light.
            assert!(error < 2e-6 * f64::from(glow.strength).max(1.0) * brightest, "{look:?}, {glow:?}: {error}");
            assert_eq!(with.effect(), whole.effect());
            assert_eq!(with.picture(), whole.picture());
            let fire = |pixel: &[f64; 4]| pixel[3] > 0.0;
            let lit = with.picture().iter().zip(&picture).filter(|(pixel, dark)| pixel[0] > 0.0 && !fire(dark)).count();
            assert!(lit > 200, "{lit} pixels beside the fire are lit");
        }
    }
}

/// Only tiles that heat is smoothed into are worked on, and that changes no bit; nor do memory and earlier frames.
#[test]
fn skipping_changes_no_bit() {
    let given = particles(&[[0.0, 0.6, 0.0, 2500.0], [0.03, 0.61, 0.1, 2000.0]]);
    let depth = wall([160, 120]);
    for (settings, format) in [
        (base(), None),
        (base(), Some(SceneFormat::Buffer)),
        (Settings { sigma: 9.0, ..base() }, None),
        (Settings { sigma: 0.0, adaptive: 0.1, repetitions: 60, ..base() }, None),
        (Settings { mode: Mode::Expected, ..base() }, None),
    ] {
        let tones = Tones(vec![Tone::new(0.01, [1.0; 3])]);
        let settings = Settings { spread: Some(0.02), size: Some(0.2), count: 20.0, tones, ..settings };
        let desc = Desc { scene: format, ..desc([160, 120], 2, settings) };
        let frame = |effort, poison| {
            let mut rig = FlameRig::with_effort(desc.clone(), effort)?;
            rig.poison = poison;
            let shot = Shot { depth: format.map(|_| &depth[..]), ..Shot::new(&given, camera(0.0)) };
            (0..2).for_each(|_| rig.render(&shot.scene()));
            let tiles = control(&mut rig).tile_groups[0];
            Some((tiles, rig))
        };
        let (Some((some, mut needed)), Some((all, mut whole))) =
            (frame(Effort::Needed, Some(0x7FC0_1234)), frame(Effort::Everything, None))
        else {
            return;
        };
        assert!(some < 40 && all == 80, "{some} of {all}");
        assert!(needed.effect().iter().any(|pixel| pixel[3] > 0.5), "something is seen");
        assert_eq!(needed.effect(), whole.effect());
        assert_eq!(needed.heat(), whole.heat());
        assert_eq!((needed.tone(), needed.outline()), (whole.tone(), whole.outline()));
    }
}

#[test]
fn nothing_is_drawn_of_nothing() {
    let none = particles(&[]);
    let beside = particles(&[[50.0, 0.0, 0.0, 2500.0]]);
    let cold = particles(&[[0.0, 0.0, 0.0, 690.0]]);
    for given in [&none, &beside, &cold] {
        let Some(mut rig) = FlameRig::new(desc(SIZE, 1, Settings { alpha_scale: 100.0, ..base() })) else { return };
        rig.frame(given, camera(0.0));
        assert!(rig.effect().iter().all(|pixel| *pixel == [0.0; 4]));
        assert!(rig.heat().iter().chain(&rig.outline()).all(|value| *value == 0.0));
    }
}

/// Without layers the picture is made without them; repetitions that are added up are those of one frame.
#[test]
fn layers_and_sums_of_frames_change_no_bit() {
    let given = embers(40, 3);
    let usual = desc(SIZE, 40, base());
    let (Some(mut with), Some(mut without)) =
        (FlameRig::new(usual.clone()), FlameRig::new(Desc { layers: false, ..usual.clone() }))
    else {
        return;
    };
    with.frame(&given, camera(0.0));
    without.frame(&given, camera(0.0));
    assert_eq!(with.picture(), without.picture());
    let halves = Desc { settings: Settings { repetitions: 4, ..usual.settings.clone() }, ..usual };
    let Some(mut sums) = FlameRig::new(halves) else { return };
    let shown = |given: Option<&'static Particles>| scene(given, camera(0.0));
    sums.frame(&given, camera(0.0));
    sums.render(&Scene { accumulate: true, ..shown(None) });
    assert_eq!(with.effect(), sums.effect());
    assert_eq!(bits(&mut with).differences(&bits(&mut sums)), []);
}
