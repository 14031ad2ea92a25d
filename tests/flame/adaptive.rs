//! Tiles repeat until each of their pixels is known well enough: no sooner, no longer, and with the same repetitions as
//! without.

use celfx::data::Particles;
use celfx::flame::reference::sums::Sums;
use celfx::flame::settings::Sampling;
use celfx::flame::{Desc, Settings};
use celfx::low_level::flame::params;

use crate::common::flame::{FlameRig, ball, desc, particles};
use crate::common::scenes::camera;
use crate::oracle::{self, Shot, compare, occupied, sums};

const SIZE: [u32; 2] = [112, 80];
const TILE: usize = params::TILE as usize;
const MOST: u32 = 300;
/// Ends of the stages of 300 repetitions.
const STAGES: [u32; 6] = [16, 32, 64, 128, 256, MOST];

fn base() -> Settings {
    Settings { repetitions: MOST, count: 2.0, spread: Some(0.15), size: Some(0.3), ..Settings::paper() }
}

fn pixels(tile: u32) -> impl Iterator<Item = usize> {
    let [width, height] = SIZE.map(|side| side as usize);
    let across = width.div_ceil(TILE);
    let [left, top] = [tile as usize % across * TILE, tile as usize / across * TILE];
    (top..(top + TILE).min(height)).flat_map(move |y| (left..(left + TILE).min(width)).map(move |x| y * width + x))
}

/// The widest 95 % interval of a pixel's colours and coverage, with two repetitions more, one black and one as bright as
/// can be: 1.96 standard errors, of what is shown.
fn interval(sums: &Sums, pixel: usize, brightest: f64) -> f64 {
    let n = f64::from(sums.repetitions) + 2.0;
    let of = |sum: f64, squares: f64, unit: f64| {
        let mean = (sum + 1.0) / n;
        1.96 * unit * (((squares + 1.0) / n - mean * mean).max(0.0) / n).sqrt()
    };
    let colour = |c: usize| {
        let one = f64::from(params::LIGHT_STEPS);
        of(sums.light[pixel][c] as f64 / one, sums.squares[pixel][c] as f64 / (one * one), brightest)
    };
    let hits = f64::from(sums.hits[pixel]);
    (0..3).map(colour).fold(of(hits, hits, 1.0), f64::max)
}

/// Sums of so many repetitions, as a frame without `adaptive` has them.
fn fixed(desc: &Desc, repetitions: u32, given: &Particles) -> Option<Sums> {
    let settings = Settings { adaptive: 0.0, repetitions, ..desc.settings.clone() };
    let mut rig = FlameRig::new(Desc { settings, ..desc.clone() })?;
    rig.frame(given, camera(0.0));
    Some(sums(&mut rig, repetitions))
}

/// How many repetitions each occupied tile has had, which is the same in all of its pixels.
fn repetitions(rig: &mut FlameRig) -> Vec<(u32, u32)> {
    let variance = rig.variance();
    let of_tile = |tile: u32| {
        let found: Vec<f32> = pixels(tile).map(|pixel| variance[pixel][3]).collect();
        assert!(found.iter().all(|n| *n == found[0]), "tile {tile}: {found:?}");
        (tile, found[0] as u32)
    };
    occupied(rig).into_iter().map(of_tile).collect()
}

#[test]
fn tiles_stop_when_they_are_known() {
    let given = ball(60, 4);
    for (adaptive, intensity) in [(0.05, 1.0), (0.12, 1.7)] {
        let desc = desc(SIZE, 60, Settings { adaptive, intensity, ..base() });
        let Some(mut rig) = FlameRig::new(desc.clone()) else { return };
        rig.frame(&given, camera(0.0));
        let brightest = f64::from(f32::from_bits(oracle::control(&mut rig).brightest)) * f64::from(intensity);
        let done = repetitions(&mut rig);
        let found = sums(&mut rig, MOST);
        let mut fixed_sums = Vec::new();
        for n in STAGES {
            let Some(sums) = fixed(&desc, n, &given) else { return };
            fixed_sums.push(sums);
        }
        let widest = |stage: usize, tile| {
            pixels(tile).map(|pixel| interval(&fixed_sums[stage], pixel, brightest)).fold(0.0, f64::max)
        };
        let mut tally = [0; STAGES.len()];
        for (tile, n) in done {
            let stage = STAGES.iter().position(|stage| *stage == n).expect("a stage's end");
            tally[stage] += 1;
            // Single precision: a difference of two numbers near 1 under a root.
            let rounding = 1e-5;
            for (earlier, n) in STAGES[..stage].iter().enumerate() {
                let interval = widest(earlier, tile);
                assert!(interval >= f64::from(adaptive) - rounding, "tile {tile}: {interval} at {n}");
            }
            let interval = widest(stage, tile);
            let last = stage + 1 == STAGES.len();
            assert!(last || interval < f64::from(adaptive) + rounding, "tile {tile}: {interval} at {n}");
            for pixel in pixels(tile) {
                let of = |sums: &Sums| (sums.light[pixel], sums.squares[pixel], sums.hits[pixel], sums.depth[pixel]);
                assert_eq!(of(&found), of(&fixed_sums[stage]), "tile {tile}, {n} repetitions");
            }
        }
        println!("below {adaptive} at {STAGES:?}: {tally:?}");
        assert!(tally.iter().filter(|tiles| **tiles > 0).count() > 1, "all tiles alike show nothing");
    }
}

