//! The radius of each search against brute force over every voxel.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::{FULL_SIZE, Particle};
use celfx::low_level::smoke::search::{Pyramid, growth_rows};
use celfx::smoke::reference::grow;
use celfx::smoke::settings::{Grow, Radius};
use celfx::smoke::{Settings, Shape};
use celfx::view::{Camera, Light};

use crate::common::bench::{Bench, Given, TRAITS};
use crate::common::scenes::{desc, of_voxels, random, volume};

/// Particles of a frame.
pub const COUNT: u32 = 192;
/// The largest volume of most tests.
pub const SIDE: u32 = 33;

/// The search under test, with a volume of up to `dimensions`; the picture is not made.
fn bench(grow: Grow, radius: Radius, dimensions: [u32; 3]) -> Option<Bench> {
    let settings = Settings { particles: COUNT, fade: 0, grow, radius, ..of_voxels() };
    Bench::new(desc([8, 8], dimensions, settings))
}

/// Whether a search was made for volumes of this shape.
fn serves(bench: &Bench, volume: &Volume) -> bool {
    let Volume { dimensions, voxel_size, origin, .. } = *volume;
    let shape = Shape { dimensions, voxel_size, origin };
    match bench.desc.settings.grow {
        Grow::Field => shape.is_cubic(),
        Grow::Growth => {
            growth_rows(&shape).div_ceil(Pyramid::new(dimensions).iterations(&TRAITS)) <= bench.layout.search_parts
        }
        _ => true,
    }
}

/// Positions anywhere in and around the volume: random, on faces, edges and corners of voxels, on centres, one step of
/// f32 beside a face.
pub fn positions(volume: &Volume, key: u32) -> Vec<[f32; 3]> {
    let along = |axis: usize, index: u32, kind: u32| {
        let draw = |dimension: u32| random(key, index, 10 * dimension + axis as u32);
        let (n, h, origin) = (volume.dimensions[axis], volume.voxel_size[axis], volume.origin[axis]);
        let face = origin + (draw(1) * (n as f32 + 1.0)).floor() * h;
        match kind {
            0 => face,
            1 => origin + ((draw(1) * n as f32).floor() + 0.5) * h,
            2 => beside(face, face.next_up()),
            3 => beside(face, face.next_down()),
            4 => origin + (draw(2) * 1.2 - 0.1) * n as f32 * h,
            _ => origin + draw(2) * n as f32 * h,
        }
    };
    (0..COUNT)
        .map(|index| [0, 1, 2].map(|axis| along(axis, index, (random(key, index, 40 + axis as u32) * 9.0) as u32)))
        .collect()
}

/// What is one step beside 0 is the least normal number: a device may take subnormal ones for 0.
fn beside(face: f32, step: f32) -> f32 {
    if step.is_subnormal() { face + f32::MIN_POSITIVE.copysign(step) } else { step }
}

/// Runs the search for particles at these places.
pub fn radii(bench: &mut Bench, volume: &Volume, positions: &[[f32; 3]]) -> Vec<f32> {
    radii_in(bench, volume, positions, 0)
}

/// Those in a frame of a sequence.
pub fn radii_in(bench: &mut Bench, volume: &Volume, positions: &[[f32; 3]], frames: u32) -> Vec<f32> {
    let particle =
        |position: &[f32; 3]| Particle { position: *position, age: FULL_SIZE, displacement: [0.0; 3], generation: 0 };
    bench.write(layout::PARTICLES, &positions.iter().map(particle).collect::<Vec<_>>());
    bench.run(&Given {
        camera: Camera::default(),
        light: Light::default(),
        volume,
        frames,
        rendered: false,
        omit: &["smoke.advect"],
    });
    bench.read::<[f32; 4]>(layout::SPHERES, positions.len()).iter().map(|s| s[3]).collect()
}

/// The spacing of f32 at `x`.
pub fn ulp(x: f32) -> f64 {
    f64::from(x.abs().next_up()) - f64::from(x.abs())
}

