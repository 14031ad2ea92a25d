//! k, l, k' and smoothing against f32 brute force. The kernels use + - * only, and divisions and roots, which are exact
//! on lavapipe: there everything agrees to the bit.

use std::f32::consts::TAU;

use celfx::blur::motion::{Piece, Segment, outline};
use celfx::blur::reference::extent::{Extent, Pull, extent, extents};
use celfx::blur::settings::{Curve, Ghosts};
use celfx::blur::{Cluster, Desc, Interval, Mesh, Settings};
use celfx::low_level::blur::params::Vertex;

use crate::common::blur::{BlurRig, Shot, desc, incomplete};
use crate::common::scenes::random;
use crate::scenes::{mesh, swing};

/// An interval of points that have this motion and go straight on. All of them make the hull of a cluster, and those of
/// these places are in it: each of its points is looked at by itself, and many take long.
fn straight(motion: Vec<[f32; 4]>, places: &[usize]) -> Interval {
    let points = motion.len();
    let mut labels = vec![0; points];
    places.iter().for_each(|place| labels[*place] = 1);
    let bounds = outline(&motion.iter().map(|[x, y, ..]| [*x, *y]).collect::<Vec<_>>());
    let pieces = motion.iter().map(|[x, y, vx, vy]| Piece {
        origin: [4.0 * x, 4.0 * y, 4.0, 0.0],
        step: [4.0 * vx, 4.0 * vy, 0.0, 0.0],
        ..bytemuck::Zeroable::zeroed()
    });
    Interval {
        pieces: pieces.collect(),
        labels,
        clusters: vec![Cluster {
            object: 5,
            bounds_begin: 0,
            bounds_end: bounds.len() as u32,
            teeth: 43,
            points: places.len() as u32,
            ..bytemuck::Zeroable::zeroed()
        }],
        bounds,
        segments: vec![Segment { begin: 0.0, end: 1.0 }],
        motion,
        ..Interval::default()
    }
}

/// Vertices of the device with their k and l, of one frame.
fn device(interval: &Interval, triangle: [u32; 3]) -> Option<Vec<Vertex>> {
    let animation = swing([2, 2], 4, [1920, 1080], 0.1);
    let points = interval.motion.len();
    let mesh = mesh(points, &[triangle]);
    // With an after-image, triangles outside of the small picture are refined, too.
    let settings = Settings { ghosts: Ghosts { count: 1, ..Ghosts::default() }, ..incomplete() };
    let desc = desc(animation.size, &mesh, settings);
    let mut rig =
        BlurRig::new(Desc { size: [64, 64], frames_resident: 4, layers: false, most_triangles: 200, ..desc }, mesh)?;
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
    let circle = |i: u32, count: u32, radius: f32| {
        let t = TAU * i as f32 / count as f32;
        [960.0 + radius * t.cos(), 540.0 + radius * t.sin()]
    };
    let all = |count: u32, at: &dyn Fn(u32) -> [f32; 2]| (0..count).map(at).collect::<Vec<_>>();
    vec![
        ("gauss", all(3000, &gauss)),
        ("disc", all(3000, &disc)),
        ("circle", all(4000, &|i| circle(i, 4000, 500.0))),
        ("grid", all(1600, &|i| [(i % 40) as f32 * 7.3, (i / 40) as f32 * 3.1])),
        ("line", all(500, &|i| [100.0 + i as f32, 50.0 + 2.0 * i as f32])),
        ("upright line", all(500, &|i| [100.0, 50.0 + 0.37 * i as f32])),
        ("one", vec![[100.3, 70.7]]),
        ("two", vec![[100.3, 70.7], [140.0, 12.0]]),
        ("coincident", vec![[100.3, 70.7]; 5]),
        ("far", all(2000, &|i| disc(i).map(|x| x + 1e5))),
        ("10,000 on a circle", all(10_000, &|i| circle(i, 10_000, 500.0))),
        ("100,000 on a circle", all(100_000, &|i| circle(i, 100_000, 500.0))),
        ("30,000 on a small circle", all(30_000, &|i| circle(i, 30_000, 3.0))),
        ("20,000 on a line", all(20_000, &|i| [0.1 * i as f32, 0.05 * i as f32])),
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
        // Brute force takes long where there are many.
        let stride = points.len().div_ceil(if points.len() > 9000 { 300 } else { 4000 });
        let places: Vec<usize> = (0..points.len()).filter(|place| place % stride == 0 || *place < 6).collect();
        let interval = straight(motion.clone(), &places);
        let Some(vertices) = device(&interval, [0, 0, 0]) else { return };
        let expected = |place: usize| extent(motion[place], &points);
        let found = |place: usize| [vertices[place].k, vertices[place].l];
        let different = places.iter().filter(|place| found(**place) != expected(**place)).count();
        let extreme = interval.bounds.len();
        assert_eq!(different, 0, "{name}: of {} points, {extreme} of them extreme", points.len());
    }
}

