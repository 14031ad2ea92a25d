//! Where the points of a mesh are between two frames, which of them move together, and where clusters meet: all that
//! the device needs of an animation for one output.

use bytemuck::{Pod, Zeroable};

use super::mesh::Mesh;
use super::settings::Settings;
use crate::error::{Error, Result};
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

/// Points that are smeared as one. Its hull is `hull[hull_begin..hull_end]`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Cluster {
    /// The object of all its points.
    pub object: u32,
    /// Where its extreme points begin in [`Interval::hull`].
    pub hull_begin: u32,
    /// Where the convex chain of its extreme points ends, and those begin that are not on it, but so near that rounding
    /// can make them extreme.
    pub chain_end: u32,
    /// Where its extreme points end.
    pub hull_end: u32,
    /// Random numbers N across it, 1 to 4096.
    pub teeth: u32,
    /// Number of its points.
    pub points: u32,
}

/// A piece of the trajectories, from one time to another, in frames after frame i.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Segment {
    /// Its first time.
    pub begin: f32,
    /// Its last time, above `begin`.
    pub end: f32,
}

/// A piece of one point's trajectory: y(u) = y(0) + u D + ((1 - u)^3 - (1 - u)) / 6 M0 + (u^3 - u) / 6 M1, where u is 0
/// to 1 from the segment's begin to its end.
///
/// Components x, y, w; the fourth is 0. In homogeneous space these are pixel clip coordinates: x / w and y / w are
/// pixels, y down, and w is the view depth in metres. In screen space x and y are pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Piece {
    /// y(0). Of the segment that begins at 0: as it is in frame i; of all others: less what it is in frame i.
    pub origin: [f32; 4],
    /// D = y(1) - y(0).
    pub step: [f32; 4],
    /// M0, the second derivative at u = 0.
    pub bend_begin: [f32; 4],
    /// M1, the second derivative at u = 1.
    pub bend_end: [f32; 4],
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
    /// The segment that begins at 0, those after it up to frame i + 1, then those before it, from the latest. There is
    /// more than one with `trajectory = "exact"` and where the smear reaches back farther than frame i.
    pub segments: Vec<Segment>,
    /// Piece of segment s and point p: `pieces[s * points + p]`. Before the earliest segment trajectories are straight.
    pub pieces: Vec<Piece>,
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
        let _ = (mesh, window, threads, &self.settings, self.size);
        Err(Error::HostResource { name: "blur poses", why: "not built yet".into() })
    }
}
