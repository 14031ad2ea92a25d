use glam::{DVec2, DVec3};

use super::*;
use crate::blur::mesh::MeshInput;
use crate::blur::reference::{extent, path, spline};
use crate::blur::settings::{self, Space, Trajectory};
use crate::random::{hash, unit};
use crate::view::{Camera, View};

mod breaks;
mod rows;
mod trajectories;

const SIZE: [u32; 2] = [1920, 1080];

/// A mesh and its poses.
#[derive(Clone)]
struct Shot {
    mesh: Mesh,
    poses: Vec<Vec<[f32; 3]>>,
    cameras: Vec<Camera>,
    cuts: Vec<usize>,
}

/// At this depth a pixel is 1/100 metre.
fn camera() -> Camera {
    let depth = 10.0_f64;
    let fov = 2.0 * (5.4 / depth).atan().to_degrees();
    Camera { eye: DVec3::new(0.0, 0.0, depth), target: DVec3::ZERO, vertical_fov: fov, ..Camera::default() }
}

/// World position in the plane z = 0 whose picture is at a pixel position, to rounding.
fn at_pixel(x: f64, y: f64) -> [f32; 3] {
    [((x - 960.0) / 100.0) as f32, ((540.0 - y) / 100.0) as f32, 0.0]
}

fn mesh(vertices: usize, triangles: &[[u32; 3]], objects: Option<&[u32]>) -> Mesh {
    Mesh::new(&MeshInput { vertices, triangles, objects, weld: None, normals: None, rest: None }).unwrap()
}

/// Triangles of a grid of vertices.
fn grid(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    let cells = (0..rows - 1).flat_map(|y| (0..columns - 1).map(move |x| y * columns + x));
    cells.flat_map(|a| [[a, a + 1, a + columns], [a + 1, a + columns + 1, a + columns]]).collect()
}

impl Shot {
    fn new(mesh: Mesh, frames: usize, at: impl Fn(usize, usize) -> [f32; 3]) -> Shot {
        let poses = (0..frames).map(|f| (0..mesh.points()).map(|p| at(p, f)).collect()).collect();
        Shot { mesh, poses, cameras: vec![camera(); frames], cuts: Vec::new() }
    }

    fn views(&self) -> Vec<View> {
        self.cameras.iter().map(|camera| camera.view(SIZE)).collect()
    }

    fn poses<'a>(&'a self, views: &'a [View]) -> Vec<Pose<'a>> {
        let poses = self.poses.iter().zip(views).enumerate();
        poses.map(|(f, (positions, view))| Pose { positions, view, cut: self.cuts.contains(&f) }).collect()
    }

    fn try_interval(&self, settings: &Settings, frame: usize) -> Result<Interval> {
        let views = self.views();
        let window = Window { frame: frame as u32, poses: &self.poses(&views), current: frame, between: &[] };
        let motion = Motion::new(settings, SIZE)?;
        let one = motion.interval(&self.mesh, &window, 1)?;
        assert_eq!(one, motion.interval(&self.mesh, &window, 3)?, "threads change nothing");
        check_invariants(&self.mesh, &one);
        Ok(one)
    }

    fn interval(&self, settings: &Settings, frame: usize) -> Interval {
        self.try_interval(settings, frame).unwrap()
    }

    /// The state of a point in f64 by the reference.
    fn exact(&self, point: usize, time: f64, on_screen: bool) -> spline::State {
        self.exact_along(Trajectory::Spline, point, time, on_screen)
    }

    fn exact_along(&self, trajectory: Trajectory, point: usize, time: f64, on_screen: bool) -> spline::State {
        let positions: Vec<[f32; 3]> = self.poses.iter().map(|pose| pose[point]).collect();
        let held = |f: usize| f > 0 && self.poses[f] == self.poses[f - 1] && self.cameras[f] == self.cameras[f - 1];
        let held: Vec<bool> = (0..self.poses.len()).map(held).collect();
        spline::Path { positions: &positions, views: &self.views(), held: &held, size: SIZE, on_screen, trajectory }
            .at(time)
    }
}

