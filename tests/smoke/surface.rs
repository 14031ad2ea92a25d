//! Radii up to the surface against a fine search in f64.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::smoke::Settings;
use celfx::smoke::reference::surface::{FINEST, excess, radius};
use celfx::smoke::settings::{Radius, RadiusFrom};

use super::radius::{COUNT, SIDE, positions, radii, radii_in, ulp, volumes};
use crate::common::bench::Bench;
use crate::common::scenes::{desc, of_voxels, random, volume};

/// The bound of the specification, in smallest sides of a voxel.
const BOUND: f64 = 0.02;

fn bench(radius: Radius, dimensions: [u32; 3]) -> Option<Bench> {
    let settings = Settings { particles: COUNT, fade: 0, radius, radius_from: RadiusFrom::Surface, ..of_voxels() };
    Bench::new(desc([8, 8], dimensions, settings))
}

/// Compares; returns the largest error in smallest sides of a voxel.
fn check(bench: &mut Bench, name: &str, volume: &Volume, positions: &[[f32; 3]]) -> f64 {
    let (kind, threshold) = (bench.desc.settings.radius, bench.desc.settings.threshold);
    let grid = volume.grid();
    let side = grid.smallest_side();
    let mut worst = 0.0_f64;
    for (p, actual) in positions.iter().zip(radii(bench, volume, positions)) {
        let expected = radius(&grid, threshold, *p, kind);
        let actual = f64::from(actual);
        // Places and centres are rounded to f32: as far as that moves a particle, its radius may change.
        let largest = (0..3).map(|a| (p[a].abs() + expected as f32).max(volume.origin[a].abs())).fold(0.0, f32::max);
        let rounding = 8.0 * ulp(largest);
        let error = actual - expected;
        // The reference is too small by at most `FINEST`; the kernel is never too small but for rounding.
        assert!(
            error <= (BOUND + FINEST) * side + rounding && error >= -1e-4 * side - rounding,
            "{name}: {kind:?} at {p:?}: {actual}, expected {expected}, {} voxels",
            error / side
        );
        worst = worst.max(error.abs() / side);
    }
    worst
}

fn all_volumes(kind: Radius) {
    let Some(mut bench) = bench(kind, [SIDE + 15; 3]) else { return };
    let mut worst = 0.0_f64;
    for (scale, origin) in [(0.13, [-3.0, 1.0, 7.5]), (1e4, [-1e5; 3])] {
        for shape in [[1.0, 1.0, 1.0], [1.0, 1.0, 2.5], [0.7, 1.9, 0.4]] {
            let h = shape.map(|side| side * scale);
            for (key, (name, volume)) in volumes(h, origin).iter().enumerate() {
                let name = format!("{name}, voxels {h:?}");
                let positions = positions(volume, key as u32);
                let found = check(&mut bench, &name, volume, &positions[..if kind == Radius::Box { 96 } else { 24 }]);
                worst = worst.max(found);
            }
        }
    }
    println!("{kind:?}: at most {worst:.4} voxels");
}

#[test]
fn a_surface_radius_of_a_box_is_that_of_a_fine_search() {
    all_volumes(Radius::Box);
}

#[test]
fn a_surface_radius_of_a_ball_is_that_of_a_fine_search() {
    all_volumes(Radius::Ball);
}

/// Smoke as it is: smooth, with thin sheets.
fn smooth(n: u32, wave: f32) -> Volume {
    let h = 2.0 / n as f32;
    volume([n; 3], [h; 3], [-1.0; 3], |x, y, z| {
        let p = [x, y, z].map(|i| (i as f32 + 0.5) * h - 1.0);
        let radius = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        let lump = (wave * p[0]).sin() * (wave * p[1] + 2.0).sin() * (wave * p[2] + 1.0).sin();
        (0.9 - radius + 0.3 * lump).max(0.0)
    })
}

#[test]
fn in_smoke_and_its_sheets_radii_are_those_of_a_fine_search() {
    for kind in [Radius::Box, Radius::Ball] {
        let Some(mut bench) = bench(kind, [48; 3]) else { return };
        for (name, volume) in [
            ("smooth", smooth(48, 5.0)),
            ("lumpy", smooth(40, 16.0)),
            ("a sheet", volume([33; 3], [0.1; 3], [0.0; 3], |x, y, _| if x + y == 30 { 0.3 } else { 0.0 })),
            ("two", volume([33; 3], [0.1; 3], [0.0; 3], |x, _, z| if x % 9 < 2 || z == 7 { 1e-30 } else { 0.12 })),
        ] {
            let positions = positions(&volume, 3);
            let worst = check(&mut bench, name, &volume, &positions[..24]);
            println!("{name}, {kind:?}: at most {worst:.4} voxels");
        }
    }
}

