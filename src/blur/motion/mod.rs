//! Where the points of a mesh are between two frames, which of them move together, and where clusters meet: all that
//! the device needs of an animation for one output.

mod breaks;
mod clusters;
mod crumbs;
mod direction;
mod fronts;
mod hull;
mod knots;
mod ldf;
mod movers;
mod projection;
mod ranks;
mod rows;
pub(super) mod seams;
mod spline;
mod timeline;
mod trace;
mod window;

use std::ops::Range;

use breaks::{Corners, Cuts, corners};
use clusters::Found;
use timeline::Timeline;
use trace::Traces;

pub use crate::shaders::blur::constants::{FRONT_BITS, FRONTS_A_WORD};
pub use projection::PixelClip;
pub(crate) use projection::clip_rows;
pub(super) use rows::ROW;
pub use rows::most_bounds;
pub use seams::MOST_NEIGHBOURS;
pub(crate) use window::MOST_FRAMES;
pub use window::{FrameView, Interval, Knot, Pose, Segment, WINDOW, Window};

use super::mesh::Mesh;
use super::parts::Parts;
use super::settings::{Settings, Space, Trajectory};
use crate::error::{Error, Result};
pub use crate::shaders::blur::blocks::{Cluster, Piece};

impl Cluster {
    /// Whether front and rear are those of rows across its direction: it has one.
    pub fn has_rows(&self) -> bool {
        self.ahead != [0.0; 2]
    }
}

/// Makes [`Interval`]s. Besides settings it keeps memory to work in, and nothing of one interval that the next depends on.
#[derive(Clone, Debug)]
pub struct Motion {
    settings: Settings,
    size: [u32; 2],
    scratch: Scratch,
}

/// What every interval is found in: buffers that keep their memory.
#[derive(Clone, Debug, Default)]
struct Scratch {
    cuts: Cuts,
    timeline: Timeline,
    trace: trace::Scratch,
    clusters: clusters::Scratch,
    seams: seams::Scratch,
    fronts: fronts::Scratch,
    knots: knots::Found,
}

impl Motion {
    /// For pictures of `size` pixels.
    ///
    /// # Errors
    /// A setting out of range.
    pub fn new(settings: &Settings, size: [u32; 2]) -> Result<Motion> {
        settings.validate()?;
        Ok(Motion { settings: settings.clone(), size, scratch: Scratch::default() })
    }

    /// The interval from frame i to frame i + 1, found on `threads` threads, of which the caller's is one. Their number
    /// changes nothing of the result. [`Motion::renew`] finds the same without allocating.
    ///
    /// # Errors
    /// A pose with another number of points, or a position that is not finite; it names frame and vertex.
    pub fn interval(&self, mesh: &Mesh, window: &Window, threads: usize) -> Result<Interval> {
        let mut interval = Interval::default();
        self.find(&mut Scratch::default(), &mut interval, mesh, window, None, threads)?;
        Ok(interval)
    }

    /// The same with clusters that the host has named.
    ///
    /// # Errors
    /// As [`Motion::interval`].
    pub fn interval_of_parts(&self, mesh: &Mesh, window: &Window, parts: &Parts, threads: usize) -> Result<Interval> {
        let mut interval = Interval::default();
        self.find(&mut Scratch::default(), &mut interval, mesh, window, Some(parts), threads)?;
        Ok(interval)
    }

    /// Finds an interval in the place of an earlier one, or of [`Interval::default`]: that of [`Motion::interval`], or, with
    /// `parts`, of [`Motion::interval_of_parts`].
    ///
    /// For the frames of a game: the memory that was worked in and that of the results is used again. Once it is enough for the
    /// shot, a call with one thread allocates nothing; starting more of them does.
    ///
    /// # Errors
    /// As [`Motion::interval`]; the interval is then of no use.
    pub fn renew(
        &mut self,
        interval: &mut Interval,
        mesh: &Mesh,
        window: &Window,
        parts: Option<&Parts>,
        threads: usize,
    ) -> Result<()> {
        self.with_scratch(|motion, scratch| motion.find(scratch, interval, mesh, window, parts, threads))
    }

    /// The scratch is taken out, so that it can be written while settings are read.
    fn with_scratch<R>(&mut self, work: impl FnOnce(&Motion, &mut Scratch) -> R) -> R {
        let mut scratch = std::mem::take(&mut self.scratch);
        let result = work(self, &mut scratch);
        self.scratch = scratch;
        result
    }

    fn find(
        &self,
        scratch: &mut Scratch,
        interval: &mut Interval,
        mesh: &Mesh,
        window: &Window,
        parts: Option<&Parts>,
        threads: usize,
    ) -> Result<()> {
        check(mesh, window)?;
        let window = &self.nearby(window);
        if !self.trace(scratch, interval, window, threads) {
            return Err(not_finite(mesh, window));
        }
        let Interval { generation, motion, labels, clusters, bounds, seams, fronts, .. } = interval;
        *generation = window.frame / self.settings.hold;
        let traces = Traces { motion, moves: scratch.trace.moves() };
        let task = clusters::Task { mesh, traces, settings: &self.settings, height: self.size[1] };
        scratch.clusters.find(task, parts, Found { labels, clusters, bounds });
        seams.clear();
        match parts {
            _ if self.settings.seam_smoothing == 0 => {}
            Some(parts) => seams.extend(parts.seams().iter().filter(|point| labels[**point as usize] > 0)),
            None => scratch.seams.find(mesh, labels, seams),
        }
        let current = &window.poses[window.current];
        let next = window.poses.get(window.current + 1).unwrap_or(current);
        scratch.fronts.find(mesh, [current, next], self.size, fronts);
        Ok(())
    }