/// Hulls that are searched and then looked at whole, because products are equal; the largest of the second by more than
/// an invocation can look at nine times.
#[test]
fn a_line_across_the_motion_has_no_front() {
    for count in [2000, 65_000, 100_000] {
        let points: Vec<[f32; 2]> = (0..count).map(|i| [64.0, i as f32 * 0.125]).collect();
        let speed = |y: f32| if y < 4000.0 { 8.0 } else { 24.0 };
        let ends = [0, count / 2, count - 1];
        let places: Vec<usize> = (0..count).filter(|i| i % 97 == 0 || ends.contains(i)).map(|i| i as usize).collect();
        let interval = straight(points.iter().map(|[x, y]| [*x, *y, speed(*y), 0.0]).collect(), &places);
        let Some(vertices) = device(&interval, ends) else { return };
        let last = points[points.len() - 1][1];
        for place in places {
            let (vertex, [_, y]) = (&vertices[place], points[place]);
            assert_eq!([vertex.k, vertex.l], [1.0, (last - y) / last], "{place} of {count}");
        }
    }
}

/// Edges look at a hull nine times in one invocation: the loop budget allows for 65,536 points that are all looked at.
#[test]
fn new_vertices_have_the_extents_of_brute_force() {
    // Slanted lines, so that products differ in their last bits; the direction is across them, and turns a little.
    for (count, tolerance) in [(3000_u32, 0.0), (65_535, 0.0), (100_000, 1e-4)] {
        let step = 1000.0 / count as f32;
        let at = |i: u32| [100.0 + step * i as f32, 50.0 + 0.5 * step * i as f32];
        let motion = |i: u32| {
            let [x, y] = at(i);
            [x, y, -20.0, 40.0 + 1e-4 * (i as f32 * step)]
        };
        let mut motions: Vec<[f32; 4]> = (0..count).map(motion).collect();
        motions.push([400.0, 100.0, -20.0, 40.0]);
        let corners = [0, count - 1, count];
        let interval = straight(motions, &corners.map(|corner| corner as usize));
        let Some(vertices) = device(&interval, corners) else { return };
        let new = &vertices[count as usize + 1..];
        assert!(new.len() > 100, "{} new vertices", new.len());
        for vertex in new.iter().step_by(1 + new.len() / 60) {
            let Vertex { position: [x, y], velocity: [vx, vy], .. } = *vertex;
            let [k, l] = extent([x, y, vx, vy], &interval.bounds);
            // Of more points than can be looked at, k of a line across the motion is what rounding makes of it.
            let k_off = if tolerance == 0.0 { vertex.k - k } else { 0.0 };
            let off = k_off.abs().max((vertex.l - l).abs());
            assert!(off <= tolerance, "{count} points: {vertex:?} is not {k}, {l}");
        }
    }
}

/// k' and what smoothing adds to it, on a mesh of two clusters and points that stand still.
#[test]
fn smoothing_is_the_references() {
    let sides = [24, 16];
    let animation = swing(sides, 6, [480, 270], 0.4);
    let curve = Curve { keys: vec![[2.0, 0.25], [12.0, 1.0], [40.0, 0.5]] };
    for (strength, rounds, teeth, lead, curve) in [
        (1.0, 8, 43, 0.0, Curve::default()),
        (0.4, 3, 1, 0.0, curve.clone()),
        (3.0, 5, 7, 0.5, Curve::default()),
        (1.0, 0, 2, 1.0, curve),
    ] {
        let settings = Settings { strength, seam_smoothing: rounds, lead, curve, ..incomplete() };
        let mesh: Mesh = crate::scenes::grid(sides);
        let desc = desc(animation.size, &mesh, settings.clone());
        let segments = desc.segments as usize;
        let label = |p: u32| if p % 24 < 4 { 0 } else { 1 + u32::from(p % 24 > 13) };
        let labels: Vec<u32> = (0..24 * 16).map(label).collect();
        let interval = crate::scenes::interval(&animation, 3, &labels, 0.5, teeth, segments);
        let Some(mut rig) = BlurRig::new(desc, mesh.clone()) else { return };
        // Some points have less than all of it, and with one kind of smoothing all have all.
        let shares = |point: u32| (point % 5) as f32 * 0.25;
        rig.shares = if rounds == 8 { Vec::new() } else { (0..24 * 16).map(shares).collect() };
        let knots = animation.knots(3, segments);
        let shot = Shot {
            poses: Some((0, &animation.poses)),
            interval: Some(&interval),
            views: animation.views(3),
            knots: Some(&knots),
        };
        rig.frame(&shot).expect("a frame");
        let pull = Pull { interval: &interval, settings: &settings, height: animation.size[1], seed: 1 };
        let expected = extents(&mesh, &pull, &rig.shares);
        let found: Vec<Extent> = rig.vertices()[..labels.len()]
            .iter()
            .map(|v| Extent { k: v.k, l: v.l, offset: v.smoothing, time: v.time, share: v.share })
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