/// The extents of an interval's points.
fn extents(mesh: &Mesh, interval: &Interval, seed: u32) -> Vec<extent::Extent> {
    let pull = extent::Pull { interval, settings: &Settings::default(), height: SIZE[1], seed };
    extent::extents(mesh, &pull, &[])
}

/// Invariants of every interval.
fn check_invariants(mesh: &Mesh, interval: &Interval) {
    assert_eq!(interval.motion.len(), mesh.points());
    assert_eq!(interval.pieces.len(), mesh.points() * interval.segments.len());
    assert!(interval.motion.iter().flatten().all(|c| c.is_finite()));
    let rows = |piece: &Piece| [piece.origin, piece.step, piece.bend_begin, piece.bend_end].concat();
    assert!(interval.pieces.iter().flat_map(rows).all(f32::is_finite));
    let mut counts = vec![0; interval.clusters.len() + 1];
    interval.labels.iter().for_each(|label| counts[*label as usize] += 1);
    assert!(interval.clusters.is_sorted_by_key(|cluster| cluster.points));
    for (label, cluster) in (1..).zip(&interval.clusters) {
        assert_eq!(cluster.points, counts[label]);
        assert!(cluster.bounds_begin < cluster.bounds_end);
        assert!((1..=4096).contains(&cluster.teeth));
    }
    for (point, label) in interval.labels.iter().enumerate() {
        if let Some(cluster) = interval.cluster(*label) {
            assert_eq!(cluster.object, mesh.point_objects()[point]);
        }
    }
    assert!(interval.seams.is_sorted() && interval.seams.iter().all(|p| interval.labels[*p as usize] > 0));
    assert!(interval.bounds.len() as u64 <= most_bounds(mesh.points() as u32));
    rows::check_rows(mesh, interval);
}

/// Five points on curves of their own, up to 60 pixels a frame.
fn wandering(frames: usize) -> Shot {
    Shot::new(mesh(5, &[[0, 1, 2], [2, 3, 4]], None), frames, |p, f| {
        let noise = |d| unit(hash(4, p as u32, f as u32, d)) * 0.3;
        let t = f as f32 * 0.4 + p as f32;
        [2.0 * t.cos() + noise(0), 1.5 * t.sin() + noise(1), (0.7 * t).sin() + noise(2)]
    })
}

/// Labels numbered in the order of their first points: clusters of one size are numbered by their motion's bits.
fn as_first_met(labels: &[u32]) -> Vec<usize> {
    labels.iter().map(|label| labels.iter().position(|other| other == label).unwrap()).collect()
}

/// What a picture is moved by within a pixel moves nothing in it: all is as the later frame has it.
#[test]
fn jitter_is_no_motion() {
    let jitter = |f: usize| [(0.618 * f as f64).fract() - 0.5, (0.414 * f as f64).fract() - 0.5];
    for wanders in [false, true] {
        let mut shot = wandering(40);
        if !wanders {
            shot.poses = vec![shot.poses[20].clone(); 40];
        }
        let still = shot.views();
        let moved: Vec<View> = still.iter().enumerate().map(|(f, view)| View { jitter: jitter(f), ..*view }).collect();
        let [still, moved] = [still, moved].map(|views| {
            let window = Window { frame: 20, poses: &shot.poses(&views), current: 20, between: &[] };
            Motion::new(&Settings::default(), SIZE).unwrap().interval(&shot.mesh, &window, 1).unwrap()
        });
        assert_eq!(as_first_met(&moved.labels), as_first_met(&still.labels));
        assert_eq!(wanders, !moved.clusters.is_empty());
        for (moved, still) in moved.motion.iter().zip(&still.motion) {
            for c in 0..4 {
                // Floats of up to 2000 pixels.
                let by = if c < 2 { jitter(21)[c] } else { 0.0 };
                assert!((f64::from(moved[c]) - f64::from(still[c]) - by).abs() < 2e-4, "{moved:?} {still:?}");
            }
        }
    }
}

