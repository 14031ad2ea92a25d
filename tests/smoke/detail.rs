//! The density, smoothed, against the reference.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::smoke::reference::detail;
use celfx::smoke::{Sequence, Settings};
use celfx::view::{Camera, Light};

use crate::common::bench::{Bench, Given};
use crate::common::rig::{Rig, scene};
use crate::common::scenes::{camera, desc, direction, puffs, random, volume};

fn check(name: &str, volume: &Volume, detail: Option<f32>) {
    let settings = Settings { particles: 1, fade: 0, detail, ..Settings::default() };
    let Some(mut bench) = Bench::new(desc([8, 8], volume.dimensions, settings.clone())) else { return };
    let (camera, light) = (Camera::default(), Light::default());
    bench.run(&Given { camera, light, volume, frames: 0, rendered: false, omit: &[] });
    let actual: Vec<f32> = bench.read(layout::DETAILED, volume.density.len());
    let expected = detail::smoothed(&volume.grid(), &settings);
    let finite = volume.density.iter().filter(|d| d.is_finite());
    let largest = finite.fold(0.0_f64, |largest, d| largest.max(f64::from(d.abs())));
    for (i, (actual, expected)) in actual.iter().zip(expected.iter()).enumerate() {
        let error = (f64::from(*actual) - f64::from(*expected)).abs();
        // Three sums of at most 49 products each, of weights that are good to a few units in the last place.
        assert!(error <= 4e-6 * largest, "{name}: voxel {i}: {actual}, expected {expected}");
    }
}

#[test]
fn a_smoothed_density_is_that_of_the_reference() {
    let noise = |n: [u32; 3], h| volume(n, h, [0.0; 3], |x, y, z| random(2, x + 100 * (y + 100 * z), 0) - 0.3);
    check("by itself", &noise([20, 70, 33], [0.1; 3]), None);
    check("by itself, one voxel", &noise([1; 3], [0.1; 3]), None);
    for (n, h) in [([33, 17, 20], [0.1; 3]), ([16, 40, 31], [0.1, 0.05, 0.2]), ([1, 60, 2], [0.1; 3])] {
        for detail in [1e-3, 0.1, 0.23, 0.8] {
            check(&format!("{n:?} of {h:?}, {detail}"), &noise(n, h), Some(detail));
        }
    }
    let wild = volume([18; 3], [0.1; 3], [0.0; 3], |x, y, z| {
        let kinds = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 1e-30, 3.0, 0.0];
        kinds[(random(5, x + 18 * (y + 18 * z), 0) * 8.0) as usize]
    });
    check("not finite", &wild, Some(0.2));
}

#[test]
fn too_wide_a_gaussian_is_refused_by_name() {
    let settings = Settings { particles: 10, detail: Some(1.7), ..Settings::default() };
    let Some(mut rig) = Rig::new(desc([16, 16], [20; 3], settings)) else { return };
    let volume = puffs(20, 0.0);
    let scene = scene(Sequence::Restart, camera(0.0), direction(-1.0, -1.0, -1.0), Some(&volume));
    let said = rig.offline().frame(&scene).expect_err("17 voxels").to_string();
    assert!(said.contains("smoke.detail") && said.contains("at most 16 voxels"), "{said}");
}
