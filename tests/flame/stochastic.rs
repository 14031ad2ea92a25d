//! Repetitions against the reference, which makes the same decisions in f64: integer sums bit for bit, except where
//! rounding decides. Such samples are counted, and so are those that differ.

use celfx::data::Particles;
use celfx::flame::settings::{Sampling, Shape};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::view::Camera;
use glam::DVec3;

use crate::common::flame::{FlameRig, ball, desc};
use crate::common::scenes::{camera, random};
use crate::common::views;
use crate::oracle::{Shot, Tally, check};

const SIZE: [u32; 2] = [96, 72];
const PARTICLES: u32 = 150;

/// The specification's: of all samples, so many may differ.
const SHARE: f64 = 1e-5;

pub fn base() -> Settings {
    Settings { repetitions: 24, count: 8.0, spread: Some(0.15), size: Some(0.2), ..Settings::paper() }
}

fn rig(settings: Settings) -> Option<FlameRig> {
    FlameRig::new(desc(SIZE, PARTICLES, settings))
}

/// Checks a look; what it sees must be worth it.
fn look(name: &str, settings: Settings, camera: Camera, total: &mut Tally) {
    let Some(mut rig) = rig(settings) else { return };
    see(name, &mut rig, camera, total);
}

/// The same of an effect that may have rendered others before.
fn see(name: &str, rig: &mut FlameRig, camera: Camera, total: &mut Tally) {
    let particles = ball(PARTICLES, 1);
    let tally = check(name, rig, &Shot::new(&particles, camera));
    assert!(tally.hits * 50 > tally.samples, "{name}: {tally:?} is empty");
    total.add(tally);
}

fn from(x: f64, y: f64, z: f64) -> Camera {
    Camera { eye: DVec3::new(x, y, z), ..camera(0.0) }
}

#[test]
fn samplings_and_shapes() {
    let mut total = Tally::default();
    look("independent", base(), camera(0.0), &mut total);
    look("cube", Settings { shape: Shape::Cube, ..base() }, camera(40.0), &mut total);
    let sobol = Settings { sampling: Sampling::ShuffledSobol, ..base() };
    look("Sobol", sobol.clone(), camera(-20.0), &mut total);
    // Not a power of two, and in a cube.
    let odd = Settings { repetitions: 37, shape: Shape::Cube, ..sobol.clone() };
    look("Sobol in a cube", odd, camera(-20.0), &mut total);
    look("Sobol once", Settings { repetitions: 1, ..sobol }, camera(0.0), &mut total);
    look("once", Settings { repetitions: 1, ..base() }, camera(0.0), &mut total);
    total.assert_few("samplings and shapes", SHARE);
}

#[test]
fn flicker() {
    let particles = ball(PARTICLES, 1);
    let mut total = Tally::default();
    for sampling in [Sampling::Independent, Sampling::ShuffledSobol] {
        for flicker in [0.3, 1.0] {
            let Some(mut rig) = rig(Settings { flicker, sampling, ..base() }) else { return };
            // The last of these overflows any product of two words.
            for number in [0, 1, 1000, u32::MAX] {
                let shot = Shot { number, ..Shot::new(&particles, camera(0.0)) };
                total.add(check(&format!("{sampling:?} {flicker} {number}"), &mut rig, &shot));
            }
        }
    }
    total.assert_few("flicker", SHARE);
}

/// Sprites of all sizes: every level of the mask, down to those far below a pixel.
#[test]
fn levels() {
    let mut total = Tally::default();
    // At the nearest particle a metre is some 41 pixels.
    for (size, count) in [(1.2, 3.0), (0.6, 4.0), (0.3, 6.0), (0.15, 8.0), (0.08, 20.0), (0.04, 60.0), (0.012, 300.0)] {
        let settings = Settings { size: Some(size), count, alpha_scale: 8.0, ..base() };
        look(&format!("{size} m"), settings, camera(0.0), &mut total);
    }
    total.assert_few("levels", SHARE);
}

