//! Where clusters meet.

use crate::blur::mesh::{Lists, Mesh};

/// Edges from a seam to the farthest point that is smoothed.
const RINGS: usize = 3;
/// A point with more neighbours is not smoothed: sums of so many numbers fit into 32 bits.
pub const MOST_NEIGHBOURS: usize = 1024;

/// What seams are found in.
#[derive(Clone, Debug, Default)]
pub(in crate::blur) struct Scratch {
    /// Whether each point is near a seam.
    near: Vec<bool>,
    /// Points near seams, ring by ring.
    rings: Vec<u32>,
}

impl Scratch {
    /// Points in clusters that are at most [`RINGS`] edges away from an end of an edge that joins two clusters, ascending. A
    /// point in no cluster is passed, but an edge to it is no seam: what stays is pinned, and what is beside it hardly moves.
    pub(in crate::blur) fn find(&mut self, mesh: &Mesh, labels: &[u32], seams: &mut Vec<u32>) {
        let (Scratch { near, rings }, neighbours) = (self, mesh.neighbours());
        let is_end = |p: &u32| {
            let own = labels[*p as usize];
            own > 0 && neighbours.of(*p as usize).iter().any(|q| labels[*q as usize] > 0 && labels[*q as usize] != own)
        };
        rings.clear();
        rings.extend((0..mesh.points() as u32).filter(is_end));
        near.clear();
        near.resize(mesh.points(), false);
        rings.iter().for_each(|p| near[*p as usize] = true);
        let mut begin = 0;
        for _ in 0..RINGS {
            let end = rings.len();
            for place in begin..end {
                for q in neighbours.of(rings[place] as usize) {
                    if !std::mem::replace(&mut near[*q as usize], true) {
                        rings.push(*q);
                    }
                }
            }
            begin = end;
        }
        let smoothed = |p: usize| near[p] && labels[p] > 0 && neighbours.of(p).len() <= MOST_NEIGHBOURS;
        seams.clear();
        seams.extend((0..mesh.points()).filter(|p| smoothed(*p)).map(|p| p as u32));
    }
}

/// The most neighbours of one of these points.
pub(in crate::blur) fn most_neighbours(neighbours: &Lists, points: &[u32]) -> u32 {
    points.iter().map(|point| neighbours.of(*point as usize).len() as u32).max().unwrap_or(0)
}