    /// Numbers of the poses that are looked at, of so many: they are enough even where each is held for some frames.
    fn nearby_places(&self, current: usize, count: usize) -> Range<usize> {
        let later = if self.settings.trajectory == Trajectory::Past { 0 } else { MOST_FRAMES };
        current.saturating_sub(MOST_FRAMES)..count.min(current + 2 + later)
    }

    /// The part of a window that is looked at.
    fn nearby<'a>(&self, window: &Window<'a>) -> Window<'a> {
        let places = self.nearby_places(window.current, window.poses.len());
        let between = if self.settings.trajectory == Trajectory::Exact { window.between } else { &[] };
        let current = window.current - places.start;
        Window { frame: window.frame, poses: &window.poses[places], current, between }
    }

    /// The projection of a pose: all are of one picture, that of frame i + 1.
    fn project(&self, window: &Window, pose: &Pose) -> PixelClip {
        let next = window.poses.get(window.current + 1).unwrap_or(&window.poses[window.current]);
        PixelClip::new(pose.view, next.view.jitter, self.size)
    }

    /// Places of a window's poses around frame i that no cut divides from it.
    pub fn uncut(&self, window: &Window) -> Range<usize> {
        let (mut cuts, window) = (Cuts::default(), self.nearby(window));
        self.find_cuts(&mut cuts, &window);
        cuts.around(window.current, window.poses.len())
    }

    fn find_cuts(&self, cuts: &mut Cuts, window: &Window) {
        let jump = f64::from(self.settings.jump) * f64::from(self.size[1]);
        cuts.renew(window.poses, jump, |pose| self.project(window, pose));
    }

    /// Finds the timeline of a window; false if nothing moves.
    fn find_timeline(&self, timeline: &mut Timeline, window: &Window, cuts: &Cuts, corners: Option<&Corners>) -> bool {
        let after = window.current + 1;
        let shot = cuts.around(window.current, window.poses.len());
        if !shot.contains(&after) {
            return false;
        }
        let (earlier, height) = (self.settings.reach().ceil() as usize, f64::from(self.size[1]));
        timeline.renew(window, shot, earlier, height, corners, |pose| self.project(window, pose));
        timeline.ends[0] != timeline.ends[1]
    }

    /// Finds segments and traces; false if a position that is used is not finite.
    fn trace(&self, scratch: &mut Scratch, interval: &mut Interval, window: &Window, threads: usize) -> bool {
        let Scratch { cuts, timeline, trace, .. } = scratch;
        let Interval { motion, segments, pieces, .. } = interval;
        let current = &window.poses[window.current];
        // Of an orthographic view both are the same.
        let is_orthographic = self.project(window, current).is_orthographic;
        let space = if is_orthographic { Space::Screen } else { self.settings.space };
        self.find_cuts(cuts, window);
        segments.clear();
        if self.find_timeline(timeline, window, cuts, Some(&corners(current))) {
            segments.extend(timeline.spans.iter().map(|span| span.segment));
            let Settings { trajectory, reference_time, .. } = self.settings;
            let (reference_time, reach) = (f64::from(reference_time), f64::from(self.settings.reach()));
            let task = trace::Task { window, timeline, space, trajectory, reference_time, reach };
            trace.find(task, threads, motion, pieces)
        } else {
            let pose = window.poses.get(window.current + 1).unwrap_or(current);
            segments.push(Segment { begin: 0.0, end: 1.0 });
            trace.still(pose.positions, &self.project(window, pose), space, motion, pieces)
        }
    }
}

/// Those of a cluster's points, each once, that can be extreme: the convex hull with what is on its sides, and what is so
/// near to it that rounding in f32 can make it extreme, in the order in which one comes by when going around it. A line's
/// from one end to the other.
pub fn outline(points: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let mut found = Vec::new();
    hull::Scratch::default().extremes(points, &mut found);
    found
}

/// The rows of an interval's clusters as they are found from its points, anew: what that costs can be measured.
#[cfg(feature = "cli")]
pub(crate) fn rows_again(mesh: &Mesh, interval: &Interval, height: u32) -> Vec<[f32; 2]> {
    let (mut rows, mut room, mut found) = (rows::Scratch::default(), rows::SHARED, Vec::new());
    for (label, cluster) in (1..).zip(&interval.clusters) {
        let members = interval.labels.iter().copied().zip(0..).filter(|(of, _)| *of == label);
        let members: Vec<(u32, u32)> = members.collect();
        let Interval { motion, labels, .. } = interval;
        let task = rows::Task { mesh, motion, labels, members: &members, ahead: cluster.ahead };
        rows.find(task, f64::from(Settings::scaled(ROW, height)), &mut room, &mut found);
    }
    found
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

#[cfg(test)]
mod tests;
