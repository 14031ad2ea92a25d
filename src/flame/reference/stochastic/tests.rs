use super::*;
use crate::flame::reference::prepare::{self, Prepared};
use crate::flame::settings::{Colour, Sampling, Shape};
use crate::random::{hash, unit};
use crate::view::Camera;

/// Looks along -z from the origin, 90 degrees.
fn camera() -> Camera {
    Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, near: 0.1, far: 50.0, ..Camera::default() }
}

fn settings() -> Settings {
    Settings { spread: Some(0.0), size: Some(1.0), count: 1.0, threshold: 0.5, ..Settings::paper() }
}

/// One variant, alpha 1 everywhere.
fn full_mask() -> Mask {
    Mask::from_texels(vec![1.0; SIDE * SIDE])
}

#[derive(Clone)]
struct Scene {
    settings: Settings,
    camera: Camera,
    size: [u32; 2],
    mask: Mask,
    level: Option<u32>,
    depth: Option<Vec<f32>>,
}

impl Scene {
    fn new(settings: Settings, size: [u32; 2]) -> Scene {
        Scene { settings, camera: camera(), size, mask: full_mask(), level: None, depth: None }
    }

    fn prepare(&self, positions: &[[f32; 4]]) -> Prepared {
        prepare::prepare(&self.settings, 1e6, 7, &self.camera.view(self.size), positions, None)
    }

    fn render(&self, positions: &[[f32; 4]], repetitions: Range<u32>) -> Sums {
        let (prepared, view) = (self.prepare(positions), self.camera.view(self.size));
        let level = prepare::mask_level(&self.settings, &view, self.size, prepared.nearest);
        let frame = Frame {
            settings: &self.settings,
            seed: 7,
            number: 0,
            view,
            size: self.size,
            scene: self.depth.as_deref(),
            mask: &self.mask,
            level: self.level.unwrap_or(level),
            base: 0.0,
        };
        render(&frame, &prepared.particles, repetitions, Rounding::default())
    }
}

fn covered(sums: &Sums) -> f64 {
    sums.hits.iter().map(|h| f64::from(*h)).sum()
}

#[test]
fn a_full_sprite_is_a_disc_and_corners_never_pass() {
    // Depth 1: 100 pixels a metre, so a sprite 100 pixels wide at level 0.
    let scene = Scene { level: Some(0), ..Scene::new(Settings { threshold: 0.0, ..settings() }, [201, 200]) };
    let sums = scene.render(&[[0.0, 0.0, -1.0, 3000.0]], 0..3);
    let share = covered(&sums) / 3.0 / 10_000.0;
    assert!((share - std::f64::consts::FRAC_PI_4).abs() < 1e-3, "{share}");
    assert_eq!(sums.hits.iter().max(), Some(&3));
    // Symmetric about the centre, the first and last row and column are empty.
    let at = |x: usize, y: usize| sums.hits[y * 201 + x];
    assert!((0..200).all(|y| (0..201).all(|x| at(x, y) == at(200 - x, 199 - y))));
    assert!((at(100, 50), at(100, 49), at(100, 149), at(100, 150)) == (3, 0, 3, 0));
}

#[test]
fn levels_pass_the_same_share() {
    // One sprite a repetition, so that none hides another; on the last level all of it passes or none.
    let settings = Settings { spread: Some(0.3), threshold: 0.8, size: Some(0.4), ..settings() };
    let scene = Scene { mask: Mask::new(3, 16), ..Scene::new(settings, [64, 64]) };
    let covered = |level| {
        let scene = Scene { level: Some(level), ..scene.clone() };
        covered(&scene.render(&[[0.1, -0.05, -1.0, 3000.0]], 0..4000))
    };
    let finest = covered(0);
    for level in [1, 2, 4, 6] {
        assert!((covered(level) / finest - 1.0).abs() < 0.06, "{level}: {} {finest}", covered(level));
    }
}

#[test]
fn sprites_below_a_pixel_pass_as_often_as_they_cover() {
    // 0.3 pixels wide, a full disc, 40,000 sprites over 32 x 32 pixels.
    let mask = Mask::from_texels(vec![1.0; SIDE * SIDE]);
    let share = mask.sorted(6).iter().sum::<f64>() / (SIDE * SIDE) as f64;
    let settings = Settings { spread: Some(0.2), shape: Shape::Cube, size: Some(0.3 / 16.0), ..settings() };
    let scene = Scene { mask, ..Scene::new(settings, [32, 32]) };
    let sums = scene.render(&[[0.0, 0.0, -1.0, 3000.0]], 0..40_000);
    let expected = 40_000.0 * share * 0.3 * 0.3;
    assert!((covered(&sums) / expected - 1.0).abs() < 0.06, "{} {expected}", covered(&sums));
}

