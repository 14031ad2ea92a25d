//! The expected image where something is very small, very large or missing, against repetitions.

use celfx::flame::Settings;
use celfx::flame::settings::Shape;
use celfx::view::Camera;
use glam::DVec3;

use crate::cases::{Case, apart, plain, rgb, settings};
use crate::common::flame::{ball, particles};
use crate::common::scenes;
use crate::stochastic::repeated;

/// How an expected image compares with the mean of repetitions.
#[derive(Debug)]
#[allow(dead_code, reason = "what a failure shows")]
struct Compared {
    /// Sum over the picture, of the sum of the repetitions.
    light: f64,
    coverage: f64,
    /// What is left of the RMS when the repetitions' noise is taken off.
    floor: f64,
    noise: f64,
}

/// Renders both; every number must be finite.
fn compare(case: &Case, repetitions: u32) -> Option<Compared> {
    let mut expected = case.render()?;
    let mut rig = repeated(case, repetitions).render()?;
    let (own, all) = (expected.mean(), rig.mean());
    let finite = |pixels: &[[f32; 4]]| pixels.iter().flatten().all(|c| (0.0..1e6).contains(c));
    assert!(finite(&own) && finite(&all), "{}: {:?}", case.name, case.desc.settings);
    assert!(own.iter().all(|p| p[3] <= 1.0), "{}", case.name);
    assert!(expected.picture().iter().flatten().all(|c| c.is_finite()), "{}", case.name);
    assert!(expected.variance().iter().flatten().all(|c| *c >= 0.0), "{}", case.name);
    let sum = |pixels: &[[f32; 4]], channels: std::ops::Range<usize>| {
        pixels.iter().flat_map(|p| &p[channels.clone()]).map(|c| f64::from(*c)).sum::<f64>()
    };
    let [rms, _] = apart(&own, &rgb(&all));
    let noise = sum(&rig.variance(), 0..3) / (3 * own.len()) as f64 / f64::from(repetitions);
    let compared = Compared {
        light: sum(&own, 0..3) / sum(&all, 0..3),
        coverage: sum(&own, 3..4) / sum(&all, 3..4),
        floor: (rms * rms - noise).max(0.0).sqrt(),
        noise: noise.sqrt(),
    };
    println!("{}: {compared:.5?}", case.name);
    Some(compared)
}

fn looking(eye: [f64; 3], target: [f64; 3], vertical_fov: f64) -> Camera {
    Camera { eye: DVec3::from_array(eye), target: DVec3::from_array(target), vertical_fov, ..Camera::default() }
}

/// What must hold of each: light within `light`, and no more than `floor` RMS beside the noise.
struct Bound {
    case: Case,
    repetitions: u32,
    light: f64,
    floor: f64,
}

/// Most: the bounds that other scenes have. Repetitions know the light of the picture to some 3e-3.
fn usually(name: &'static str, repetitions: u32, case: Case) -> Bound {
    Bound { case: Case { name, ..case }, repetitions, light: 0.01, floor: 2.5e-3 }
}

fn check(bounds: impl IntoIterator<Item = Bound>) {
    let mut wrong = Vec::new();
    for Bound { case, repetitions, light, floor } in bounds {
        let Some(found) = compare(&case, repetitions) else { return };
        // The noise is known to a tenth of its square.
        if !((found.light - 1.0).abs() < light && found.floor < floor.max(0.4 * found.noise)) {
            wrong.push((case.name, found));
        }
    }
    assert!(wrong.is_empty(), "{wrong:.5?}");
}

