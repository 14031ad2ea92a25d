//! How close the expected image is: to its own table in f64, to the exact kernel, to many bins.

use celfx::flame::reference::expected::{self, Bins, Expected};
use celfx::flame::settings::Shape;
use celfx::flame::{SceneFormat, Settings};
use celfx::view::Camera;
use glam::DVec3;

use crate::cases::{self, Case, apart, near, parallel, plain, rgb, settings, usual, wide};
use crate::common::flame::{FlameRig, moving};
use crate::common::views;
use crate::table::{Weighed, both};

/// Of 8 bits.
const STEP: f64 = 1.0 / 255.0;

/// Cases in which the tables and look-ups take every way that they have.
fn ways() -> Vec<Case> {
    let tall = Camera { eye: DVec3::new(2.0, 1.5, 3.0), target: DVec3::ZERO, ..Camera::default() };
    let cube = Settings { shape: Shape::Cube, ..settings() };
    // The whole fire is some pixels wide, a particle's reach a fraction of one.
    let far = Camera { eye: DVec3::new(0.0, 0.0, 160.0), target: DVec3::ZERO, far: 1e3, ..Camera::default() };
    // What has the same space comes one after the other, so that the reference makes a table for all of it.
    vec![
        plain(),
        walled(),
        plain().with(|s| s.bins = 1),
        plain().with(|s| s.threshold = 0.0),
        wide(),
        near(),
        Case::new("far", [24, 18], 40, settings(), far),
        Case::new("cube", [33, 41], 40, cube, tall),
        plain().with(|s| s.spread = Some(0.02)),
        plain().with(|s| s.size = Some(0.03)),
        drawn_out(plain()),
        drawn_out(wide()),
    ]
}

/// The same, drawn out along its motion.
fn drawn_out(case: Case) -> Case {
    let case = Case { name: "drawn out", particles: moving(case.particles.clone(), 5), ..case };
    case.with(|s| s.stretch = 0.2)
}

/// A wall through the middle of the fire, in the left half of the picture.
fn walled() -> Case {
    let mut case = Case { name: "walled", ..plain() };
    case.desc.scene = Some(SceneFormat::Buffer);
    let [width, height] = case.desc.size;
    case.depth = Some((0..width * height).map(|i| if i % width < width / 2 { 4.05 } else { f32::INFINITY }).collect());
    case
}

/// Single precision: of the some 200 roundings that a pixel's bins and particles make each is 6e-8 of a number below 1,
/// and sums over a table's node up to a thousand texels. Measured: 3e-6.
const SINGLE: f64 = 1e-5;

/// Seen through projections of every kind.
fn projections() -> Vec<Case> {
    let case = plain();
    let views = views::of(&case.camera, case.desc.size, case.camera.eye.length());
    let cube = Settings { shape: Shape::Cube, ..settings() };
    let turned = views.last().expect("views").1;
    let of = |(name, view)| Case { name, view: Some(view), ..case.clone() };
    // Every second: each differs from a camera in another way, or in several.
    let mut cases: Vec<Case> = views.into_iter().skip(2).step_by(2).map(of).collect();
    cases.push(Case { view: Some(turned), ..Case::new("cube, turned", case.desc.size, 40, cube, case.camera) });
    cases
}

#[test]
fn the_device_integrates_its_table() {
    for case in ways().into_iter().chain(projections()) {
        let Some((mut rig, weighed, image)) = both(&case) else { return };
        check_weights(&case, &mut rig, &weighed);
        let mean = rig.mean();
        let [rms, most] = apart(&mean, &image.mean);
        println!("{}: {rms:.1e} RMS, {most:.1e} at most of what f64 makes of the same table", case.name);
        // What is drawn out has its places from a few roundings more, and one of them may turn which node is the nearest.
        let bound = if case.desc.settings.stretches() { 1e-4 } else { SINGLE };
        assert!(rms < SINGLE && most < bound, "{}, {:?}: {most}", case.name, case.desc.settings);
        let [_, most] = apart(&rig.variance(), &image.variance());
        assert!(most < bound, "{}: variance {most}", case.name);
        let coverage = mean.iter().zip(&image.coverage).map(|(m, c)| crate::common::apart(m[3], *c));
        let most = coverage.fold(0.0, f64::max);
        assert!(most < 3.0 * bound, "{}: coverage {most}", case.name);
        let seen: f32 = mean.iter().map(|m| m[3]).sum();
        assert!(seen > 0.005, "{}: nothing is seen", case.name);
        check_depths(&case, &mut rig, &image);
    }
}