#[test]
fn sizes_in_pixels() {
    let mut total = Tally::default();
    for (pixels, count) in [(0.6, 300.0), (1.0, 100.0), (5.0, 10.0), (33.0, 3.0), (80.0, 2.0)] {
        let (size, size_pixels) = (None, Some(pixels));
        let settings = Settings { size, size_pixels, count, alpha_scale: 8.0, ..base() };
        look(&format!("{pixels} pixels"), settings, camera(0.0), &mut total);
    }
    total.assert_few("sizes in pixels", SHARE);
}

#[test]
fn cameras() {
    let mut total = Tally::default();
    let (Some(mut usual), Some(mut spread)) = (rig(base()), rig(Settings { spread: Some(0.4), ..base() })) else {
        return;
    };
    see("near", &mut usual, from(0.2, 0.1, 1.25), &mut total);
    // Inside of the cloud and of some particles' balls; the near plane cuts through others.
    see("inside", &mut spread, from(0.1, 0.05, 0.2), &mut total);
    let close = Camera { near: 0.01, ..from(0.1, 0.05, 0.2) };
    see("inside and close", &mut spread, close, &mut total);
    // Seen at the edge of a wide picture, where squares are far from round.
    let wide = Camera { vertical_fov: 120.0, target: DVec3::new(2.4, 1.0, 0.0), ..from(0.0, 0.0, 1.6) };
    see("off axis", &mut usual, wide, &mut total);
    let cut = Camera { near: 3.7, far: 4.3, ..camera(0.0) };
    see("cut", &mut usual, cut, &mut total);
    look("cut in a cube", Settings { shape: Shape::Cube, ..base() }, cut, &mut total);
    see("no end", &mut usual, Camera { far: f64::INFINITY, ..camera(0.0) }, &mut total);
    let rolled = Camera { up: DVec3::new(1.0, 0.3, -0.2), ..from(-2.0, 2.0, -2.0) };
    see("rolled", &mut usual, rolled, &mut total);
    total.assert_few("cameras", SHARE);
}

#[test]
fn projections_of_any_kind() {
    let mut total = Tally::default();
    let particles = ball(PARTICLES, 1);
    for (settings, names) in [(base(), 0..11), (Settings { shape: Shape::Cube, ..base() }, 5..11)] {
        let Some(mut rig) = rig(settings) else { return };
        for (name, view) in views::of(&camera(20.0), SIZE, camera(20.0).eye.length()).drain(names) {
            let tally = check(name, &mut rig, &Shot { view: Some(view), ..Shot::new(&particles, camera(20.0)) });
            assert!(tally.hits * 50 > tally.samples, "{name}: {tally:?} is empty");
            total.add(tally);
        }
    }
    // Sprites below a pixel, whose sides differ, and of a size in pixels.
    for settings in [Settings { size: Some(0.02), ..base() }, Settings { size: None, size_pixels: Some(3.0), ..base() }]
    {
        let Some(mut rig) = rig(settings) else { return };
        for (name, view) in views::of(&camera(20.0), SIZE, camera(20.0).eye.length()) {
            if name == "squeezed" || name == "orthographic turned" {
                total.add(check(name, &mut rig, &Shot { view: Some(view), ..Shot::new(&particles, camera(20.0)) }));
            }
        }
    }
    total.assert_few("projections", SHARE);
}

#[test]
fn thresholds() {
    let mut total = Tally::default();
    for threshold in [-1.0, 0.05, 1.0] {
        for size in [0.25, 1.2] {
            let settings = Settings { threshold, size: Some(size), count: 4.0, ..base() };
            look(&format!("{threshold} {size}"), settings, camera(0.0), &mut total);
        }
    }
    total.assert_few("thresholds", SHARE);
}

