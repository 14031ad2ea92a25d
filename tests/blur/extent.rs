//! k, l, k' and smoothing against f32 brute force. The kernels use + - * only, and divisions and roots, which are exact
//! on lavapipe: there everything agrees to the bit.

use std::f32::consts::TAU;

use celfx::blur::motion::{Piece, Segment};
use celfx::blur::params::Vertex;
use celfx::blur::reference::extent::{Extent, extent, extents};
use celfx::blur::{Cluster, Desc, Interval, Mesh, Settings};

use crate::common::blur::{BlurRig, Shot, desc};
use crate::common::scenes::random;
use crate::scenes::{mesh, swing};

/// An interval of points that have this motion and go straight on, of one cluster with this hull.
fn straight(motion: Vec<[f32; 4]>, hull: Vec<[f32; 2]>, chain: usize) -> Interval {
    let points = motion.len();
    let pieces = motion.iter().map(|[x, y, vx, vy]| Piece {
        origin: [4.0 * x, 4.0 * y, 4.0, 0.0],
        step: [4.0 * vx, 4.0 * vy, 0.0, 0.0],
        ..Piece::default()
    });
    Interval {
        pieces: pieces.collect(),
        labels: vec![1; points],
        clusters: vec![Cluster {
            object: 5,
            hull_begin: 0,
            chain_end: chain as u32,
            hull_end: hull.len() as u32,
            teeth: 43,
            points: points as u32,
        }],
        hull,
        segments: vec![Segment { begin: 0.0, end: 1.0 }],
        motion,
        ..Interval::default()
    }
}

/// The convex hull, counter-clockwise where y is up, with what is on its sides, decided in f64: enough for these points.
fn chain(points: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    let half = |points: &mut dyn Iterator<Item = [f32; 2]>| {
        let mut chain: Vec<[f32; 2]> = Vec::new();
        for c in points {
            while let [.., a, b] = chain[..] {
                let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|p| p.map(f64::from));
                if (ax - cx) * (by - cy) - (ay - cy) * (bx - cx) >= 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(c);
        }
        chain
    };
    let (mut lower, mut upper) = (half(&mut sorted.iter().copied()), half(&mut sorted.iter().rev().copied()));
    if lower.len() == sorted.len() {
        return sorted;
    }
    lower.pop();
    upper.pop();
    [lower, upper].concat()
}

/// k and l of the device, of one frame.
fn device(interval: &Interval) -> Option<Vec<Vertex>> {
    let animation = swing([2, 2], 4, [1920, 1080], 0.1);
    let points = interval.motion.len();
    let mesh = mesh(points, &[[0, 0, 0]]);
    let desc = desc(animation.size, &mesh, Settings::default());
    let mut rig = BlurRig::new(Desc { size: [64, 64], frames_resident: 4, layers: false, ..desc }, mesh)?;
    let poses = vec![vec![[0.0; 3]; points]; 4];
    let views = animation.views(1);
    let shot = Shot { poses: Some((0, &poses)), interval: Some(interval), views, knots: None };
    rig.frame(&shot).expect("a frame");
    Some(rig.vertices())
}

fn velocity(i: u32) -> [f32; 2] {
    let (turn, speed) = (TAU * random(3, i, 0), 30.0 * random(3, i, 1));
    [speed * turn.cos(), speed * turn.sin()]
}

/// Positions of the shapes of the research.
fn shapes() -> Vec<(&'static str, Vec<[f32; 2]>)> {
    let u = |i, d| random(9, i, d);
    let gauss = |i: u32| {
        let (r, t) = ((-2.0 * u(i, 0).ln()).sqrt(), TAU * u(i, 1));
        [960.0 + 200.0 * r * t.cos(), 540.0 + 100.0 * r * t.sin()]
    };
    let disc = |i: u32| {
        let (r, t) = (300.0 * u(i, 0).sqrt(), TAU * u(i, 1));
        [960.0 + r * t.cos(), 540.0 + r * t.sin()]
    };
    let circle = |i: u32| {
        let t = TAU * i as f32 / 4000.0;
        [960.0 + 500.0 * t.cos(), 540.0 + 500.0 * t.sin()]
    };
    let all = |count: u32, at: &dyn Fn(u32) -> [f32; 2]| (0..count).map(at).collect::<Vec<_>>();
    vec![
        ("gauss", all(3000, &gauss)),
        ("disc", all(3000, &disc)),
        ("circle", all(4000, &circle)),
        ("grid", all(1600, &|i| [(i % 40) as f32 * 7.3, (i / 40) as f32 * 3.1])),
        ("line", all(500, &|i| [100.0 + i as f32, 50.0 + 2.0 * i as f32])),
        ("upright line", all(500, &|i| [100.0, 50.0 + 0.37 * i as f32])),
        ("one", vec![[100.3, 70.7]]),
        ("two", vec![[100.3, 70.7], [140.0, 12.0]]),
        ("coincident", vec![[100.3, 70.7]; 5]),
        ("far", all(2000, &|i| disc(i).map(|x| x + 1e5))),
    ]
}

