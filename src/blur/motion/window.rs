//! The part of an animation around two frames, and what is found from it.

use bytemuck::{Pod, Zeroable};

use crate::shaders::blur::blocks::{Cluster, Piece};
use crate::shaders::blur::constants::PIECE_SEGMENTS;
use crate::view::View;

/// The mesh in one frame, and what sees it.
#[derive(Clone, Copy, Debug)]
pub struct Pose<'a> {
    /// World position of each point in metres, finite.
    pub positions: &'a [[f32; 3]],
    /// What the frame is seen through. All of a window are perspective, or all orthographic.
    pub view: &'a View,
    /// Whether a new shot begins here: trajectories do not go from the pose before to this one.
    pub cut: bool,
}

/// The part of an animation around the frames i and i + 1, from which output i + 1 is made.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    /// Number i of the earlier frame in the shot.
    pub frame: u32,
    /// Poses of consecutive frames. [`WINDOW`] before frame i and after frame i + 1, as far as the shot has them, are
    /// used; more only where poses are held; with `trajectory = "past"` none after frame i + 1.
    pub poses: &'a [Pose<'a>],
    /// Place of frame i in `poses`. If it is the last one, nothing moves.
    pub current: usize,
    /// With `trajectory = "exact"`: poses at equal steps between frames i and i + 1, without these two. May be empty.
    pub between: &'a [Pose<'a>],
}

impl<'a> Window<'a> {
    /// A pose by its place: those between frames i and i + 1 come after those of the frames.
    pub(super) fn pose(&self, place: usize) -> &'a Pose<'a> {
        self.poses.get(place).unwrap_or_else(|| &self.between[place - self.poses.len()])
    }
}

/// Different poses to each side of the interval that its trajectories depend on: the others would change them by less
/// than 2e-6 pixels.
pub const WINDOW: usize = 12;

/// Frames to each side of an interval in which different poses are looked for, where poses are held.
pub(crate) const MOST_FRAMES: usize = 4 * WINDOW;

/// The most poses of frames that are looked at.
pub(super) const MOST_POSES: usize = 2 * MOST_FRAMES + 2;

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
    /// What bounds the clusters, in pixels. Of those with rows, the rear and the front of each row. Of others their extreme points: k
    /// and l that are found from them have the same bits as those from all of a cluster's points.
    pub bounds: Vec<[f32; 2]>,
    /// Points within 3 edges of a seam, ascending; those in no cluster and those with too many neighbours are not here.
    pub seams: Vec<u32>,
    /// Which side of each triangle is outside: `FRONT_BITS` each, `FRONTS_A_WORD` of them a word. 1: it is of a closed
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

    /// What bounds a cluster.
    pub fn bounds_of(&self, cluster: &Cluster) -> &[[f32; 2]] {
        &self.bounds[cluster.bounds_begin as usize..cluster.bounds_end as usize]
    }
}

/// A frame whose pose is on the device, and what sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameView {
    /// Its number.
    pub frame: u32,
    /// What sees it.
    pub view: View,
}

/// A frame that trajectories go through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The frame.
    pub view: FrameView,
    /// Share of its distance from frame i in each row of each piece: origin, step, moments; segment by segment.
    pub weights: [[f32; 4]; PIECE_SEGMENTS as usize],
}
