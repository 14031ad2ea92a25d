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
    assert!(expected.picture().iter().flatten().all(|c| c.is_finite()), "{}", case.name);
    assert!(expected.variance().iter().flatten().all(|c| *c >= 0.0), "{}", case.name);
    assert!(own.iter().all(|p| p[3] <= 1.0), "{}", case.name);
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
    if case.particles.position.len() < 100 {
        use celfx::flame::reference::{expected, stochastic};
        let (mask, level) = (crate::cases::device_mask(&mut expected), crate::cases::level(case, &mut expected));
        let (particles, bins) = (crate::cases::prepared(case, &mut expected), crate::cases::bins(&mut expected));
        let image = expected::render(&case.frame(&mask, level), &particles, bins, 64);
        let e: f64 = image.mean.iter().flatten().sum();
        let sums = stochastic::render(&case.frame(&mask, level), &particles, 0..200, stochastic::Rounding::NONE);
        let b = f64::from(f32::from_bits(crate::cases::control(&mut expected).brightest));
        let st: f64 = sums.mean(b).iter().flatten().sum();
        println!("      level {level} bins {bins:?} dev exp {:.4} dev sto {:.4} ref exp {e:.4} ref sto(200) {st:.4} rms exp-ref {:?}", sum(&own,0..3), sum(&all,0..3), apart(&own, &image.mean));
    }
    Some(compared)
}

fn looking(eye: [f64; 3], target: [f64; 3], vertical_fov: f64) -> Camera {
    Camera { eye: DVec3::from_array(eye), target: DVec3::from_array(target), vertical_fov, ..Camera::default() }
}

fn named(name: &'static str, case: Case) -> Case {
    Case { name, ..case }
}

#[test]
fn extremes_are_as_repetitions_have_them() {
    let ahead = |z| looking([0.0, 0.0, z], [0.0, 0.0, 0.0], 40.0);
    let one = |count: f32, temperature| Case {
        particles: particles(&[[0.0, 0.0, 0.0, temperature]]),
        ..Case::new("", [24, 24], 1, Settings { count, ..settings() }, looking([0.0, 0.0, 1.5], [0.0; 3], 30.0))
    };
    let near_far = |near, far| Camera { near, far, ..scenes::camera(25.0) };
    let cut = |name, camera| Case { camera, ..named(name, plain()) };
    let cases = [
        (named("spread 0", plain().with(|s| s.spread = Some(0.0))), 1024),
        (named("spread a tenth of the size", plain().with(|s| s.spread = Some(0.025))), 1024),
        (named("size a tenth of the spread", plain().with(|s| s.size = Some(0.02))), 2048),
        (named("threshold 0", plain().with(|s| s.threshold = 0.0)), 1024),
        (named("threshold below 0", plain().with(|s| s.threshold = -2.0)), 1024),
        (named("threshold 0, alpha 0", plain().with(|s| (s.threshold, s.alpha_scale) = (0.0, 0.0))), 1024),
        (named("threshold 1", plain().with(|s| s.threshold = 1.0)), 1024),
        (named("a hundredth of a render particle each", plain().with(|s| s.count = 0.5)), 4096),
        (named("one render particle", one(1.0, 3000.0)), 8192),
        (named("one particle, many render particles", one(400.0, 2000.0)), 512),
        (named("opaque", plain().with(|s| s.count = 400.0)), 256),
        (named("cube", plain().with(|s| s.shape = Shape::Cube)), 1024),
        (named("inside", Case::new("", [32, 24], 60, settings(), looking([0.1, 0.0, 0.2], [0.5, 0.1, -1.0], 70.0))), 1024),
        (cut("near plane in the fire", near_far(3.9, 100.0)), 1024),
        (cut("far plane in the fire", near_far(0.1, 4.0)), 1024),
        (named("few pixels", Case::new("", [16, 12], 60, settings(), ahead(30.0))), 4096),
        (named("below a pixel", Case::new("", [16, 12], 60, settings(), ahead(300.0)).with(|s| s.count = 100.0)), 16_384),
    ];
    let mut wrong = Vec::new();
    for (case, repetitions) in cases {
        let mut case = case;
        if case.name == "below a pixel" {
            case.camera.far = 1e3;
        }
        let Some(found) = compare(&case, repetitions) else { return };
        if !((found.light - 1.0).abs() < 0.01 && found.floor < 4e-3) {
            wrong.push((case.name, found));
        }
    }
    assert!(wrong.is_empty(), "{wrong:.5?}");
}

#[test]
fn what_nobody_sees_is_empty() {
    let none = |s: &mut Settings| s.threshold = 1.0 + f32::EPSILON;
    let cold = Case { particles: particles(&[[0.0, 0.0, 0.0, 100.0]; 8]), ..plain() };
    let dropped = Case { particles: particles(&[[0.0, 0.0, f32::NAN, 1e3], [0.0, 0.0, 0.0, -1.0]]), ..plain() };
    for case in [plain().with(none), plain().with(|s| s.count = 0.0), plain().with(|s| s.size = Some(0.0)), cold, dropped] {
        let Some(mut rig) = case.render() else { return };
        assert!(rig.picture().iter().flatten().all(|c| *c == 0.0));
        assert!(rig.mean().iter().flatten().all(|c| *c == 0.0) && rig.nearest().iter().all(|z| z.is_infinite()));
    }
    let Some(mut rig) = plain().render() else { return };
    rig.frame(&ball(0, 1), scenes::camera(0.0));
    assert!(rig.picture().iter().flatten().all(|c| *c == 0.0));
}
#[test]
fn probe_shift() {
    use celfx::flame::reference::expected;
    for z in [30.0, 60.0, 100.0, 300.0] {
        let (mut all, mut list) = ([0.0; 2], vec![]);
        for k in 0..6 {
            let px = z * 20.0_f64.to_radians().tan() / 6.0;
            let s = [0.17 * f64::from(k) * px, 0.41 * f64::from(k) * px];
            let mut camera = looking([s[0], s[1], z], [s[0], s[1], 0.0], 40.0);
            camera.far = 1e3;
            let case = Case::new("x", [16, 12], 60, Settings { count: 3000.0 / z as f32, ..settings() }, camera);
            let Some(mut rig) = case.render() else { return };
            let (mask, level) = (crate::cases::device_mask(&mut rig), crate::cases::level(&case, &mut rig));
            let (particles, bins) = (crate::cases::prepared(&case, &mut rig), crate::cases::bins(&mut rig));
            let image = expected::render(&case.frame(&mask, level), &particles, bins, 64);
            let e: f64 = image.mean.iter().flatten().sum();
            let d: f64 = rgb(&rig.mean()).iter().flatten().sum();
            list.push((d / e * 1000.0).round() / 1000.0);
            all[0] += d;
            all[1] += e;
        }
        println!("SHIFT z {z} {list:?} all {:.3}", all[0] / all[1]);
    }
}