#[test]
fn a_cut_separates_trajectories() {
    let shot = wandering(40);
    let mut cut = shot.clone();
    cut.cuts = vec![15, 25];
    let part = |range: std::ops::Range<usize>| Shot {
        poses: shot.poses[range.clone()].to_vec(),
        cameras: shot.cameras[range].to_vec(),
        ..shot.clone()
    };
    let settings = Settings { strength: 2.0, ..Settings::default() };
    let without_frame = |interval: Interval| Interval { generation: 0, ..interval };
    for frame in 15..24 {
        let alone = part(15..25).interval(&settings, frame - 15);
        assert_eq!(without_frame(cut.interval(&settings, frame)), without_frame(alone), "{frame}");
    }
    for frame in [14, 24, 39] {
        let still = cut.interval(&settings, frame);
        assert!(still.clusters.is_empty() && still.segments.len() == 1, "{frame}");
        let next = (frame + 1).min(39);
        let exact = shot.exact(2, next as f64, false).position;
        let [x, y, ..] = still.motion[2].map(f64::from);
        assert!((DVec2::new(x, y) - exact).length() < 2e-4);
    }
}

#[test]
fn a_jump_is_a_cut_and_steady_speed_is_not() {
    let square = |x: f64, p: usize| at_pixel(x + 50.0 * (p % 2) as f64, 300.0 + 50.0 * (p / 2) as f64);
    let jumping =
        Shot::new(mesh(4, &grid(2, 2), None), 30, |p, f| square(if f < 15 { 0.0 } else { 1200.0 } + f as f64, p));
    assert!(jumping.interval(&Settings::default(), 14).clusters.is_empty());
    assert!(!jumping.interval(&Settings { jump: 0.0, ..Settings::default() }, 14).clusters.is_empty());
    // The intervals beside it do not ring, whether it is smeared or not: 1 pixel a frame.
    for (jump, frame) in [(1.0, 13), (1.0, 15), (0.0, 12), (0.0, 13), (0.0, 15), (0.0, 16)] {
        let [_, _, vx, _] = jumping.interval(&Settings { jump, ..Settings::default() }, frame).motion[0];
        assert!((vx - 1.0).abs() < 1e-3, "{frame} {vx}");
    }
    let steady = Shot::new(mesh(4, &grid(2, 2), None), 6, |p, f| square(1200.0 * f as f64 - 2000.0, p));
    assert!(!steady.interval(&Settings::default(), 2).clusters.is_empty());
}

#[test]
fn one_frame_and_one_to_three_points() {
    let still = wandering(1).interval(&Settings::default(), 0);
    assert!(still.clusters.is_empty() && still.seams.is_empty());
    for points in 1..=3_usize {
        let triangles: &[[u32; 3]] = if points == 3 { &[[0, 1, 2]] } else { &[] };
        let shot = Shot::new(mesh(points, triangles, None), 5, |p, f| {
            at_pixel(100.0 + 20.0 * f as f64, 100.0 + 10.0 * p as f64)
        });
        let interval = shot.interval(&Settings::default(), 2);
        assert_eq!(interval.clusters.len(), 1);
        let extents = extents(&shot.mesh, &interval, 1);
        // All are in a line across the motion: there is no front and no rear.
        assert!(extents.iter().all(|extent| extent.k == 1.0 && extent.time == 1.0), "{extents:?}");
    }
}

#[test]
fn what_hardly_moves_is_static() {
    let shot = Shot::new(mesh(4, &grid(2, 2), None), 4, |p, f| {
        at_pixel(500.0 + 100.0 * p as f64 + f as f64 * [0.0, 0.49, 0.51, 30.0][p], 500.0)
    });
    assert_eq!(shot.interval(&Settings::default(), 1).labels, [0, 0, 1, 1]);
}

#[test]
fn what_is_behind_the_camera_stays_undistorted() {
    // Point 1 passes the camera between frames 5 and 6; the camera is at z = 10.
    let shot = Shot::new(mesh(3, &[[0, 1, 2]], None), 12, |p, f| {
        let z = if p == 1 { f as f32 * 2.0 - 1.0 } else { 0.0 };
        [p as f32 * 0.2 + 0.05 * f as f32, 0.1, z]
    });
    for space in [Space::Homogeneous, Space::Screen] {
        let settings = Settings { space, jump: 0.0, ..Settings::default() };
        let labels = |frame| shot.interval(&settings, frame).labels;
        assert!(labels(5)[1] == 0 && labels(4)[1] == 0 && labels(8)[1] == 0);
        assert!(labels(5)[0] > 0 && labels(5)[2] > 0);
        assert_eq!(labels(1)[1] > 0, space == Space::Homogeneous);
    }
}