/// Mean depths, where enough is seen for a rounding of the coverage not to move them.
fn check_depths(case: &Case, rig: &mut FlameRig, image: &Expected) {
    let pixels = rig.nearest().into_iter().zip(rig.mean()).zip(&image.depth);
    for (i, ((depth, mean), expected)) in pixels.enumerate() {
        // The device has a particle's bounds with a margin; what it does not list there has no share.
        assert_eq!(depth.is_finite(), mean[3] > 0.0, "{}: pixel {i}", case.name);
        // A bin that a wall ends is as deep as a whole one to the device.
        if mean[3] > 0.01 && case.depth.is_none() {
            let difference = crate::common::apart(depth, *expected);
            assert!(difference < 1e-3 * expected, "{}: pixel {i}: {depth}, {expected}", case.name);
        }
    }
}

/// Particles' classes and weights on the device.
fn check_weights(case: &Case, rig: &mut FlameRig, weighed: &[Weighed]) {
    for (particle, weighed) in rig.prepared().iter().zip(weighed).filter(|(p, _)| p.count > 0) {
        let weight = f64::from(particle.weight);
        assert_eq!(particle.class_index as usize, weighed.class, "{}", case.name);
        // A few roundings of one product, and the square of what a depth has lost by cancelling.
        assert!((weight - weighed.weight).abs() <= 1e-5 * weighed.weight, "{}: {weight}, {weighed:?}", case.name);
    }
}

/// The device's frame, and without a table that of its mask, particles and borders of bins. Sprites in 64 x 64 cells: for
/// minified masks some 1e-4 close (`reference::expected`).
fn exact(case: &Case, count: Option<usize>) -> Option<(FlameRig, Expected)> {
    let mut rig = case.render()?;
    let (mask, level) = (cases::device_mask(&mut rig), cases::level(case, &mut rig));
    let (particles, bins) = (cases::prepared(case, &mut rig), cases::bins(&mut rig));
    let bins = Bins { count: count.unwrap_or(bins.count), ..bins };
    let image = expected::render(&case.frame(&mask, level), &particles, bins, 64);
    Some((rig, image))
}

/// What the table leaves of the exact kernel, with the same bins.
#[test]
fn the_table_is_close_to_the_exact_kernel() {
    // A quarter of a step of 8 bits. The specified 3e-4 takes four times the table: more places, and a class of its own
    // for each particle; dense fire multiplies what each particle lacks.
    let bound = STEP / 4.0;
    for case in [plain(), parallel()] {
        let Some((mut rig, image)) = exact(&case, None) else { return };
        let [rms, most] = apart(&rig.mean(), &image.mean);
        println!("{}: {rms:.2e} RMS, {most:.1e} at most of the exact kernel", case.name);
        assert!(rms < bound, "{}: {rms}", case.name);
    }
}

/// All there is between the image and the integral: table, slanted rays in steps along the axis, bins.
#[test]
fn the_image_is_close_to_the_integral() {
    // Half a step of 8 bits is what rounding the picture takes.
    let bound = STEP / 2.0;
    for case in [plain(), wide(), near(), usual()] {
        let Some((mut rig, image)) = exact(&case, Some(128)) else { return };
        let [rms, most] = apart(&rig.mean(), &image.mean);
        println!("{}: {rms:.2e} RMS, {most:.1e} at most of the integral", case.name);
        assert!(rms < bound, "{}: {rms}", case.name);
    }
}

#[test]
fn bins_converge_to_second_order() {
    for case in [plain(), parallel()] {
        let Some(mut many) = case.with(|s| s.bins = 1024).render() else { return };
        let truth = rgb(&many.mean());
        let error = |bins| {
            let mut rig = case.with(|s| s.bins = bins).render()?;
            Some(apart(&rig.mean(), &truth)[0])
        };
        let Some(errors) = [16, 32, 64].map(error).into_iter().collect::<Option<Vec<f64>>>() else { return };
        println!("{}: {errors:.6?} RMS with 16, 32, 64 bins", case.name);
        // The specified bound.
        assert!(errors[1] < 5e-4, "{}: {errors:?}", case.name);
        // A second order is a factor of 4, which scatters by what particles lie on borders of bins; a first order would be
        // 2. With 64 bins, borders lie closer than the table's depths, between which it is linear: less is gained.
        assert!(errors[0] / errors[1] > 2.8 && errors[0] / errors[2] > 5.5, "{}: {errors:?}", case.name);
    }
}