/// Compares with brute force; returns the greatest error in ulp of the largest coordinate involved.
fn check(bench: &mut Bench, name: &str, volume: &Volume, key: u32) -> f64 {
    if !serves(bench, volume) {
        return 0.0;
    }
    let positions = positions(volume, key);
    check_at(bench, name, volume, &positions)
}

fn check_at(bench: &mut Bench, name: &str, volume: &Volume, positions: &[[f32; 3]]) -> f64 {
    let (kind, threshold) = (bench.desc.settings.radius, bench.desc.settings.threshold);
    let actual = radii(bench, volume, positions);
    let mut worst = 0.0_f64;
    for (p, actual) in positions.iter().zip(actual) {
        let expected = grow::radius(&volume.grid(), threshold, *p, kind);
        assert_eq!(actual == 0.0, expected == 0.0, "{name}: {p:?}: {actual}, expected {expected}");
        // Of the particle, the empty voxel's centre and the corner that it is counted from.
        let largest = (0..3).map(|a| (p[a].abs() + expected as f32).max(volume.origin[a].abs())).fold(0.0, f32::max);
        let error = (f64::from(actual) - expected).abs() / ulp(largest);
        // The bound of the specification: products, sums and differences of f32, rounded a few times.
        assert!(error <= 2.0, "{name}: {kind:?} at {p:?}: {actual}, expected {expected}, {error} ulp of {largest}");
        worst = worst.max(error);
    }
    worst
}

/// Volumes of all sorts, with sides `h`, of up to [`SIDE`] voxels.
pub fn volumes(h: [f32; 3], origin: [f32; 3]) -> Vec<(&'static str, Volume)> {
    let make = |n: [u32; 3], density: &dyn Fn(u32, u32, u32) -> f32| volume(n, h, origin, density);
    let noise = |x, y, z| random(7, x + 64 * (y + 64 * z), 0);
    let ball = |x: u32, y: u32, z: u32| {
        let [x, y, z] = [x, y, z].map(|i| i as f32 - 15.7);
        if x * x + y * y + z * z < 230.0 { 1.0 } else { 0.0 }
    };
    vec![
        ("one voxel, full", make([1; 3], &|_, _, _| 1.0)),
        ("one voxel, empty", make([1; 3], &|_, _, _| 0.0)),
        ("all empty", make([5, 4, 3], &|_, _, _| 0.1)),
        ("all full", make([33, 21, 9], &|_, _, _| 1.0)),
        ("a full voxel", make([9, 8, 7], &|x, y, z| if [x, y, z] == [4, 3, 5] { 1.0 } else { 0.0 })),
        ("an empty voxel", make([32, 31, 33], &|x, y, z| if [x, y, z] == [20, 11, 17] { 0.0 } else { 1.0 })),
        ("a row", make([33, 1, 1], &|x, _, _| if x == 30 { 0.0 } else { 1.0 })),
        ("a wall", make([1, 33, 33], &|_, y, z| if (y + z) % 29 == 5 { 0.0 } else { 1.0 })),
        ("dense noise", make([33; 3], &|x, y, z| if noise(x, y, z) < 0.002 { 0.0 } else { 1.0 })),
        ("thin noise", make([17, 13, 19], &|x, y, z| noise(x, y, z) - 0.3)),
        ("a ball", make([32, 33, 31], &ball)),
        ("half of it", make([31, 30, 33], &|x, y, _| if x + y < 35 { 5.0 } else { -1.0 })),
        (
            "not finite",
            make([16; 3], &|x, y, z| {
                [1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, 1.0, 1.0, 1.0][(noise(x, y, z) * 8.0) as usize]
            }),
        ),
        ("extreme", make([16; 3], &|x, y, z| [1e30, 1e-30, 0.1_f32.next_up(), 2.0][(noise(x, y, z) * 4.0) as usize])),
    ]
}

