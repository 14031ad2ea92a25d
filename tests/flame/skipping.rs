//! What a frame does not need is left out, the reason is named, and the background stays as it was.

use celfx::data::Particles;
use celfx::effect::Effort;
use celfx::flame::FlameKind;
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;
use celfx::view::Camera;
use glam::DVec3;

use crate::common::flame::{FlameRig, ball, desc, particles, scene};
use crate::common::scenes::{camera, random};
use crate::determinism::bits;
use crate::oracle::{Shot, control};

const SIZE: [u32; 2] = [40, 30];
const PARTICLES: u32 = 50;

fn base() -> Settings {
    Settings { repetitions: 8, count: 4.0, spread: Some(0.15), size: Some(0.3), ..Settings::paper() }
}

fn effect(settings: Settings) -> Desc {
    desc(SIZE, PARTICLES, settings)
}

/// Any values at all, that no arithmetic leaves alone by accident.
fn backdrop() -> Vec<[f32; 4]> {
    (0..SIZE[0] * SIZE[1]).map(|i| [0, 1, 2, 3].map(|c| random(3, i, c))).collect()
}

fn over_backdrop(desc: &Desc) -> Option<FlameRig> {
    over_backdrop_with(desc, Effort::Needed)
}

fn over_backdrop_with(desc: &Desc, effort: Effort) -> Option<FlameRig> {
    let mut rig = FlameRig::with_effort(desc.clone(), effort)?;
    rig.offline().set_backdrop(&backdrop()).expect("a backdrop");
    Some(rig)
}

fn steps(rig: &mut FlameRig, name: &str) -> usize {
    let flame = rig.offline().effect::<FlameKind>().expect("a flame");
    let of_name = |pass: celfx::low_level::plan::PassId| flame.passes()[usize::from(pass.0)].name == name;
    flame.plan().steps.iter().filter(|step| of_name(step.pass)).count()
}

fn reason(rig: &mut FlameRig, name: &str) -> Option<&'static str> {
    let mut skipped = rig.offline().effect::<FlameKind>().expect("a flame").skipped();
    skipped.find(|(skipped, _)| *skipped == name).map(|(_, reason)| reason)
}

/// Nothing but the background, bit for bit, and layers that say so.
fn assert_empty(name: &str, rig: &mut FlameRig) {
    let bits = |pixels: &[[f32; 4]]| pixels.as_flattened().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert!(bits(&rig.picture()) == bits(&backdrop()), "{name}: the background has changed");
    for layer in [rig.mean(), rig.variance(), rig.effect()] {
        assert!(layer.as_flattened().iter().all(|v| *v == 0.0), "{name}");
    }
    assert!(rig.nearest().iter().all(|z| *z == f32::INFINITY), "{name}");
    assert!(rig.prepared().iter().all(|particle| particle.count == 0), "{name}: a particle is left");
}

/// Looks and particles of which the host knows that nothing can be seen.
fn dark() -> Vec<(&'static str, Settings, Particles)> {
    let cold = |t| particles(&[[0.0, 0.0, 0.0, t], [0.3, 0.1, 0.2, 0.5 * t]]);
    let pass = "no particle can pass the alpha test";
    let warm = ball(PARTICLES, 1);
    vec![
        (pass, base(), cold(200.0)),
        (pass, Settings { threshold: 1.000_001, ..base() }, warm.clone()),
        (pass, Settings { threshold: f32::MAX, ..base() }, warm.clone()),
        (pass, Settings { alpha_scale: 0.4, ..base() }, warm.clone()),
        (pass, Settings { alpha_scale: 0.0, threshold: f32::from_bits(1), ..base() }, warm.clone()),
        ("count is 0: no render particles", Settings { count: 0.0, ..base() }, warm.clone()),
        ("sprites have no size", Settings { size: Some(0.0), ..base() }, warm.clone()),
        ("sprites have no size", Settings { size: None, size_pixels: Some(0.0), ..base() }, warm.clone()),
        ("no particles", base(), particles(&[])),
    ]
}

#[test]
fn frames_without_fire_are_the_background() {
    for (index, (why, settings, given)) in dark().into_iter().enumerate() {
        for effort in [Effort::Needed, Effort::Everything].into_iter().take(if index == 0 { 2 } else { 1 }) {
            let Some(mut rig) = over_backdrop_with(&effect(settings.clone()), effort) else { return };
            rig.frame(&given, camera(0.0));
            for name in ["flame.prepare", "flame.bin", "flame.accumulate", "flame.resolve", "flame.composite"] {
                assert_eq!((steps(&mut rig, name), reason(&mut rig, name)), (0, Some(why)), "{name}");
            }
            assert_empty(why, &mut rig);
        }
    }
}

