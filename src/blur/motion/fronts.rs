//! Which side of each triangle is outside, frame by frame: a mirror in the motion turns closed surfaces inside out.

use super::window::Pose;
use crate::blur::mesh::Mesh;
use crate::shaders::blur::constants::{CLOSED, FRONT_BITS, FRONTS_A_WORD, TURNED};
use crate::view::Projection;

/// [`super::Interval::fronts`] of frames i and i + 1. A shell that is flat in one of them, or that may hold the eye in one, is
/// as one that is not closed.
pub(super) fn find(mesh: &Mesh, poses: [&Pose; 2], size: [u32; 2]) -> Vec<u32> {
    let frames = poses.map(|pose| (Projection::of_valid(pose.view, size), mesh.solids(pose.positions)));
    let bits = |shell: usize| {
        let mut bits = CLOSED;
        for (frame, (projection, solids)) in frames.iter().enumerate() {
            match solids[shell].is_turned().filter(|_| !solids[shell].may_hold(projection, size)) {
                Some(is_turned) => bits |= (TURNED << frame) * u32::from(is_turned),
                None => return 0,
            }
        }
        bits
    };
    let of_shell: Vec<u32> = (0..frames[0].1.len()).map(bits).collect();
    let a_word = FRONTS_A_WORD as usize;
    let mut fronts = vec![0; mesh.triangles().len().div_ceil(a_word)];
    for triangle in 0..mesh.triangles().len() {
        if let Some(shell) = mesh.shells().of(triangle) {
            fronts[triangle / a_word] |= of_shell[shell] << (FRONT_BITS as usize * (triangle % a_word));
        }
    }
    fronts
}
