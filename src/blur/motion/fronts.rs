//! Which side of each triangle is outside, frame by frame: a mirror in the motion turns closed surfaces inside out.

use super::window::Pose;
use crate::blur::mesh::Mesh;
use crate::blur::shells::Solid;
use crate::shaders::blur::constants::{CLOSED, FRONT_BITS, FRONTS_A_WORD, TURNED};
use crate::view::Projection;

/// What fronts are found in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Of one frame.
    solids: Vec<Solid>,
    /// Bits of each shell's triangles.
    bits: Vec<u32>,
}

impl Scratch {
    /// [`super::Interval::fronts`] of frames i and i + 1. A shell that is flat in one of them, or that may hold the eye in one,
    /// is as one that is not closed.
    pub(super) fn find(&mut self, mesh: &Mesh, poses: [&Pose; 2], size: [u32; 2], fronts: &mut Vec<u32>) {
        let Scratch { solids, bits } = self;
        bits.clear();
        for (frame, pose) in poses.into_iter().enumerate() {
            let projection = Projection::of_valid(pose.view, size);
            mesh.find_solids(pose.positions, solids);
            bits.resize(solids.len(), CLOSED);
            for (bits, solid) in bits.iter_mut().zip(&*solids) {
                match solid.is_turned().filter(|_| !solid.may_hold(&projection, size)) {
                    Some(is_turned) if *bits != 0 => *bits |= (TURNED << frame) * u32::from(is_turned),
                    _ => *bits = 0,
                }
            }
        }
        let a_word = FRONTS_A_WORD as usize;
        fronts.clear();
        fronts.resize(mesh.triangles().len().div_ceil(a_word), 0);
        for triangle in 0..mesh.triangles().len() {
            if let Some(shell) = mesh.shells().of(triangle) {
                fronts[triangle / a_word] |= bits[shell] << (FRONT_BITS as usize * (triangle % a_word));
            }
        }
    }
}