/// Particles of which only the device can tell.
#[test]
fn nothing_on_the_screen_is_no_work() {
    let warm = ball(PARTICLES, 1);
    let away = Camera { target: DVec3::new(0.0, 0.6, 90.0), ..camera(0.0) };
    let beside = Camera { target: DVec3::new(90.0, 0.6, -60.0), ..camera(0.0) };
    let short = Camera { far: 2.0, ..camera(0.0) };
    let late = Camera { near: 8.0, ..camera(0.0) };
    let nowhere = particles(&[[f32::NAN, 0.0, 0.0, 2000.0], [0.0, 0.0, f32::INFINITY, 2000.0]]);
    let sick = particles(&[[0.0, 0.0, 0.0, f32::NAN], [0.0, 0.0, 0.0, f32::INFINITY], [0.0, 0.0, 0.0, -1.0]]);
    // The hottest could be seen, but it is elsewhere: the others are too cold.
    let cold = particles(&[[0.0, 0.0, 0.0, 250.0], [0.1, 0.1, 0.1, 200.0], [0.0, 0.0, 50.0, 3000.0]]);
    // Of these few there happen to be no render particles: none in 10,000.
    let rare = Settings { count: 1e-4, ..base() };
    for (name, settings, given, camera) in [
        ("behind", base(), &warm, away),
        ("beside", base(), &warm, beside),
        ("too far", base(), &warm, short),
        ("too near", base(), &warm, late),
        ("nowhere", base(), &nowhere, camera(0.0)),
        ("not valid", base(), &sick, camera(0.0)),
        ("cold", base(), &cold, camera(0.0)),
        ("rare", rare, &warm, camera(0.0)),
    ] {
        let Some(mut rig) = over_backdrop(&effect(settings)) else { return };
        rig.frame(given, camera);
        assert!(steps(&mut rig, "flame.accumulate") > 0, "{name}: the host cannot know");
        let control = control(&mut rig);
        let groups = [control.tile_groups[0], control.active_groups[0], control.tile_draw[1], control.listed];
        assert_eq!((groups, control.visible), ([0; 4], 0), "{name}");
        assert_empty(name, &mut rig);
    }
}

/// Occluded by the scene all over.
#[test]
fn fire_behind_the_scene_is_the_background() {
    let warm = ball(PARTICLES, 1);
    let wall = vec![2.5; (SIZE[0] * SIZE[1]) as usize];
    for settings in [base(), Settings { size: Some(2.0), ..base() }] {
        let Some(mut rig) = over_backdrop(&Desc { scene: Some(SceneFormat::Buffer), ..effect(settings) }) else {
            return;
        };
        rig.render(&Shot { depth: Some(&wall), ..Shot::new(&warm, camera(0.0)) }.scene());
        let bits = |pixels: &[[f32; 4]]| pixels.as_flattened().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(bits(&rig.picture()) == bits(&backdrop()));
        assert!(rig.mean().as_flattened().iter().all(|v| *v == 0.0));
        assert!(rig.nearest().iter().all(|z| *z == f32::INFINITY));
    }
}

/// Tiles where nothing is are no work, and stay as they were.
#[test]
fn work_follows_what_is_covered() {
    let given = particles(&[[-0.9, 0.6, 0.0, 2500.0], [-0.88, 0.61, 0.1, 2000.0]]);
    let small = Settings { spread: Some(0.02), size: Some(0.04), ..base() };
    let size = [160, 120];
    let Some(mut rig) = FlameRig::new(desc(size, 2, small)) else { return };
    rig.frame(&given, camera(0.0));
    let tiles = control(&mut rig).tile_groups[0];
    assert!((1..=4).contains(&tiles), "{tiles} of 80 tiles");
    let repeated = rig.variance().iter().filter(|v| v[3] > 0.0).count() as u32;
    assert_eq!(repeated, tiles * 16 * 16);
    assert!(rig.mean().iter().any(|mean| mean[3] > 0.0));
}

#[test]
fn lit_and_dark_frames_follow_each_other() {
    let warm = ball(PARTICLES, 1);
    let cold = particles(&[[0.0, 0.0, 0.0, 200.0], [0.3, 0.1, 0.2, 100.0]]);
    let none = particles(&[]);
    let desc = effect(base());
    let alone = |given: &Particles| {
        let mut rig = over_backdrop(&desc)?;
        rig.frame(given, camera(0.0));
        Some(bits(&mut rig))
    };
    let (Some(lit), Some(mut rig)) = (alone(&warm), over_backdrop(&desc)) else { return };
    // The mask is a layer of dark frames, too.
    let orders = [&cold, &warm, &warm, &none, &none, &warm, &cold, &none, &warm];
    for (index, given) in orders.into_iter().enumerate() {
        rig.frame(given, camera(0.0));
        if std::ptr::eq(given, &warm) {
            assert_eq!(lit.differences(&bits(&mut rig)), [], "frame {index}");
            assert_eq!(steps(&mut rig, "flame.mask") > 0, index == 0, "frame {index}");
        } else {
            assert_empty(&format!("frame {index}"), &mut rig);
        }
        // The same again, kept.
        rig.render(&scene(None, camera(0.0)));
        if std::ptr::eq(given, &warm) {
            assert_eq!(lit.differences(&bits(&mut rig)), [], "frame {index}, kept");
        } else {
            assert_empty(&format!("frame {index}, kept"), &mut rig);
        }
    }
}

/// The same without layers: no buffer but the picture is there, and what dark frames leave out is made when it is needed.
#[test]
fn without_layers() {
    let warm = ball(PARTICLES, 1);
    let cold = particles(&[[0.0, 0.0, 0.0, 200.0]]);
    let bare = Desc { layers: false, ..effect(base()) };
    let (Some(mut with), Some(mut rig)) = (over_backdrop(&effect(base())), over_backdrop(&bare)) else { return };
    with.frame(&warm, camera(0.0));
    for given in [&cold, &warm, &cold, &warm] {
        rig.render(&Scene { number: 3, ..scene(Some(given), camera(0.0)) });
        let expected = if std::ptr::eq(given, &warm) { with.picture() } else { backdrop() };
        assert!(rig.picture() == expected);
    }
}
