//! The paper's way, by render passes, against the tiles: the same winners.

use celfx::data::Particles;
use celfx::effect::DeviceTraits;
use celfx::flame::settings::{Method, Sampling, Shape};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;
use celfx::view::Camera;
use glam::DVec3;

use crate::common::flame::{FlameRig, ball, desc};
use crate::common::scenes::camera;
use crate::oracle::{Shot, assert_finite, sums};

const SIZE: [u32; 2] = [96, 72];
const PARTICLES: u32 = 100;

fn base() -> Settings {
    Settings { repetitions: 20, count: 6.0, spread: Some(0.15), size: Some(0.25), ..Settings::paper() }
}

/// Samples, those with a winner, and pixels whose sums differ.
pub fn compared(desc: &Desc, shots: &[Scene]) -> Option<(u64, u64, u64)> {
    let repetitions = desc.settings.repetitions;
    let frame = |method| {
        let mut rig = FlameRig::new(Desc { settings: Settings { method, ..desc.settings.clone() }, ..desc.clone() })?;
        shots.iter().for_each(|shot| rig.render(shot));
        assert_finite("raster", &mut rig);
        Some(sums(&mut rig, repetitions))
    };
    let (tiles, raster) = (frame(Method::Tiles)?, frame(Method::Raster)?);
    let pixels = tiles.hits.len();
    // Another render particle of the same particle may win, too: then only depths differ, by more than rounding.
    let differ = |i: &usize| {
        (tiles.light[*i], tiles.squares[*i], tiles.hits[*i]) != (raster.light[*i], raster.squares[*i], raster.hits[*i])
            || (tiles.depth[*i] - raster.depth[*i]).abs() > 1e-6 * tiles.depth[*i]
    };
    let differing = (0..pixels).filter(differ).count() as u64;
    let hits = tiles.hits.iter().map(|hits| u64::from(*hits)).sum();
    Some((pixels as u64 * u64::from(repetitions), hits, differing))
}

#[test]
fn raster_makes_the_same_picture() {
    let given = ball(PARTICLES, 1);
    let close = Camera { eye: DVec3::new(0.2, 0.1, 1.25), ..camera(0.0) };
    let sobol = Settings { sampling: Sampling::ShuffledSobol, shape: Shape::Cube, flicker: 0.4, ..base() };
    let mut total = (0, 0, 0);
    for (name, settings, camera) in [
        ("tiles", base(), camera(0.0)),
        ("magnified", Settings { size: Some(1.2), ..base() }, camera(30.0)),
        ("close", base(), close),
        ("octaves", Settings { size: Some(2.4), octaves: 6, count: 2.0, ..base() }, close),
        ("Sobol", sobol, camera(0.0)),
        ("pixels", Settings { size: None, size_pixels: Some(3.0), count: 40.0, ..base() }, camera(0.0)),
        ("small", Settings { size: Some(0.01), count: 200.0, repetitions: 8, ..base() }, camera(0.0)),
        ("low", Settings { threshold: -1.0, ..base() }, camera(0.0)),
    ] {
        let shot = Shot { number: 7, ..Shot::new(&given, camera) };
        let Some((samples, hits, differing)) = compared(&desc(SIZE, PARTICLES, settings), &[shot.scene()]) else {
            return;
        };
        println!("{name}: {differing} of {samples} samples differ, {hits} with a winner");
        assert!(hits * 100 > samples, "{name}");
        total = (total.0 + samples, total.1 + hits, total.2 + differing);
    }
    // Corners are rounded once more, and depths are compared as near / z, in which more of them are equal: 1e-4.
    assert!(total.2 as f64 <= 1e-4 * total.0 as f64, "{total:?}");
}

#[test]
fn raster_has_a_scene_and_adds_up() {
    let given = ball(PARTICLES, 1);
    let wall: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| if i % 5 < 2 { f32::INFINITY } else { 3.9 }).collect();
    let effect = Desc { scene: Some(SceneFormat::Buffer), ..desc(SIZE, PARTICLES, base()) };
    let first = Shot { depth: Some(&wall), ..Shot::new(&given, camera(0.0)) }.scene();
    let more = Scene { accumulate: true, particles: None, ..first };
    for shots in [&[first][..], &[first, more, more]] {
        let Some((samples, hits, differing)) = compared(&effect, shots) else { return };
        println!("{} frames: {differing} of {samples} samples differ", shots.len());
        // 1e-4 of what the frames have added up.
        assert!(differing as f64 <= 1e-4 * (samples * shots.len() as u64) as f64 && hits * 20 > samples);
    }
}

/// Ids in any order: of equals the smaller wins with tiles, and what is drawn first with the other.
#[test]
fn ids_draw_the_same() {
    let ids: Vec<u32> = (0..PARTICLES).map(|i| i * 37 % PARTICLES).collect();
    let given = Particles { id: Some(ids), ..ball(PARTICLES, 1) };
    let shot = Shot::new(&given, camera(0.0));
    let Some((samples, _, differing)) = compared(&desc(SIZE, PARTICLES, base()), &[shot.scene()]) else { return };
    assert!(differing as f64 <= 1e-4 * samples as f64, "{differing} of {samples}");
}

/// What raster cannot do is refused by name.
#[test]
fn limits_are_named() {
    use celfx::flame::Flame;
    let refused = |settings: Settings, particles: u32, what: &str| {
        let settings = Settings { method: Method::Raster, ..settings };
        let text =
            Flame::memory(&desc(SIZE, particles, settings), &DeviceTraits::LAVAPIPE).expect_err(what).to_string();
        assert!(text.contains(what), "{text}");
    };
    refused(Settings { repetitions: 4097, ..base() }, 10, "repetitions");
    refused(Settings { adaptive: 0.1, ..base() }, 10, "adaptive");
    refused(Settings { count: 20_000.0, ..base() }, 5000, "SpriteList");
}