#[test]
fn a_scene_hides_what_is_behind_it() {
    let particles = ball(PARTICLES, 1);
    // A slope through the cloud, a hole in it, and a wall in front of all.
    let depth: Vec<f32> = (0..SIZE[0] * SIZE[1])
        .map(|i| match (i % SIZE[0], i / SIZE[0]) {
            (x, _) if x % 7 == 3 => f32::INFINITY,
            (_, y) if y < 10 => 0.5,
            (x, y) => 3.2 + 0.01 * x as f32 + 0.007 * y as f32,
        })
        .collect();
    let mut total = Tally::default();
    for size in [0.2, 1.2] {
        let settings = Settings { size: Some(size), ..base() };
        let scene = Some(SceneFormat::Buffer);
        let Some(mut rig) = FlameRig::new(Desc { scene, ..desc(SIZE, PARTICLES, settings) }) else { return };
        let shot = Shot { depth: Some(&depth), ..Shot::new(&particles, camera(0.0)) };
        let hidden = check("scene", &mut rig, &shot);
        let open = vec![f32::INFINITY; depth.len()];
        let shot = Shot { depth: Some(&open), ..shot };
        let seen = check("open", &mut rig, &shot);
        assert!(hidden.hits < seen.hits * 9 / 10 && hidden.hits > 0, "{hidden:?} of {seen:?}");
        total.add(hidden);
        total.add(seen);
    }
    total.assert_few("scene", SHARE);
}

/// Draws belong to ids, not to rows.
#[test]
fn ids() {
    let particles = ball(PARTICLES, 1);
    let Some(mut rig) = rig(base()) else { return };
    let mut total = Tally::default();
    let given = [
        (0..PARTICLES).rev().collect::<Vec<u32>>(),
        (0..PARTICLES).map(|i| i * 37 % PARTICLES).collect(),
        (0..PARTICLES).map(|i| (random(8, i, 0) * 4e9) as u32).collect(),
        // All alike: then rows decide ties, and all draw the same.
        vec![u32::MAX; PARTICLES as usize],
    ];
    for (index, ids) in given.into_iter().enumerate() {
        let particles = Particles { id: Some(ids), ..particles.clone() };
        total.add(check(&format!("ids {index}"), &mut rig, &Shot::new(&particles, camera(0.0))));
    }
    total.assert_few("ids", SHARE);
}

/// Particles far from the origin of the world, and a world of another scale.
#[test]
fn worlds() {
    let mut total = Tally::default();
    for (scale, shift) in [(1e-3, 0.0), (1e3, 0.0), (1.0, 100.0)] {
        let settings = Settings { spread: Some(0.15 * scale), size: Some(0.2 * scale), ..base() };
        let Some(mut rig) = rig(settings) else { return };
        let mut particles = ball(PARTICLES, 1);
        particles.position.iter_mut().flatten().for_each(|x| *x = *x * scale + shift);
        let by = |p: DVec3| p * f64::from(scale) + f64::from(shift);
        let (near, far) = (0.1 * f64::from(scale), 100.0 * f64::from(scale));
        let camera = Camera { eye: by(camera(0.0).eye), target: by(DVec3::ZERO), near, far, ..camera(0.0) };
        let tally = check(&format!("{scale} {shift}"), &mut rig, &Shot::new(&particles, camera));
        assert!(tally.hits * 50 > tally.samples, "{tally:?}");
        total.add(tally);
    }
    total.assert_few("worlds", SHARE);
}

/// The hottest of what is in the nearest slab of depth gives the colour.
#[test]
fn emission() {
    let mut total = Tally::default();
    let near = from(0.2, 0.1, 1.25);
    for (name, settings, camera) in [
        ("thin slabs", Settings { emission: Some(0.2), ..base() }, camera(0.0)),
        ("usual slabs", Settings { emission: None, ..base() }, camera(0.0)),
        ("one slab, or two", Settings { emission: Some(100.0), ..base() }, camera(-20.0)),
        ("near", Settings { emission: Some(1.5), shape: Shape::Cube, ..base() }, near),
        ("small", Settings { emission: Some(8.0), size: Some(0.04), count: 60.0, ..base() }, camera(0.0)),
        ("pixels", Settings { emission: Some(2.0), size: None, size_pixels: Some(9.0), ..base() }, camera(0.0)),
        // Then depths are all that there is.
        (
            "no depth",
            Settings { emission: Some(2.0), spread: Some(0.0), size: None, size_pixels: Some(9.0), ..base() },
            camera(0.0),
        ),
    ] {
        look(name, settings, camera, &mut total);
    }
    total.assert_few("emission", SHARE);
}

