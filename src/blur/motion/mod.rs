//! Where the points of a mesh are between two frames, which of them move together, and where clusters meet: all that
//! the device needs of an animation for one output.

mod clusters;
mod direction;
mod fronts;
mod hull;
mod knots;
mod ldf;
mod projection;
mod seams;
mod spline;
mod trace;

use bytemuck::{Pod, Zeroable};

use clusters::Clusters;
use spline::Knot;
use trace::{Task, Traces};

pub use crate::shaders::blur::constants::{FRONT_BITS, FRONTS_A_WORD};
pub use projection::Projection;
pub use seams::MOST_NEIGHBOURS;

use super::mesh::Mesh;
use super::settings::{Settings, Trajectory};
use crate::error::{Error, Result};
pub use crate::shaders::blur::blocks::{Cluster, Piece};
use crate::view::Camera;

/// The mesh in one frame, and what sees it.
#[derive(Clone, Copy, Debug)]
pub struct Pose<'a> {
    /// World position of each point in metres, finite.
    pub positions: &'a [[f32; 3]],
    /// The camera of the frame.
    pub camera: &'a Camera,
    /// Whether a new shot begins here: trajectories do not go from the pose before to this one.
    pub cut: bool,
}

/// What is known around the frames i and i + 1, from which output i + 1 is made.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    /// Number i of the earlier frame in the shot.
    pub frame: u32,
    /// Poses of consecutive frames. [`WINDOW`] before frame i and after frame i + 1, as far as the shot has them, are
    /// used; more only where poses are held.
    pub poses: &'a [Pose<'a>],
    /// Place of frame i in `poses`. If it is the last one, nothing moves.
    pub current: usize,
    /// With `trajectory = "exact"`: poses at equal steps between frames i and i + 1, without these two. May be empty.
    pub between: &'a [Pose<'a>],
}

/// Different poses to each side of the interval that its trajectories depend on: the others would change them by less
/// than 2e-6 pixels.
pub const WINDOW: usize = 12;

/// Frames to each side of an interval in which different poses are looked for, where poses are held.
pub(crate) const MOST_FRAMES: usize = 4 * WINDOW;

/// A piece of the trajectories, from one time to another, in frames after frame i.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Segment {
    /// Its first time.
    pub begin: f32,
    /// Its last time, above `begin`.
    pub end: f32,
}

/// All that the device needs of an animation for output i + 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interval {
    /// Number of the teeth's random numbers in time: the frame number divided by `hold`.
    pub generation: u32,
    /// Position x, y in pixels, y down, and velocity in pixels per frame of each point at the reference time.
    pub motion: Vec<[f32; 4]>,
    /// Cluster of each point, from 1; 0: it stays where it is in frame i + 1 (k' = 1), and is in none.
    pub labels: Vec<u32>,
    /// The clusters, by ascending number of points, so that the larger label is the larger cluster. Empty: nothing moves.
    pub clusters: Vec<Cluster>,
    /// Extreme points of the clusters in pixels. k and l that are found from them have the same bits as those from all
    /// of a cluster's points.
    pub hull: Vec<[f32; 2]>,
    /// Points within 3 edges of a seam, ascending; those in no cluster and those with too many neighbours are not here.
    pub seams: Vec<u32>,
    /// Which side of each triangle is outside: [`FRONT_BITS`] each, [`FRONTS_A_WORD`] of them a word. 1: it is of a closed
    /// surface that is seen from outside; then 2: the outside is where its corners follow each other clockwise in frame i, 4: in
    /// frame i + 1.
    pub fronts: Vec<u32>,
    /// The segment that begins at 0, those after it up to frame i + 1, then those before it, from the latest. There is
    /// more than one with `trajectory = "exact"` and where the smear reaches back farther than frame i.
    pub segments: Vec<Segment>,
    /// Piece of segment s and point p: `pieces[s * points + p]`. Before the earliest segment trajectories are straight.
    pub pieces: Vec<Piece>,
}

impl Interval {
    /// The cluster with a label; none for 0.
    pub fn cluster(&self, label: u32) -> Option<&Cluster> {
        self.clusters.get((label as usize).checked_sub(1)?)
    }