#[test]
fn small_large_and_missing_things_are_as_repetitions_have_them() {
    let one = |count: f32, temperature| Case {
        particles: particles(&[[0.0, 0.0, 0.0, temperature]]),
        ..Case::new("", [24, 24], 1, Settings { count, ..settings() }, looking([0.0, 0.0, 1.5], [0.0; 3], 30.0))
    };
    check([
        // The table sees no space narrower than a sixteenth of the size: the mask's edges, which all render particles
        // of a particle share here, are as blurred. Bounds are a quarter more than what is measured.
        Bound { light: 0.1, floor: 0.045, ..usually("spread 0", 512, plain().with(|s| s.spread = Some(0.0))) },
        Bound { floor: 6e-3, ..usually("spread a tenth of the size", 512, plain().with(|s| s.spread = Some(0.025))) },
        usually("size a tenth of the spread", 512, plain().with(|s| s.size = Some(0.02))),
        usually("threshold below 0, no alpha", 256, plain().with(|s| (s.threshold, s.alpha_scale) = (-2.0, 0.0))),
        usually("threshold 1", 256, plain().with(|s| s.threshold = 1.0)),
        usually("a quarter of a render particle each", 2048, plain().with(|s| s.count = 0.5)),
        usually("one render particle", 4096, one(1.0, 3000.0)),
        // Many multiply what the table leaves of a single one.
        Bound { floor: 4e-3, ..usually("one particle of many", 256, one(400.0, 2000.0)) },
        Bound { floor: 9e-3, ..usually("opaque", 64, plain().with(|s| s.count = 400.0)) },
        usually("cube", 512, plain().with(|s| s.shape = Shape::Cube)),
    ]);
}

#[test]
fn planes_cut_the_fire_where_they_are() {
    let cut =
        |name, near, far| usually(name, 512, Case { camera: Camera { near, far, ..scenes::camera(25.0) }, ..plain() });
    let camera = looking([0.1, 0.0, 0.2], [0.5, 0.1, -1.0], 70.0);
    let inside = Case::new("", [32, 24], 60, settings(), camera);
    // Sprites next to the camera cover a tenth of the picture: a thousand repetitions know its light to 1 %.
    let inside = Bound { light: 0.03, floor: 6e-3, ..usually("inside", 1024, inside) };
    check([cut("near plane in the fire", 3.9, 100.0), cut("far plane in the fire", 0.1, 4.0), inside]);
}

/// However far away, and wherever between the pixels: the light of repetitions, each of whose sprites is a pixel then.
#[test]
fn fire_below_a_pixel_keeps_its_light() {
    let at = |name, depth: f64, across: f64| {
        let pixel = depth * 20.0_f64.to_radians().tan() / 6.0;
        let camera = Camera { far: 1e3, ..looking([across * pixel, 0.0, depth], [across * pixel, 0.0, 0.0], 40.0) };
        let settings = Settings { count: 3000.0 / depth as f32, ..settings() };
        // Some 1,000 render particles are seen in all: light is known to 3 %. So few pixels are lit that RMS are small.
        Bound { light: 0.09, floor: 1e-3, ..usually(name, 4096, Case::new("", [16, 12], 60, settings, camera)) }
    };
    check([at("three pixels", 30.0, 0.0), at("a pixel's corner", 100.0, 0.0), at("a pixel's edge", 100.0, 0.5)]);
}

#[test]
fn what_nobody_sees_is_empty() {
    let none = |s: &mut Settings| s.threshold = 1.0 + f32::EPSILON;
    let cold = Case { particles: particles(&[[0.0, 0.0, 0.0, 100.0]; 8]), ..plain() };
    let dropped = Case { particles: particles(&[[0.0, 0.0, f32::NAN, 1e3], [0.0, 0.0, 0.0, -1.0]]), ..plain() };
    for case in
        [plain().with(none), plain().with(|s| s.count = 0.0), plain().with(|s| s.size = Some(0.0)), cold, dropped]
    {
        let Some(mut rig) = case.render() else { return };
        assert!(rig.picture().iter().flatten().all(|c| *c == 0.0));
        assert!(rig.mean().iter().flatten().all(|c| *c == 0.0) && rig.nearest().iter().all(|z| z.is_infinite()));
    }
    let Some(mut rig) = plain().render() else { return };
    rig.frame(&ball(0, 1), scenes::camera(0.0));
    assert!(rig.picture().iter().flatten().all(|c| *c == 0.0));
}