#[test]
fn positions_that_are_not_finite_are_refused_by_vertex_and_frame() {
    let weld = [0, 1, 1, 2, 0];
    let triangles = [[0, 1, 3], [4, 2, 3]];
    let welded =
        MeshInput { vertices: 5, triangles: &triangles, objects: None, weld: Some(&weld), normals: None, rest: None };
    for (bad, space) in [(f32::NAN, Space::Homogeneous), (f32::INFINITY, Space::Screen), (f32::NAN, Space::Screen)] {
        let mut shot = Shot::new(Mesh::new(&welded).unwrap(), 20, |p, f| at_pixel(10.0 * f as f64, 10.0 * p as f64));
        shot.poses[13][2][1] = bad;
        let error = shot.try_interval(&Settings { space, ..Settings::default() }, 6).unwrap_err().to_string();
        assert!(error.contains("vertex 3 is not at a finite position in frame 13"), "{error}");
        shot.cuts = vec![10];
        assert!(shot.try_interval(&Settings { space, ..Settings::default() }, 6).is_ok());
        shot.poses.truncate(14);
        shot.cuts.clear();
        assert!(shot.try_interval(&Settings { space, ..Settings::default() }, 13).is_err(), "nothing moves");
    }
    let mut short = wandering(3);
    short.poses[2].pop();
    assert!(short.try_interval(&Settings::default(), 1).unwrap_err().to_string().contains("4 positions for 5 points"));
    assert!(wandering(3).try_interval(&Settings::default(), 3).is_err());
}

/// A disc of points that spins about its centre, which is a vertex.
fn spinning(speed: f64) -> Shot {
    let mut triangles = Vec::new();
    for ring in 0..8_u32 {
        for i in 0..32_u32 {
            let [a, b] = [i, (i + 1) % 32].map(|i| 1 + ring * 32 + i);
            match ring {
                0 => triangles.push([0, a, b]),
                _ => triangles.extend([[a - 32, a, b], [b - 32, a - 32, b]]),
            }
        }
    }
    Shot::new(mesh(257, &triangles, None), 30, |p, f| {
        if p == 0 {
            return at_pixel(900.0, 500.0);
        }
        let (radius, angle) = (((p - 1) / 32 + 1) as f64 * 40.0, ((p - 1) % 32) as f64 / 32.0);
        let (y, x) = (angle * std::f64::consts::TAU + speed * f as f64).sin_cos();
        at_pixel(900.0 + radius * x, 500.0 + radius * y)
    })
}

/// The largest angle in degrees between a point's velocity and the sum of its cluster's.
fn largest_angle(interval: &Interval) -> f64 {
    let velocity = |point: usize| DVec2::new(interval.motion[point][2].into(), interval.motion[point][3].into());
    let mut sums = vec![DVec2::ZERO; interval.clusters.len() + 1];
    interval.labels.iter().enumerate().for_each(|(point, label)| sums[*label as usize] += velocity(point));
    let moving = (0..interval.labels.len()).filter(|point| interval.labels[*point] > 0);
    moving.map(|p| velocity(p).angle_to(sums[interval.labels[p] as usize]).abs().to_degrees()).fold(0.0, f64::max)
}

#[test]
fn a_spin_is_divided_until_the_angle_holds() {
    let shot = spinning(0.1);
    for clusters in [settings::Clusters::Direction, settings::Clusters::Ldf] {
        for angle in [20.0, 60.0, 100.0] {
            let settings = Settings { clusters, angle, ..Settings::default() };
            let interval = shot.interval(&settings, 12);
            assert_eq!(interval.labels[0], 0, "the centre stays");
            assert!(interval.labels[1..].iter().all(|label| *label > 0));
            // Spokes are 11.25 degrees apart: a part may end half of that before its angle.
            let least = (180.0 / (f64::from(angle) + 360.0 / 64.0)).ceil() as usize;
            assert!(interval.clusters.len() >= least, "{}", interval.clusters.len());
            // Crumbs are exempt: a disc has none.
            assert!(largest_angle(&interval) <= f64::from(angle) + 1e-3, "{}", largest_angle(&interval));
            assert!(!interval.seams.is_empty());
        }
    }
}