    /// The extreme points of a cluster.
    pub fn hull_of(&self, cluster: &Cluster) -> &[[f32; 2]] {
        &self.hull[cluster.hull_begin as usize..cluster.hull_end as usize]
    }
}

/// Makes [`Interval`]s. Holds nothing of one that the next depends on.
#[derive(Clone, Debug)]
pub struct Motion {
    settings: Settings,
    size: [u32; 2],
}

impl Motion {
    /// For pictures of `size` pixels.
    ///
    /// # Errors
    /// A setting out of range.
    pub fn new(settings: &Settings, size: [u32; 2]) -> Result<Motion> {
        settings.validate()?;
        Ok(Motion { settings: settings.clone(), size })
    }

    /// The interval from frame i to frame i + 1, found on `threads` threads, of which the caller's is one. Their number
    /// changes nothing of the result.
    ///
    /// # Errors
    /// A pose with another number of points, or a position that is not finite; it names frame and vertex.
    pub fn interval(&self, mesh: &Mesh, window: &Window, threads: usize) -> Result<Interval> {
        check(mesh, window)?;
        let window = &self.nearby(window);
        let generation = window.frame / self.settings.hold;
        let traces = self.traces(window, threads).ok_or_else(|| not_finite(mesh, window))?;
        let (segments, traces) = traces;
        let clusters = clusters::find(mesh, &traces, &self.settings, self.size[1]);
        let seams = match self.settings.seam_smoothing {
            0 => Vec::new(),
            _ => seams::find(mesh, &clusters.labels),
        };
        let current = &window.poses[window.current];
        let next = window.poses.get(window.current + 1).unwrap_or(current);
        let fronts = fronts::find(mesh, [current, next], self.size);
        let Clusters { clusters, labels, hull } = clusters;
        let Traces { motion, pieces, .. } = traces;
        Ok(Interval { generation, motion, labels, clusters, hull, seams, fronts, segments, pieces })
    }

    /// The part of a window that is looked at: it has enough poses even where each is held for some frames.
    fn nearby<'a>(&self, window: &Window<'a>) -> Window<'a> {
        let first = window.current.saturating_sub(MOST_FRAMES);
        let end = window.poses.len().min(window.current + 2 + MOST_FRAMES);
        let between = if self.settings.trajectory == Trajectory::Exact { window.between } else { &[] };
        Window { frame: window.frame, poses: &window.poses[first..end], current: window.current - first, between }
    }

    /// Segments and traces; `None` if a position that is used is not finite.
    fn traces(&self, window: &Window, threads: usize) -> Option<(Vec<Segment>, Traces)> {
        let project = |pose: &Pose| Projection::new(pose.camera, self.size);
        let (space, reach) = (self.settings.space, f64::from(self.settings.reach()));
        let next = window.poses.get(window.current + 1);
        let cuts = cuts(window.poses, f64::from(self.settings.jump) * f64::from(self.size[1]), project);
        let timeline = match next {
            Some(_) if !cuts.contains(&(window.current + 1)) => {
                Some(spline::timeline(window, &cuts, reach.ceil() as usize, project))
            }
            _ => None,
        };
        match timeline.filter(|timeline| timeline.ends[0] != timeline.ends[1]) {
            Some(timeline) => {
                let segments = timeline.spans.iter().map(|span| span.segment).collect();
                let reference_time = f64::from(self.settings.reference_time);
                let task = Task { timeline: &timeline, space, reference_time, reach };
                Some((segments, Traces::new(task, threads)?))
            }
            None => {
                let pose = next.unwrap_or(&window.poses[window.current]);
                let knot = Knot { time: 0.0, positions: pose.positions, projection: project(pose) };
                Some((vec![Segment { begin: 0.0, end: 1.0 }], Traces::still(&knot, space)?))
            }
        }
    }
}

/// Those of a cluster's points, each once, that can be extreme: the convex hull with what is on its sides, and what is so
/// near to it that rounding in f32 can make it extreme, in the order in which one comes by when going around it. A line's
/// from one end to the other.
pub fn outline(points: &[[f32; 2]]) -> Vec<[f32; 2]> {
    hull::extremes(points)
}

