//! Where the points of a mesh are between two frames, which of them move together, and where clusters meet: all that
//! the device needs of an animation for one output.

mod clusters;
mod direction;
mod fronts;
mod hull;
mod knots;
mod ldf;
mod movers;
mod projection;
pub(super) mod seams;
mod spline;
mod trace;
mod window;

use clusters::Clusters;
use trace::{Task, Traces};

pub use crate::shaders::blur::constants::{FRONT_BITS, FRONTS_A_WORD};
pub use projection::PixelClip;
pub(crate) use projection::clip_rows;
pub use seams::MOST_NEIGHBOURS;
pub(crate) use window::MOST_FRAMES;
pub use window::{FrameView, Interval, Knot, Pose, Segment, WINDOW, Window};

use super::mesh::Mesh;
use super::parts::Parts;
use super::settings::{Settings, Space, Trajectory};
use crate::error::{Error, Result};
pub use crate::shaders::blur::blocks::{Cluster, Piece};

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
        self.interval_with(mesh, window, threads, |traces| {
            let clusters = clusters::find(mesh, traces, &self.settings, self.size[1]);
            let seams = seams::find(mesh, &clusters.labels);
            (clusters, seams)
        })
    }

    /// The same with clusters that the host has named.
    ///
    /// # Errors
    /// As [`Motion::interval`].
    pub fn interval_of_parts(&self, mesh: &Mesh, window: &Window, parts: &Parts, threads: usize) -> Result<Interval> {
        self.interval_with(mesh, window, threads, |traces| {
            let clusters = clusters::of_parts(mesh, traces, &self.settings, self.size[1], parts);
            let seams = parts.seams().iter().copied().filter(|point| clusters.labels[*point as usize] > 0).collect();
            (clusters, seams)
        })
    }

    /// `divide`: clusters and points near seams.
    fn interval_with(
        &self,
        mesh: &Mesh,
        window: &Window,
        threads: usize,
        divide: impl FnOnce(&Traces) -> (Clusters, Vec<u32>),
    ) -> Result<Interval> {
        check(mesh, window)?;
        let window = &self.nearby(window);
        let generation = window.frame / self.settings.hold;
        let traces = self.traces(window, threads).ok_or_else(|| not_finite(mesh, window))?;
        let (segments, traces) = traces;
        let (clusters, seams) = divide(&traces);
        let seams = if self.settings.seam_smoothing > 0 { seams } else { Vec::new() };
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
        let later = if self.settings.trajectory == Trajectory::Past { 0 } else { MOST_FRAMES };
        let end = window.poses.len().min(window.current + 2 + later);
        let between = if self.settings.trajectory == Trajectory::Exact { window.between } else { &[] };
        Window { frame: window.frame, poses: &window.poses[first..end], current: window.current - first, between }
    }

    /// The projection of a pose: all are of one picture, that of frame i + 1.
    fn project(&self, window: &Window, pose: &Pose) -> PixelClip {
        let next = window.poses.get(window.current + 1).unwrap_or(&window.poses[window.current]);
        PixelClip::new(pose.view, next.view.jitter, self.size)
    }

    /// Segments and traces; `None` if a position that is used is not finite.
    fn traces(&self, window: &Window, threads: usize) -> Option<(Vec<Segment>, Traces)> {
        let project = |pose: &Pose| self.project(window, pose);
        let next = window.poses.get(window.current + 1);
        // Of an orthographic view both are the same.
        let is_orthographic = project(&window.poses[window.current]).is_orthographic;
        let space = if is_orthographic { Space::Screen } else { self.settings.space };
        let reach = f64::from(self.settings.reach());
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
                let trajectory = self.settings.trajectory;
                let task = Task { timeline: &timeline, space, trajectory, reference_time, reach };
                Some((segments, Traces::new(task, threads)?))
            }
            None => {
                let pose = next.unwrap_or(&window.poses[window.current]);
                let knot = spline::Knot { time: 0.0, positions: pose.positions, projection: project(pose) };
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
        pose.view.validate()?;
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
fn cuts(poses: &[Pose], jump: f64, project: impl Fn(&Pose) -> PixelClip) -> Vec<usize> {
    let centre = |pose: &Pose| {
        let (projection, [low, high]) = (project(pose), bounds(pose.positions));
        let clip = projection.clip([0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]));
        (clip.is_finite() && clip.z > projection.near).then(|| projection.pixel_of(clip))
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