#[test]
fn seams_are_three_edges_wide() {
    // A strip of 20 columns: the left half moves up, the right half down.
    let shot = Shot::new(mesh(40, &grid(20, 2), None), 4, |p, f| {
        let y = if p % 20 < 10 { 10.0 } else { -10.0 };
        at_pixel(300.0 + 40.0 * (p % 20) as f64, 500.0 + 40.0 * (p / 20) as f64 + y * f as f64)
    });
    let interval = shot.interval(&Settings::default(), 1);
    assert_eq!(interval.clusters.len(), 2);
    let expected: Vec<u32> = (0..40).filter(|p| (6..14).contains(&(p % 20))).collect();
    assert_eq!(interval.seams, expected);
    assert!(shot.interval(&Settings { seam_smoothing: 0, ..Settings::default() }, 1).seams.is_empty());
}

#[test]
fn all_velocities_equal_are_one_cluster() {
    for clusters in [settings::Clusters::Direction, settings::Clusters::Ldf] {
        let shot = Shot::new(mesh(100, &grid(10, 10), None), 5, |p, f| {
            at_pixel(300.0 + 30.0 * (p % 10) as f64 + 25.0 * f as f64, 300.0 + 30.0 * (p / 10) as f64)
        });
        let interval = shot.interval(&Settings { clusters, ..Settings::default() }, 2);
        assert_eq!(interval.clusters.len(), 1);
        // 270 pixels across the motion, of 12 each: 22.5 rounds to 23.
        assert_eq!(interval.clusters[0].teeth, 24);
        assert_eq!(interval.clusters[0].points, 100);
        let teeth = |settings: Settings| shot.interval(&settings, 2).clusters[0].teeth;
        assert_eq!(teeth(Settings { teeth: Some(43), ..Settings::default() }), 43);
        assert_eq!(teeth(Settings { tooth_width: Some(90.0), ..Settings::default() }), 4);
        assert_eq!(teeth(Settings { tooth_width: Some(10_000.0), ..Settings::default() }), 2);
        assert_eq!(teeth(Settings { tooth_width: Some(0.1), ..Settings::default() }), 2701);
    }
}

#[test]
fn a_mean_of_zero_is_split_and_coincident_points_are_not() {
    for clusters in [settings::Clusters::Direction, settings::Clusters::Ldf] {
        let settings = Settings { clusters, angle: 180.0, ..Settings::default() };
        let apart = Shot::new(mesh(4, &grid(2, 2), None), 4, |p, f| {
            at_pixel(960.0 + [-1.0, 1.0][p % 2] * (f as f64 + 1.0) * 8.0, 500.0 + p as f64)
        });
        let interval = apart.interval(&settings, 1);
        assert_eq!(interval.clusters.len(), 2);
        assert_eq!(interval.labels[0], interval.labels[2]);
        let same = Shot::new(mesh(4, &grid(2, 2), None), 4, |_, f| at_pixel(500.0 + 8.0 * f as f64, 500.0));
        let interval = same.interval(&Settings { clusters, angle: 0.0, ..Settings::default() }, 1);
        assert_eq!((interval.clusters.len(), interval.bounds.len()), (1, 1));
    }
}

#[test]
fn far_parts_are_apart_and_edges_connect() {
    // Two patches that move alike, of one object; then the same with an edge from one to the other.
    let patch = grid(5, 5);
    let mut triangles: Vec<[u32; 3]> = patch.iter().copied().chain(patch.iter().map(|t| t.map(|v| v + 25))).collect();
    let shot = |triangles: &[[u32; 3]], apart: f64| {
        Shot::new(mesh(50, triangles, None), 4, move |p, f| {
            let (p, x) = (p % 25, apart * (p / 25) as f64);
            at_pixel(300.0 + x + 20.0 * (p % 5) as f64 + 9.0 * f as f64, 300.0 + 20.0 * (p / 5) as f64)
        })
    };
    let count = |shot: Shot| shot.interval(&Settings::default(), 1).clusters.len();
    assert_eq!(count(shot(&triangles, 400.0)), 2);
    assert_eq!(count(shot(&triangles, 100.0)), 1, "neighbouring cells");
    triangles.push([4, 25, 30]);
    assert_eq!(count(shot(&triangles, 400.0)), 1, "an edge");
}