fn refused(why: String) -> Error {
    Error::HostResource { name: "blur poses", why }
}

/// Refuses a window that is not one of the mesh.
fn check(mesh: &Mesh, window: &Window) -> Result<()> {
    if window.current >= window.poses.len() {
        return Err(refused(format!("frame {} is not among the {} poses", window.frame, window.poses.len())));
    }
    for pose in window.poses.iter().chain(window.between) {
        if pose.positions.len() != mesh.points() {
            let (given, points) = (pose.positions.len(), mesh.points());
            return Err(refused(format!("{given} positions for {points} points; gather them with Mesh::gather")));
        }
        pose.camera.validate()?;
    }
    Ok(())
}

/// Names a position that is not finite.
fn not_finite(mesh: &Mesh, window: &Window) -> Error {
    let finite = |position: &[f32; 3]| position.iter().all(|c| c.is_finite());
    let point = |pose: &Pose| pose.positions.iter().position(|position| !finite(position));
    let vertex = |point: usize| mesh.point_to_file()[point];
    let frames = window.poses.iter().enumerate().map(|(j, pose)| (j as i64 - window.current as i64, pose));
    let bad = frames.filter_map(|(j, pose)| Some((i64::from(window.frame) + j, point(pose)?))).next();
    let between = || window.between.iter().find_map(point);
    match (bad, between()) {
        (Some((frame, point)), _) => {
            refused(format!("vertex {} is not at a finite position in frame {frame}", vertex(point)))
        }
        (None, Some(point)) => {
            let (vertex, frame) = (vertex(point), window.frame);
            refused(format!("vertex {vertex} is not at a finite position between frames {frame} and {}", frame + 1))
        }
        (None, None) => refused(format!("a camera near frame {} is too far from the mesh", window.frame)),
    }
}

/// Poses that trajectories do not reach from the ones before: those that say so, and those to which the centre of the
/// mesh's box moves farther than `jump` pixels, and more than 4 times as far as in the frames before and after (in one of
/// them at least it must be seen). None of the latter if `jump` is 0.
fn cuts(poses: &[Pose], jump: f64, project: impl Fn(&Pose) -> Projection) -> Vec<usize> {
    let centre = |pose: &Pose| {
        let (projection, [low, high]) = (project(pose), bounds(pose.positions));
        let clip = projection.clip([0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]));
        (clip.is_finite() && clip.z > projection.near).then(|| clip.truncate() / clip.z)
    };
    let centres: Vec<_> = if jump > 0.0 { poses.iter().map(centre).collect() } else { vec![None; poses.len()] };
    let moves: Vec<Option<f64>> = centres.windows(2).map(|c| Some((c[1]? - c[0]?).length())).collect();
    let jumps = |j: usize| {
        let beside = [j.checked_sub(2), Some(j)].map(|k| k.and_then(|k| *moves.get(k)?));
        let usual = beside.into_iter().flatten().reduce(f64::max);
        usual.zip(moves[j - 1]).is_some_and(|(usual, own)| own > jump && own > 4.0 * usual)
    };
    (1..poses.len()).filter(|j| poses[*j].cut || jumps(*j)).collect()
}

/// Lowest and highest coordinates.
fn bounds(positions: &[[f32; 3]]) -> [[f32; 3]; 2] {
    // Four points at a time: the compiler makes it lanes.
    let (blocks, rest) = positions.as_chunks::<4>();
    let (mut low, mut high) = ([[f32::MAX; 3]; 4], [[f32::MIN; 3]; 4]);
    for block in blocks.iter() {
        for k in 0..12 {
            low[k / 3][k % 3] = low[k / 3][k % 3].min(block[k / 3][k % 3]);
            high[k / 3][k % 3] = high[k / 3][k % 3].max(block[k / 3][k % 3]);
        }
    }
    let fold = |all: [[f32; 3]; 4], with: fn(f32, f32) -> f32| {
        let points = all.iter().chain(rest);
        points.copied().reduce(|a, b| [0, 1, 2].map(|axis| with(a[axis], b[axis]))).unwrap_or_default()
    };
    [fold(low, f32::min), fold(high, f32::max)]
}

#[cfg(test)]
mod tests;