/// Layers are those of each tile's own repetitions.
#[test]
fn layers_follow_each_tiles_repetitions() {
    let given = ball(60, 4);
    let desc = desc(SIZE, 60, Settings { adaptive: 0.1, ..base() });
    let Some(mut rig) = FlameRig::new(desc.clone()) else { return };
    rig.frame(&given, camera(0.0));
    let done = repetitions(&mut rig);
    let layers = [rig.mean(), rig.variance(), rig.effect()];
    let nearest = rig.nearest();
    for n in STAGES {
        let settings = Settings { adaptive: 0.0, repetitions: n, ..desc.settings.clone() };
        let Some(mut fixed) = FlameRig::new(Desc { settings, ..desc.clone() }) else { return };
        fixed.frame(&given, camera(0.0));
        let expected = [fixed.mean(), fixed.variance(), fixed.effect()];
        let expected_nearest = fixed.nearest();
        for pixel in done.iter().filter(|(_, of_tile)| *of_tile == n).flat_map(|(tile, _)| pixels(*tile)) {
            for (layer, expected) in layers.iter().zip(&expected) {
                assert_eq!(layer[pixel], expected[pixel], "{n}");
            }
            assert_eq!(nearest[pixel], expected_nearest[pixel], "{n}");
        }
    }
}

/// A pixel that has not been hit is not known: after 16 repetitions it may be hit in a twentieth of them.
#[test]
fn pixels_that_are_never_hit_keep_a_tile_open() {
    // Far below a pixel: a hit is rare, and most tiles have none at all.
    let given = particles(&[[0.0, 0.0, 0.0, 3000.0]]);
    let atoms = Settings { size: Some(1e-5), spread: Some(0.5), ..base() };
    // With none of n hits the interval is 1.96 sqrt((1/m - 1/m^2)/m), m = n + 2.
    let interval = |n: f64| 1.96 * ((1.0 / (n + 2.0) - (n + 2.0_f64).powi(-2)) / (n + 2.0)).sqrt();
    for (adaptive, expected) in [(0.11, 16), (0.10, 32), (0.05, 64), (0.02, 128), (0.01, 256), (0.001, MOST)] {
        let Some(mut rig) = FlameRig::new(desc(SIZE, 1, Settings { adaptive, ..atoms.clone() })) else { return };
        rig.frame(&given, camera(0.0));
        let done = repetitions(&mut rig);
        assert!(!done.is_empty() && rig.mean().iter().all(|mean| mean[3] == 0.0), "a scene without any hit");
        assert!(done.iter().all(|(_, n)| *n == expected), "{adaptive}: {done:?}");
        let stage = STAGES.iter().position(|n| *n == expected).expect("a stage");
        assert!(expected == MOST || interval(expected.into()) < adaptive.into());
        assert!(stage == 0 || interval(STAGES[stage - 1].into()) >= adaptive.into());
    }
}

/// Stages of several dispatches, with Sobol points, against the reference: its first repetitions.
#[test]
fn stages_of_several_dispatches_agree_with_the_reference() {
    let given = ball(60, 4);
    let settings = Settings { adaptive: 0.05, count: 30.0, sampling: Sampling::ShuffledSobol, ..base() };
    let Some(mut rig) = FlameRig::new(desc(SIZE, 60, settings)) else { return };
    let shot = Shot::new(&given, camera(0.0));
    rig.frame(&given, camera(0.0));
    let at_once = oracle::control(&mut rig).part_repetitions;
    assert!(at_once < 128, "{at_once} repetitions in one dispatch");
    let done = repetitions(&mut rig);
    let found = sums(&mut rig, MOST);
    let mut differing = 0;
    let mut stages: Vec<u32> = done.iter().map(|(_, n)| *n).collect();
    stages.sort_unstable();
    stages.dedup();
    for n in stages {
        let expected = oracle::expected(&mut rig, &shot, 0..n);
        let mut of_stage = expected.clone();
        for pixel in done.iter().filter(|(_, of_tile)| *of_tile == n).flat_map(|(tile, _)| pixels(*tile)) {
            of_stage.light[pixel] = found.light[pixel];
            of_stage.squares[pixel] = found.squares[pixel];
            of_stage.hits[pixel] = found.hits[pixel];
            of_stage.depth[pixel] = found.depth[pixel];
        }
        differing += compare(&format!("{n} repetitions"), &of_stage, &expected).differing;
    }
    let samples: u64 = done.iter().map(|(tile, n)| pixels(*tile).count() as u64 * u64::from(*n)).sum();
    println!("{differing} of {samples} samples differ");
    // The specification's.
    assert!(differing as f64 <= (1e-5 * samples as f64).max(1.0), "{differing} of {samples}");
}