#[test]
fn emission_before_a_scene() {
    let particles = ball(PARTICLES, 1);
    let depth: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| 3.0 + 0.02 * (i % SIZE[0]) as f32).collect();
    let desc = desc(SIZE, PARTICLES, Settings { emission: Some(3.0), ..base() });
    let Some(mut rig) = FlameRig::new(Desc { scene: Some(SceneFormat::Buffer), ..desc }) else { return };
    let tally = check("scene", &mut rig, &Shot { depth: Some(&depth), ..Shot::new(&particles, camera(0.0)) });
    assert!(tally.hits * 50 > tally.samples, "{tally:?}");
    tally.assert_few("scene", SHARE);
}

/// What a cooler shell hides shines through it.
#[test]
fn a_hot_core_shines_through_what_is_cooler() {
    let mut rows: Vec<[f32; 4]> = Vec::new();
    let particles = ball(600, 1);
    for [x, y, z] in &particles.position {
        rows.push([*x, *y, *z, if x.hypot(*y).hypot(*z) < 0.6 { 2900.0 } else { 1200.0 }]);
    }
    let particles = crate::common::flame::particles(&rows);
    let middle = |emission: f32| {
        let settings = Settings { emission: Some(emission), count: 20.0, ..base() };
        let mut rig = FlameRig::new(desc(SIZE, 600, settings))?;
        rig.frame(&particles, camera(0.0));
        let mean = rig.mean();
        let brightness = |[r, g, b, a]: [f32; 4]| if a > 0.0 { (r + g + b) / a } else { 0.0 };
        let middle = (30..42).flat_map(|y| (42..54).map(move |x| y * SIZE[0] as usize + x));
        Some(middle.map(|i| brightness(mean[i])).sum::<f32>() / 144.0)
    };
    let (Some(paper), Some(half), Some(through)) = (middle(0.0), middle(1.0), middle(6.0)) else { return };
    println!("brightness {paper}, {half}, {through}");
    assert!(half > paper && through > 1.3 * half && through > 2.0 * paper, "{paper} {half} {through}");
}

/// Finer noise in sprites that are magnified.
#[test]
fn octaves() {
    let mut total = Tally::default();
    let close = Camera { near: 0.01, ..from(0.1, 0.05, 0.5) };
    for (name, settings, camera) in [
        ("one", Settings { size: Some(2.4), octaves: 1, count: 2.0, ..base() }, camera(0.0)),
        ("all", Settings { size: Some(2.4), octaves: 6, count: 2.0, ..base() }, close),
        ("low threshold", Settings { size: Some(1.2), octaves: 6, threshold: 0.05, count: 2.0, ..base() }, close),
        ("high threshold", Settings { size: Some(1.2), octaves: 6, threshold: 1.0, count: 4.0, ..base() }, close),
        ("pixels", Settings { size: None, size_pixels: Some(90.0), octaves: 3, count: 2.0, ..base() }, camera(0.0)),
        (
            "as users have it",
            Settings { size: Some(0.6), count: 4.0, spread: base().spread, ..Settings::default() },
            close,
        ),
    ] {
        look(name, settings, camera, &mut total);
    }
    total.assert_few("octaves", SHARE);
}

/// Where no sprite is magnified there are none, to the bit.
#[test]
fn octaves_are_for_near_sprites() {
    let particles = ball(PARTICLES, 1);
    let light = |octaves: u32, size: f32| {
        let mut rig = rig(Settings { octaves, size: Some(size), ..base() })?;
        rig.frame(&particles, camera(0.0));
        Some(crate::oracle::sums(&mut rig, base().repetitions).light)
    };
    // At the nearest particle a metre is some 41 pixels, of which 64 have a texel each.
    assert_eq!(light(0, 1.5), light(6, 1.5));
    let (Some(none), Some(some)) = (light(0, 3.0), light(6, 3.0)) else { return };
    assert_ne!(none, some);
}