#[test]
fn objects_are_borders_and_crumbs_join() {
    let objects: Vec<u32> = (0..900).map(|p| u32::from(p % 30 >= 15)).collect();
    let split: Vec<[u32; 3]> =
        grid(30, 30).into_iter().filter(|t| t.iter().all(|v| objects[*v as usize] == objects[t[0] as usize])).collect();
    // Two points of the left object go against the others.
    let shot = Shot::new(mesh(900, &split, Some(&objects)), 4, |p, f| {
        let speed = if p == 305 || p == 306 { -9.0 } else { 9.0 };
        at_pixel(300.0 + 20.0 * (p % 30) as f64 + speed * f as f64, 300.0 + 20.0 * (p / 30) as f64)
    });
    let interval = shot.interval(&Settings::default(), 1);
    assert_eq!(interval.clusters.iter().map(|c| (c.points, c.object)).collect::<Vec<_>>(), [(450, 0), (450, 1)]);
    // The seed keeps them apart.
    let ldf = Settings { clusters: settings::Clusters::Ldf, ..Settings::default() };
    let interval = shot.interval(&ldf, 1);
    assert!(interval.clusters.len() > 2 && largest_angle(&interval) < 60.0);
}

/// A grid with some motion in all of it, in an order of its own for each seed.
fn shuffled(seed: u32) -> (Shot, Vec<usize>) {
    let mut order: Vec<usize> = (0..1200).collect();
    order.sort_by_key(|p| if seed == 0 { *p as u32 } else { hash(seed, *p as u32, 0, 0) });
    let mut place = vec![0; 1200];
    order.iter().enumerate().for_each(|(new, old)| place[*old] = new as u32);
    let mut triangles: Vec<[u32; 3]> = grid(40, 30).iter().map(|t| t.map(|v| place[v as usize])).collect();
    if seed > 0 {
        triangles.sort_by_key(|t| hash(seed, t[0], t[1], t[2]));
        triangles.iter_mut().for_each(|t| t.rotate_left(1));
    }
    let shot = Shot::new(mesh(1200, &triangles, None), 30, |p, f| {
        let (x, y) = ((order[p] % 40) as f64 * 21.0, (order[p] / 40) as f64 * 21.0);
        let t = f as f64 * 0.3;
        let (dx, dy) = ((x * 0.01 + t).sin() * 60.0 + 3.0 * t, (y * 0.013 - x * 0.02 + 1.3 * t).cos() * 70.0);
        at_pixel(300.0 + x + dx, 200.0 + y + dy)
    });
    (shot, order)
}

#[test]
fn the_order_of_points_and_triangles_changes_nothing() {
    for clusters in [settings::Clusters::Direction, settings::Clusters::Ldf] {
        let settings = Settings { clusters, ..Settings::default() };
        let (shot, _) = shuffled(0);
        let reference = shot.interval(&settings, 14);
        let expected = extents(&shot.mesh, &reference, 5);
        assert!(reference.clusters.len() > 3 && reference.seams.len() > 100);
        for seed in 1..4 {
            let (shot, order) = shuffled(seed);
            let interval = shot.interval(&settings, 14);
            assert_eq!(interval.clusters, reference.clusters);
            assert_eq!(interval.bounds, reference.bounds);
            let other = extents(&shot.mesh, &interval, 5);
            for (new, old) in order.iter().enumerate() {
                assert_eq!(interval.labels[new], reference.labels[*old]);
                assert_eq!(interval.motion[new], reference.motion[*old]);
                assert_eq!(interval.pieces[new], reference.pieces[*old]);
                assert_eq!(other[new], expected[*old]);
            }
            let mut seams: Vec<u32> = interval.seams.iter().map(|p| order[*p as usize] as u32).collect();
            seams.sort_unstable();
            assert_eq!(seams, reference.seams);
        }
    }
}

