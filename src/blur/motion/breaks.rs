//! Where trajectories do not go on, or not smoothly.

use std::ops::Range;

use glam::{DMat4, DVec2};

use super::projection::PixelClip;
use super::window::{Pose, Window};

/// How many times farther than beside it something moves in a cut, or in a snap.
const SUDDEN: f64 = 4.0;
/// The least turn of a camera that is a cut, in radians: 20 degrees.
const CUT_TURN: f64 = 0.35;
/// Frames to each side of one in which something moves that are looked at for how far it moves usually: poses may be held.
const NEARBY: usize = 4;
/// The least move of a snap, in picture heights.
const SNAP: f64 = 0.02;
/// A snap is one of at least this share of the points: 1 of so many.
const SNAP_PARTS: usize = 64;

/// Corners of the mesh's box in a frame.
pub(super) type Corners = [[f32; 3]; 8];

/// Where a sequence of poses is cut.
#[derive(Clone, Debug, Default)]
pub(super) struct Cuts {
    /// Poses to which trajectories do not reach from the ones before, ascending.
    found: Vec<usize>,
    /// Pixel of the centre of each pose's box, if it is seen.
    centres: Vec<Option<DVec2>>,
}

/// From one pose to another, and the moves before and after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) own: [usize; 2],
    pub(super) beside: [Option<[usize; 2]>; 2],
}

impl Cuts {
    /// There are none.
    pub(super) fn clear(&mut self) {
        self.found.clear();
    }

    /// Finds poses that say so, and those to which the centre of the mesh's box moves farther than `jump` pixels or the camera
    /// turns far, and either more than 4 times as far as in the frames before and after (in one of them at least it must be
    /// seen). None of the latter if `jump` is 0.
    pub(super) fn renew(&mut self, poses: &[Pose], jump: f64, project: impl Fn(&Pose) -> PixelClip) {
        let is_sought = jump > 0.0;
        let centre = |pose: &Pose| {
            let (projection, [low, high]) = (project(pose), bounds(pose.positions));
            let clip = projection.clip([0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]));
            (clip.is_finite() && clip.z > projection.near).then(|| projection.pixel_of(clip))
        };
        self.centres.clear();
        self.centres.extend(poses.iter().filter(|_| is_sought).map(centre));
        let moves = |j: usize| Some((self.centres.get(j + 1).copied()?? - self.centres[j]?).length());
        let turns = |j: usize| Some(turn([poses.get(j)?, poses.get(j + 1)?].map(|pose| pose.view.world_to_view)));
        self.found.clear();
        let is_cut = |j: usize| is_sudden(moves, j - 1, jump) || is_sudden(turns, j - 1, CUT_TURN);
        self.found.extend((1..poses.len()).filter(|j| poses[*j].cut || (is_sought && is_cut(*j))));
    }

    /// Of `count` poses, those that no cut divides from one.
    pub(super) fn around(&self, pose: usize, count: usize) -> Range<usize> {
        let begin = self.found.iter().rev().copied().find(|cut| *cut <= pose).unwrap_or(0);
        let end = self.found.iter().copied().find(|cut| *cut > pose).unwrap_or(count);
        begin..end
    }
}

/// Whether what happens from pose j to the next is at least that much, and much more than what happens before and after.
fn is_sudden(moves: impl Fn(usize) -> Option<f64>, j: usize, least: f64) -> bool {
    let Some(own) = moves(j).filter(|own| *own > least) else { return false };
    let usual = |places: &mut dyn Iterator<Item = usize>| places.map_while(&moves).find(|moved| *moved > 0.0);
    let (before, after) = ((j.saturating_sub(NEARBY)..j).rev(), j + 1..=j + NEARBY);
    let is_known = [j.checked_sub(1), Some(j + 1)].into_iter().flatten().any(|k| moves(k).is_some());
    let beside = [usual(&mut before.into_iter()), usual(&mut after.into_iter())];
    is_known && own > SUDDEN * beside.into_iter().flatten().fold(0.0, f64::max)
}

/// By what angle the second of two views is turned from the first, in radians.
fn turn([a, b]: [DMat4; 2]) -> f64 {
    let columns = [a.x_axis.dot(b.x_axis), a.y_axis.dot(b.y_axis), a.z_axis.dot(b.z_axis)];
    (0.5 * (columns.iter().sum::<f64>() - 1.0)).clamp(-1.0, 1.0).acos()
}

/// Corners of the mesh's box.
pub(super) fn corners(pose: &Pose) -> Corners {
    let bounds = bounds(pose.positions);
    std::array::from_fn(|corner| [0, 1, 2].map(|axis| bounds[corner >> axis & 1][axis]))
}

/// Whether a share of the points moves suddenly: far in a single frame, and much less before and after. A spline through
/// that would swing beside it.
pub(super) fn mesh_snaps(window: &Window, step: Step, height: f64, project: impl Fn(&Pose) -> PixelClip) -> bool {
    let [from, to] = step.own.map(|place| window.pose(place));
    let positions = |[a, b]: [usize; 2]| [window.pose(a).positions, window.pose(b).positions];
    let (own, beside) = (positions(step.own), step.beside.map(|beside| beside.map(positions)));
    let squared = |[a, b]: [&[[f32; 3]]; 2], n: usize| {
        let d = [0, 1, 2].map(|c| b[n][c] - a[n][c]);
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    };
    let is_fast = |n: &usize| {
        let usual = beside.iter().flatten().map(|beside| squared(*beside, *n)).fold(0.0, f32::max);
        squared(own, *n) > (SUDDEN * SUDDEN) as f32 * usual
    };
    let projections = [project(from), project(to)];
    let is_far = |n: &usize| moved(projections, own.map(|positions| positions[*n])) > SNAP * height;
    let points = own[0].len();
    let known = beside.iter().any(Option::is_some);
    known && (0..points).filter(is_fast).filter(is_far).count() * SNAP_PARTS >= points
}

/// Whether the camera moves suddenly: what it does with a corner of the mesh's box.
pub(super) fn camera_snaps(
    window: &Window,
    corners: &Corners,
    step: Step,
    height: f64,
    project: impl Fn(&Pose) -> PixelClip,
) -> bool {
    let most = |step: [usize; 2]| {
        let projections = step.map(|place| project(window.pose(place)));
        corners.iter().map(|corner| moved(projections, [*corner; 2])).fold(0.0, f64::max)
    };
    let usual = step.beside.into_iter().flatten().map(most).reduce(f64::max);
    usual.is_some_and(|usual| most(step.own) > (SUDDEN * usual).max(SNAP * height))
}

/// How far a picture moves in pixels; 0 where it is not seen.
fn moved(projections: [PixelClip; 2], positions: [[f32; 3]; 2]) -> f64 {
    let clips = [0, 1].map(|end| projections[end].clip(positions[end]));
    let is_seen = [0, 1].iter().all(|end| clips[*end].z > projections[*end].near);
    let pixel = |end: usize| projections[end].pixel_of(clips[end]);
    if is_seen { (pixel(1) - pixel(0)).length() } else { 0.0 }
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
