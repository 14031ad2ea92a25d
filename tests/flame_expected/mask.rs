//! The layer `flame.mask`, and what its levels let pass.

use celfx::flame::Settings;
use celfx::flame::reference::mask::{Mask, SIDE};
use celfx::low_level::flame::params::MASK_LEVELS;
use celfx::view::Camera;
use glam::DVec3;

use crate::cases::device_mask;
use crate::common::flame::{FlameRig, desc, particles};

/// Looks along -z from the origin.
fn camera() -> Camera {
    Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, ..Camera::default() }
}

#[test]
fn the_mask_is_that_of_the_definition() {
    for (seed, variants) in [(1, 16), (0, 1), (u32::MAX, 64)] {
        let of_seed = celfx::flame::Desc { seed, ..desc([16, 16], 1, Settings { variants, ..Settings::paper() }) };
        let Some(mut rig) = FlameRig::new(of_seed) else { return };
        rig.frame(&particles(&[[0.0, 0.0, -1.0, 2000.0]]), camera());
        let (device, exact) = (rig.mask(), Mask::new(seed, variants));
        assert_eq!(device.len(), variants as usize * SIDE * SIDE);
        // Noise is a sum of some 60 products of numbers below 1, each rounded to 6e-8 of it, and a root.
        let apart = device.iter().zip(exact.texels()).map(|(a, b)| crate::common::apart(*a, *b)).fold(0.0, f64::max);
        println!("mask of seed {seed}: {apart:.1e} of f64");
        assert!(apart < 1e-6, "seed {seed}: {apart}");
        for (i, alpha) in device.iter().enumerate() {
            let [u, v] = [i % SIDE, i / SIDE % SIDE].map(|c| (c as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0);
            assert!(u.hypot(v) < 1.0 || *alpha == 0.0, "texel {i} lies outside of the disc: {alpha}");
            assert!((0.0..=1.0).contains(alpha));
        }
        // What the effect knows of it before there is one.
        let largest = device.iter().copied().fold(0.0, f32::max);
        assert!(f64::from(largest) <= exact.largest() * 1.000001);
    }
}

/// The levels are no layer: at each, a sprite as wide as the level's texels are pixels covers each of them as often as
/// the sorted alphas say.
#[test]
fn texels_of_every_level_pass_as_often_as_their_alphas() {
    for level in 1..MASK_LEVELS {
        let side = SIDE >> level;
        let repetitions = 4096;
        let settings = Settings {
            repetitions,
            count: 1.0,
            spread: Some(0.0),
            size_pixels: Some(side as f32),
            alpha_scale: 1.0,
            threshold: 0.2,
            variants: 4,
            ..Settings::paper()
        };
        let Some(mut rig) = FlameRig::new(desc([32, 32], 1, settings)) else { return };
        // Texels meet pixels: a sprite of an odd width lies on a pixel's middle, and a metre away half is 16 pixels.
        let shift = if side % 2 == 1 { 0.5 / 16.0 } else { 0.0 };
        rig.frame(&particles(&[[shift, -shift, -1.0, 3000.0]]), camera());
        let (mask, mean) = (device_mask(&mut rig), rig.mean());
        let sorted = mask.sorted(level);
        let below = 1 << (2 * level);
        let (mut scores, mut worst) = (0.0, 0.0_f64);
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let share = |variant: usize| {
                let first = ((variant * side + y) * side + x) * below;
                sorted[first..first + below].iter().filter(|alpha| **alpha >= f64::from(0.2_f32)).count()
            };
            let share = (0..4).map(share).sum::<usize>() as f64 / (4 * below) as f64;
            let place = (16 - side / 2 + y) * 32 + 16 - side / 2 + x;
            let found = f64::from(mean[place][3]);
            let deviation = (share * (1.0 - share) / f64::from(repetitions)).sqrt();
            assert!(deviation > 0.0 || found == share, "level {level}, ({x}, {y}): {found} instead of {share}");
            if deviation > 0.0 {
                worst = worst.max((found - share).abs() / deviation);
                scores += 1.0;
            }
        }
        let inside = side * side;
        assert!(scores > 0.0 && mean.iter().filter(|p| p[3] > 0.0).count() <= inside, "level {level}");
        // Of up to a thousand texels one in a hundred such tests is this many standard deviations off.
        assert!(worst < 4.5, "level {level}: {worst} standard deviations");
    }
}