#[test]
fn k_and_l_are_those_of_brute_force() {
    for (name, points) in shapes() {
        let mut motion: Vec<[f32; 4]> = (0..)
            .zip(&points)
            .map(|(i, [x, y])| {
                let [vx, vy] = velocity(i);
                [*x, *y, vx, vy]
            })
            .collect();
        // Along the axes, along a side, and none at all.
        for (row, v) in
            motion.iter_mut().zip([[1.0, 0.0], [0.0, -3.0], [1.0, 2.0], [-2.0, 1.0], [0.0, 0.0], [1e-7, 0.0]])
        {
            (row[2], row[3]) = (v[0], v[1]);
        }
        let hull = chain(&points);
        // A hull in f64 misses what rounding makes extreme: far from the origin all points stay.
        let chain = hull.len();
        let rest = points.iter().filter(|p| !hull.contains(p)).copied().collect::<Vec<_>>();
        let hull = if name == "far" { [hull.clone(), rest].concat() } else { hull };
        let interval = straight(motion.clone(), hull, chain);
        let Some(vertices) = device(&interval) else { return };
        let mut different = 0;
        for (vertex, motion) in vertices.iter().zip(&motion) {
            let expected = extent(*motion, &points);
            different += u32::from([vertex.extent[0], vertex.extent[1]] != expected);
        }
        assert_eq!(different, 0, "{name}: of {} points, {chain} of them on the hull", points.len());
    }
}

/// A hull that is searched and then looked at whole: all products are equal.
#[test]
fn a_line_across_the_motion_has_no_front() {
    let points: Vec<[f32; 2]> = (0..2000).map(|i| [64.0, i as f32]).collect();
    let interval = straight(points.iter().map(|[x, y]| [*x, *y, 8.0, 0.0]).collect(), points.clone(), points.len());
    let Some(vertices) = device(&interval) else { return };
    for (vertex, [_, y]) in vertices.iter().zip(&points) {
        assert_eq!([vertex.extent[0], vertex.extent[1]], [1.0, (1999.0 - y) / 1999.0]);
    }
}

/// k' and what smoothing adds to it, on a mesh of two clusters and points that stand still.
#[test]
fn smoothing_is_the_references() {
    let sides = [24, 16];
    let animation = swing(sides, 6, [480, 270], 0.4);
    for (strength, rounds, teeth) in [(1.0, 8, 43), (0.4, 3, 1), (3.0, 5, 7), (1.0, 0, 2)] {
        let settings = Settings { strength, seam_smoothing: rounds, ..Settings::default() };
        let mesh: Mesh = crate::scenes::grid(sides);
        let desc = desc(animation.size, &mesh, settings);
        let segments = desc.segments as usize;
        let label = |p: u32| if p % 24 < 4 { 0 } else { 1 + u32::from(p % 24 > 13) };
        let labels: Vec<u32> = (0..24 * 16).map(label).collect();
        let interval = crate::scenes::interval(&animation, 3, &labels, 0.5, teeth, segments);
        let Some(mut rig) = BlurRig::new(desc, mesh.clone()) else { return };
        let knots = animation.knots(3, segments);
        let shot = Shot {
            poses: Some((0, &animation.poses)),
            interval: Some(&interval),
            views: animation.views(3),
            knots: Some(&knots),
        };
        rig.frame(&shot).expect("a frame");
        let expected = extents(&mesh, &interval, 1, strength, rounds);
        let found: Vec<Extent> = rig.vertices()[..labels.len()]
            .iter()
            .map(|v| Extent { k: v.extent[0], l: v.extent[1], offset: v.extent[2], time: v.extent[3] })
            .collect();
        let different = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert_eq!(
            different,
            0,
            "strength {strength}, {rounds} rounds: {:?}",
            found.iter().zip(&expected).find(|(a, b)| a != b)
        );
        let moved = expected.iter().filter(|e| e.offset != 0.0).count();
        assert_eq!(moved > 0, rounds > 0, "smoothing does something");
    }
}
