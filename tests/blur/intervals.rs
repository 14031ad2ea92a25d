//! Intervals that take the place of others: the same as new ones, in memory that is there.

use std::collections::BTreeSet;

use celfx::blur::motion::{Motion, Window};
use celfx::blur::settings::{Clusters, Lines, Space, Trajectory};
use celfx::blur::{FrameView, Interval, Mesh, MeshInput, Parts, Pose, Settings};
use celfx::io::scene::{AnimatedMesh, Clock};
use celfx::simulate::mesh::Builtin;
use celfx::view::View;

use crate::common::allocations::allocated;
use crate::parts::bands;

const SIZE: [u32; 2] = [640, 360];

/// A mesh of several objects, with all that may come of it in a shot.
struct Shot {
    mesh: Mesh,
    poses: Vec<Vec<[f32; 3]>>,
    views: Vec<View>,
    cut: Option<usize>,
    /// Poses after each frame, before the next one.
    between: Vec<Vec<Vec<[f32; 3]>>>,
}

impl Shot {
    /// At each of these times, with so many poses between them.
    fn new(which: Builtin, vertices: u32, times: &[f64], between: u32) -> Shot {
        let scene = AnimatedMesh::builtin(which, vertices, Clock { first: 0, fps: which.fps() });
        let topology = scene.topology();
        let input = MeshInput {
            vertices: scene.vertices(),
            triangles: &topology.triangles,
            objects: Some(&topology.object),
            weld: Some(&scene.weld()),
            normals: None,
            rest: None,
        };
        let mesh = Mesh::new(&input).expect("a mesh");
        let pose = |time: f64| mesh.gather(&scene.pose(time).expect("a pose")).expect("a position a vertex");
        let step = 1.0 / f64::from(between + 1);
        let inner = |time: &f64| (1..=between).map(|k| pose(time + step * f64::from(k))).collect();
        let camera = |time: &f64| scene.camera(*time).expect("a camera").view(SIZE);
        Shot {
            poses: times.iter().map(|time| pose(*time)).collect(),
            views: times.iter().map(camera).collect(),
            cut: None,
            between: times.iter().map(inner).collect(),
            mesh,
        }
    }

    fn frames(&self) -> std::ops::Range<usize> {
        0..self.poses.len()
    }

    /// Gives all that is made of each frame of one pass over the shot to `take`: the interval, and how often it, its knots
    /// and those of the views alone allocated.
    fn pass(
        &self,
        (motion, interval): (&mut Motion, &mut Interval),
        parts: Option<&Parts>,
        mut take: impl FnMut(usize, &Window, &Interval, usize),
    ) {
        let poses = self.poses.iter().zip(&self.views).enumerate();
        let poses = poses.map(|(frame, (positions, view))| Pose { positions, view, cut: self.cut == Some(frame) });
        let poses: Vec<Pose> = poses.collect();
        let seen = self.views.iter().zip(0..).map(|(view, frame)| FrameView { frame, view: *view });
        let seen: Vec<FrameView> = seen.collect();
        for current in self.frames() {
            let view = &self.views[current];
            let between = self.between[current].iter().map(|positions| Pose { positions, view, cut: false });
            let between: Vec<Pose> = between.collect();
            let window = Window { frame: current as u32, poses: &poses, current, between: &between };
            let before = allocated();
            motion.renew(interval, &self.mesh, &window, parts, 1).expect("an interval");
            let _ = motion.knots(&window);
            let _ = motion.knots_of_views(&seen, current);
            take(current, &window, interval, allocated() - before);
        }
    }

    /// Checks each frame, after a pass over the shot; the numbers of clusters that there were.
    fn check(&self, name: &str, settings: &Settings, parts: Option<&Parts>) -> BTreeSet<usize> {
        let (mut motion, mut interval) = (Motion::new(settings, SIZE).expect("settings"), Interval::default());
        let mut first = 0;
        self.pass((&mut motion, &mut interval), parts, |_, _, _, allocations| first += allocations);
        assert!(first > 0, "{name}: allocations are not counted");
        let mut counts = BTreeSet::new();
        self.pass((&mut motion, &mut interval), parts, |frame, window, interval, allocations| {
            assert_eq!(allocations, 0, "{name}: frame {frame} allocates");
            let fresh = Motion::new(settings, SIZE).expect("settings");
            let expected = match parts {
                Some(parts) => fresh.interval_of_parts(&self.mesh, window, parts, 2),
                None => fresh.interval(&self.mesh, window, 2),
            };
            assert!(*interval == expected.expect("an interval"), "{name}: frame {frame} differs");
            counts.insert(interval.clusters.len());
        });
        counts
    }
}

fn times(frames: u32) -> Vec<f64> {
    (0..frames).map(f64::from).collect()
}

#[test]
fn a_shot_is_renewed_in_the_memory_of_its_first_pass() {
    let settings = Settings::default();
    // Nothing moves in the last frame, and from a held one to the next; poses that are held reach beyond any window.
    let mut held = times(140);
    held.iter_mut().for_each(|time| *time = (*time / 5.0).floor());
    let mut run = Shot::new(Builtin::Run, 1500, &held, 0);
    run.cut = Some(61);
    let counts = run.check("held", &settings, None);
    assert!(counts.contains(&0) && counts.len() > 3, "{counts:?}");
    let past = Settings { trajectory: Trajectory::Past, strength: 2.5, space: Space::Screen, ..settings.clone() };
    run.check("past", &past, None);
    let mut spin = Shot::new(Builtin::Spin, 600, &times(24), 5);
    let exact = Settings {
        trajectory: Trajectory::Exact,
        lines: Lines { count: 3, length: 1.5, ..Lines::default() },
        ..settings.clone()
    };
    spin.check("exact", &exact, None);
    spin.cut = Some(11);
    let ldf = Settings { clusters: Clusters::Ldf, angle: 20.0, ..settings.clone() };
    let counts = spin.check("ldf", &ldf, None);
    assert!(counts.len() > 3, "{counts:?}");
    spin.check("parts", &settings, Some(&bands(&spin.mesh)));
}

/// Nothing of one mesh, or of a call that failed, is in the interval of another.
#[test]
fn what_was_before_changes_nothing() {
    let settings = Settings { strength: 2.0, ..Settings::default() };
    let shots = [Shot::new(Builtin::Run, 900, &times(12), 0), Shot::new(Builtin::Crossing, 300, &times(9), 0)];
    let (mut motion, mut interval) = (Motion::new(&settings, SIZE).expect("settings"), Interval::default());
    for shot in [&shots[0], &shots[1], &shots[0]] {
        let mut bad = shot.poses[4].clone();
        bad[7][1] = f32::NAN;
        let positions = [&shot.poses[3], &bad];
        let poses = positions.map(|positions| Pose { positions, view: &shot.views[3], cut: false });
        for current in [0, 1] {
            let window = Window { frame: 3, poses: &poses, current, between: &[] };
            motion.renew(&mut interval, &shot.mesh, &window, None, 1).expect_err("it is refused");
        }
        shot.pass((&mut motion, &mut interval), None, |frame, window, interval, _| {
            let expected = Motion::new(&settings, SIZE).expect("settings").interval(&shot.mesh, window, 1);
            assert!(*interval == expected.expect("an interval"), "frame {frame}");
        });
    }
}
