//! Where trajectories do not go on.

use glam::DVec2;

use super::projection::PixelClip;
use super::window::Pose;

/// Where a sequence of poses is cut.
#[derive(Clone, Debug, Default)]
pub(super) struct Cuts {
    /// Poses to which trajectories do not reach from the ones before, ascending.
    pub(super) found: Vec<usize>,
    /// Pixel of the centre of each pose's box, if it is seen.
    centres: Vec<Option<DVec2>>,
}

impl Cuts {
    /// Finds poses that say so, and those to which the centre of the mesh's box moves farther than `jump` pixels, and more
    /// than 4 times as far as in the frames before and after (in one of them at least it must be seen). None of the latter if
    /// `jump` is 0.
    pub(super) fn renew(&mut self, poses: &[Pose], jump: f64, project: impl Fn(&Pose) -> PixelClip) {
        let centre = |pose: &Pose| {
            let (projection, [low, high]) = (project(pose), bounds(pose.positions));
            let clip = projection.clip([0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]));
            (clip.is_finite() && clip.z > projection.near).then(|| projection.pixel_of(clip))
        };
        self.centres.clear();
        self.centres.extend(poses.iter().map(|pose| if jump > 0.0 { centre(pose) } else { None }));
        let moves = |j: usize| Some((self.centres.get(j + 1).copied()?? - self.centres[j]?).length());
        let jumps = |j: usize| {
            let beside = [j.checked_sub(2), Some(j)].map(|k| k.and_then(moves));
            let usual = beside.into_iter().flatten().reduce(f64::max);
            usual.zip(moves(j - 1)).is_some_and(|(usual, own)| own > jump && own > 4.0 * usual)
        };
        self.found.clear();
        self.found.extend((1..poses.len()).filter(|j| poses[*j].cut || jumps(*j)));
    }
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