#[test]
fn thresholds_below_and_above_everything() {
    for kind in [Radius::Box, Radius::Ball] {
        let Some(mut bench) = bench(kind, [16; 3]) else { return };
        let mixed = volume([16; 3], [0.25; 3], [-2.0; 3], |x, y, z| {
            let kinds = [0.0, -5.0, 1e-30, 1e30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5];
            kinds[(random(3, x + 16 * (y + 16 * z), 0) * 8.0) as usize]
        });
        let finite = volume([16; 3], [0.25; 3], [-2.0; 3], |x, y, z| random(3, x + 16 * (y + 16 * z), 0) - 0.5);
        for threshold in [f32::MIN, -5.0, -1e-30, 0.0, 1e-30, 0.5, 1e30, f32::MAX] {
            bench.desc.settings.threshold = threshold;
            for volume in [&mixed, &finite] {
                let positions = positions(volume, 5);
                check(&mut bench, &format!("threshold {threshold}"), volume, &positions[..32]);
            }
        }
    }
}

/// Every cell of a shell around the particle is about as near as any other, and invocations come to them in any order.
#[test]
fn where_all_cells_are_as_near_the_radius_is_right_and_always_the_same() {
    let n = 96_u32;
    let centre = [48.3_f32, 48.2, 48.1];
    let shell = volume([n; 3], [1.0; 3], [0.0; 3], |x, y, z| {
        let d = [x, y, z].map(|i| i as f32 + 0.5);
        let distance = (0..3).map(|a| (d[a] - centre[a]).powi(2)).sum::<f32>().sqrt();
        0.1 + 40.0 - distance
    });
    let mut places = vec![centre; 3];
    places.extend((3..COUNT).map(|key| [0, 1, 2].map(|a| centre[a] + 8.0 * (random(7, key, a as u32) - 0.5))));
    assert!(excess(&shell.grid(), 0.1, [48, 48, 48]) > 0.0);
    for (kind, expected) in [(Radius::Ball, 40.0), (Radius::Box, 40.0 / 3_f64.sqrt())] {
        let Some(mut bench) = bench(kind, [n; 3]) else { return };
        let found = radii(&mut bench, &shell, &places);
        // Linear between centres, the ball's surface is flatter: a side's share of 1 / (8 * 40) inside.
        assert!((f64::from(found[0]) - expected).abs() < BOUND + 1.0 / 160.0, "{kind:?}: {}", found[0]);
        assert!(found[..3].iter().all(|radius| *radius == found[0]), "{kind:?}: {:?}", &found[..3]);
        for again in 0..4 {
            assert_eq!(radii(&mut bench, &shell, &places), found, "{kind:?}: time {again}");
        }
    }
}

/// A search begins with the radius of the last frame, which says nothing certain of this one.
#[test]
fn a_radius_is_the_same_whatever_it_was_before() {
    let smoke = smooth(40, 16.0);
    for kind in [Radius::Box, Radius::Ball] {
        let Some(mut bench) = bench(kind, [40; 3]) else { return };
        let positions = positions(&smoke, 4);
        let found = radii(&mut bench, &smoke, &positions);
        let mut check = |name: &str, before: Vec<f32>| {
            bench.write(layout::RADII, &before);
            assert_eq!(radii_in(&mut bench, &smoke, &positions, 7), found, "{kind:?}: before {name}");
        };
        check("as now", found.clone());
        check("somewhat smaller", found.iter().map(|radius| 0.8 * radius).collect());
        check("larger", found.iter().map(|radius| 3.0 * radius).collect());
        for before in [0.0, 1e-30, 0.02, 0.3, 1e6, f32::MAX, f32::INFINITY, f32::NAN, -0.1, -1.0, f32::NEG_INFINITY] {
            check(&before.to_string(), vec![before; positions.len()]);
        }
    }
}

/// Along x there may be more cells than rows have along y and z.
#[test]
fn in_a_long_volume_radii_are_those_of_a_fine_search() {
    let long = volume([2500, 7, 6], [0.1; 3], [0.0; 3], |x, y, z| random(9, x + 2500 * (y + 7 * z), 0));
    for kind in [Radius::Box, Radius::Ball] {
        let Some(mut bench) = bench(kind, long.dimensions) else { return };
        check(&mut bench, "long", &long, &positions(&long, 11)[..32]);
    }
}