#[test]
fn the_nearest_wins_and_of_equals_the_smaller_id() {
    let settings = Settings { colour: Colour::Ramp(vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), ..settings() };
    let mut scene = Scene::new(settings, [9, 9]);
    let middle = 4 * 9 + 4;
    // Red is cold here: 750 K passes too, its alpha is 1.
    let (red, green) = ([0.0, 0.0, -2.0, 750.0], [0.0, 0.0, -1.9, 2999.0]);
    scene.settings.count = 4.0;
    let sums = scene.render(&[red, green], 0..1);
    assert_eq!((sums.light[middle], sums.hits[middle], sums.near[middle]), ([0, 65535, 0], 1, 0));
    assert_eq!((sums.depth[middle], sums.squares[middle]), (f64::from(1.9_f32), [0, 65535 * 65535, 0]));
    let at_green = [0.0, 0.0, -1.9, 750.0];
    assert_eq!(scene.render(&[at_green, green], 0..1).light[middle], [65535, 0, 0]);
    assert_eq!(scene.render(&[green, at_green], 0..1).light[middle], [0, 65535, 0]);
    assert_eq!(scene.render(&[green, at_green], 0..1).near[middle], 0);
    // Within rounding of each other: counted.
    let behind = [0.0, 0.0, -1.900_000_1, 750.0];
    assert_eq!(scene.render(&[green, behind], 0..1).near[middle], 1);
    // Unless something else is nearer.
    assert_eq!(scene.render(&[green, behind, [0.0, 0.0, -1.0, 750.0]], 0..1).near[middle], 0);
}

#[test]
fn the_scene_and_the_planes_occlude() {
    let mut scene = Scene::new(settings(), [8, 4]);
    scene.depth = Some((0..32).map(|i| if i % 8 < 4 { 1.5 } else { f32::INFINITY }).collect());
    let sums = scene.render(&[[0.0, 0.0, -1.6, 3000.0]], 0..2);
    assert!((0..32).all(|i| i % 8 >= 4 || sums.hits[i] == 0));
    assert!(covered(&sums) > 0.0);
    scene.depth = Some(vec![1.6; 32]);
    let touching = scene.render(&[[0.0, 0.0, -1.6, 3000.0]], 0..1);
    assert!(touching.near.iter().sum::<u32>() > 0);
    scene.depth = None;
    for z in [-0.05, -51.0, 1.0] {
        assert_eq!(covered(&scene.render(&[[0.0, 0.0, z, 3000.0]], 0..1)), 0.0);
    }
}

#[test]
fn thresholds_at_their_ends() {
    let positions = [[0.0, 0.0, -1.0, 1500.0]];
    let hits = |alpha_scale: f32, threshold: f32, mask: f64| {
        let settings = Settings { alpha_scale, threshold, count: 2.0, ..settings() };
        let scene = Scene { mask: Mask::from_texels(vec![mask; SIDE * SIDE]), ..Scene::new(settings, [16, 16]) };
        covered(&scene.render(&positions, 0..1)) > 0.0
    };
    assert!(hits(1.0, 0.0, 0.1) && !hits(1.0, 0.0, 0.0) && hits(0.0, 0.0, 0.1) && hits(1.0, -1.0, 0.1));
    assert!(hits(2.0, 1.0, 1.0) && hits(8.0, 1.0, 1.0) && !hits(1.9, 1.0, 1.0));
    assert!(!hits(8.0, 1.0 + f32::EPSILON, 1.0) && hits(0.0, f32::MIN, 1.0) && !hits(0.0, f32::MIN_POSITIVE, 1.0));
}

#[test]
fn tests_near_the_threshold_are_counted() {
    let positions = [[0.0, 0.0, -1.0, 3000.0]];
    let near = |threshold: f32| {
        let settings = Settings { alpha_scale: 1.0, threshold, ..settings() };
        let scene = Scene { mask: Mask::from_texels(vec![0.5; SIDE * SIDE]), ..Scene::new(settings, [16, 16]) };
        let sums = scene.render(&positions, 0..1);
        (covered(&sums) > 0.0, sums.near.iter().sum::<u32>() > 10)
    };
    assert_eq!([0.5, 0.500_000_1, 0.499_999_9].map(near), [(true, true), (false, true), (true, true)]);
    assert_eq!([0.501, 0.499].map(|t| near(t).0), [false, true]);
}

fn cloud(n: u32) -> Vec<[f32; 4]> {
    let draw = |i, axis| unit(hash(2, i, 0, axis)) - 0.5;
    (0..n).map(|i| [draw(i, 0), draw(i, 1), -2.0 + draw(i, 2), 3000.0 - 2500.0 * unit(hash(2, i, 0, 3))]).collect()
}

#[test]
fn parts_add_up_and_few_decisions_are_near() {
    let settings = Settings {
        spread: Some(0.1),
        size: Some(0.15),
        count: 20.0,
        threshold: 0.4,
        repetitions: 64,
        sampling: Sampling::ShuffledSobol,
        ..Settings::paper()
    };
    let scene = Scene { mask: Mask::new(7, 16), ..Scene::new(settings, [160, 120]) };
    let positions = cloud(300);
    let mut parts = scene.render(&positions, 0..13);
    parts.add(&scene.render(&positions, 13..64));
    let whole = scene.render(&positions, 0..64);
    assert_eq!((&parts.light, &parts.squares, &parts.hits), (&whole.light, &whole.squares, &whole.hits));
    assert!((0.05..0.9).contains(&(covered(&whole) / 64.0 / 19_200.0)));
    let near: f64 = whole.near.iter().map(|n| f64::from(*n)).sum();
    assert!(near / covered(&whole) < 5e-3, "{near} of {}", covered(&whole));
    let (mean, coverage, variance) = (whole.mean(2.0), whole.coverage(), whole.variance(2.0));
    let depths = whole.mean_depth();
    for i in 0..mean.len() {
        assert!(mean[i][0] <= 2.0 * coverage[i] + 1e-12);
        assert!(variance[i][0] >= 0.0 && variance[i][0] <= 64.0 / 63.0);
        assert!(if coverage[i] > 0.0 { (1.3..2.7).contains(&depths[i]) } else { depths[i].is_infinite() });
    }
}