#[test]
fn the_hull_is_as_extreme_as_all_points_bit_for_bit() {
    fn uniform(i: u32, d: u32) -> f32 {
        unit(hash(6, i, 0, d))
    }
    let turn = std::f32::consts::TAU;
    let normal = move |i: u32, d: u32| (-2.0 * uniform(i, d).ln()).sqrt() * (turn * uniform(i, d + 2)).cos();
    let angle = move |i: u32| turn * uniform(i, 5);
    type Set = (&'static str, Box<dyn Fn(u32) -> [f32; 2]>);
    let sets: [Set; 9] = [
        ("gauss", Box::new(move |i| [normal(i, 0) * 200.0 + 960.0, normal(i, 1) * 100.0 + 540.0])),
        (
            "disc",
            Box::new(move |i| {
                let r = uniform(i, 0).sqrt() * 400.0;
                [960.0 + r * angle(i).cos(), 540.0 + r * angle(i).sin()]
            }),
        ),
        ("grid", Box::new(|i| [(i % 45) as f32 * 10.1 + 3.0, (i / 45) as f32 * 9.7])),
        (
            "tilted grid",
            Box::new(|i| {
                let (x, y) = ((i % 45) as f32, (i / 45) as f32);
                [400.0 + 9.0 * x - 4.3 * y, 200.0 + 4.3 * x + 9.0 * y]
            }),
        ),
        ("line", Box::new(|i| [100.0 + 0.37 * i as f32, 900.0 - 0.11 * i as f32])),
        ("circle", Box::new(move |i| [960.0 + 300.0 * angle(i).cos(), 540.0 + 300.0 * angle(i).sin()])),
        ("far gauss", Box::new(move |i| [normal(i, 0) * 2.0 + 1e5, normal(i, 1) - 1e5])),
        ("one point", Box::new(|_| [33.3, 44.4])),
        ("two points", Box::new(|i| [33.3 + (i % 2) as f32, 44.4])),
    ];
    for (name, point) in sets {
        let points: Vec<[f32; 2]> = (0..2000).map(point).collect();
        let hull = outline(&points);
        for i in 0..2000_u32 {
            let [x, y] = points[i as usize];
            let motion = [x, y, normal(i, 8) * 20.0, normal(i, 9) * 20.0];
            let (all, few) = (extent::extent(motion, &points), extent::extent(motion, &hull));
            assert_eq!(all.map(f32::to_bits), few.map(f32::to_bits), "{name} {motion:?}");
            if name != "far gauss" {
                let wide: Vec<[f64; 2]> = hull.iter().map(|p| p.map(f64::from)).collect();
                let exact = extent::extent_f64(motion.map(f64::from), &wide);
                assert!((0..2).all(|c| (exact[c] - f64::from(all[c])).abs() < 2e-3), "{name} {exact:?} {all:?}");
            }
        }
        assert!(name != "gauss" || hull.len() < 60, "{}", hull.len());
    }
}

#[test]
fn coordinates_far_outside_of_the_picture_are_worked_on() {
    let shot = Shot::new(mesh(9, &grid(3, 3), None), 5, |p, f| {
        at_pixel(1e5 + 4.0 * (p % 3) as f64 + 20.0 * f as f64, -1e5 + 4.0 * (p / 3) as f64)
    });
    let interval = shot.interval(&Settings::default(), 2);
    assert_eq!(interval.clusters.len(), 1);
    for point in 0..9 {
        let exact = shot.exact(point, 2.5, false);
        let [x, y, vx, vy] = interval.motion[point].map(f64::from);
        // Two ulp at 1e5.
        assert!((DVec2::new(x, y) - exact.position).abs().max_element() < 0.016);
        assert!((DVec2::new(vx, vy) - exact.velocity).abs().max_element() < 1e-4);
    }
    // Numbers that no pixel has stay numbers.
    let huge = Shot::new(mesh(3, &[[0, 1, 2]], None), 5, |p, f| [1e37 * (p as f32 + 1.0), 3e38, f as f32]);
    assert!(huge.interval(&Settings::default(), 2).motion.iter().flatten().all(|c| c.is_finite()));
}