fn all_volumes(grow: Grow, radius: Radius) {
    let Some(mut bench) = bench(grow, radius, [SIDE + 15; 3]) else { return };
    let mut worst = 0.0_f64;
    for (scale, origin) in [(1.0, [0.0; 3]), (0.13, [-3.0, 1.0, 7.5]), (1e-3, [0.01, -0.004, 0.0]), (1e4, [-1e5; 3])] {
        for shape in [[1.0, 1.0, 1.0], [1.0, 1.0, 2.5], [0.7, 1.9, 0.4]] {
            let h = shape.map(|side| side * scale);
            for (key, (name, volume)) in volumes(h, origin).iter().enumerate() {
                let name = format!("{name}, voxels {h:?}");
                worst = worst.max(check(&mut bench, &name, volume, key as u32));
            }
        }
    }
    println!("{grow:?}, {radius:?}: at most {worst:.2} ulp");
}

#[test]
fn field_equals_brute_force() {
    all_volumes(Grow::Field, Radius::Box);
}

#[test]
fn pyramid_equals_brute_force() {
    all_volumes(Grow::Pyramid, Radius::Box);
    all_volumes(Grow::Pyramid, Radius::Ball);
}

#[test]
fn growth_equals_brute_force() {
    all_volumes(Grow::Growth, Radius::Box);
    all_volumes(Grow::Growth, Radius::Ball);
}

#[test]
fn thresholds_below_and_above_everything() {
    for grow in [Grow::Field, Grow::Pyramid, Grow::Growth] {
        let Some(mut bench) = bench(grow, Radius::Box, [16; 3]) else { return };
        let mixed = volume([16; 3], [0.25; 3], [-2.0; 3], |x, y, z| {
            let kinds = [0.0, -5.0, 1e-30, 1e30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5];
            kinds[(random(3, x + 16 * (y + 16 * z), 0) * 8.0) as usize]
        });
        let finite = volume([16; 3], [0.25; 3], [-2.0; 3], |x, y, z| random(3, x + 16 * (y + 16 * z), 0) - 0.5);
        for threshold in [f32::MIN, -5.0, -1e-30, 0.0, 1e-30, 0.5, 1e30, f32::MAX] {
            bench.desc.settings.threshold = threshold;
            for volume in [&mixed, &finite] {
                check(&mut bench, &format!("threshold {threshold}"), volume, 5);
            }
        }
    }
}

/// Empty voxels on a sphere around the particle, as near as possible to each other in distance: pruning helps little, and
/// the search must go on in several dispatches.
#[test]
fn a_search_beyond_the_loop_budget_goes_on() {
    let n = 128_u32;
    let centre = [64.3_f32, 64.2, 64.1];
    let shell = volume([n; 3], [1.0; 3], [0.0; 3], |x, y, z| {
        let d = [x, y, z].map(|i| i as f32 + 0.5);
        let distance = (0..3).map(|a| (d[a] - centre[a]).powi(2)).sum::<f32>().sqrt();
        if (60.0..61.5).contains(&distance) { 0.0 } else { 1.0 }
    });
    for (grow, radius) in [(Grow::Pyramid, Radius::Ball), (Grow::Pyramid, Radius::Box), (Grow::Growth, Radius::Ball)] {
        let Some(mut bench) = bench(grow, radius, [n; 3]) else { return };
        let mut places = vec![centre];
        places.extend((1..COUNT).map(|_| [1.5; 3]));
        places[1..12].iter_mut().enumerate().for_each(|(i, p)| *p = [0, 1, 2].map(|a| centre[a] + i as f32 * 0.31));
        let worst = check_at(&mut bench, "shell", &shell, &places);
        let continuations: Vec<[u32; 4]> = bench.read(layout::CONTINUATIONS, bench.layout.search_parts as usize);
        let parts = 1 + continuations.iter().take_while(|groups| groups[0] > 0).count();
        println!("{grow:?}, {radius:?}: {parts} of {} dispatches, {worst:.2} ulp", bench.layout.search_parts);
        assert!(parts > 1 || radius == Radius::Box, "{grow:?}, {radius:?}: the search ended within one dispatch");
        assert!(parts < continuations.len(), "the last dispatch may not ask for another");
    }
}
