//! Where clusters meet.

use crate::blur::mesh::{Lists, Mesh};

/// Edges from a seam to the farthest point that is smoothed.
const RINGS: usize = 3;
/// A point with more neighbours is not smoothed: sums of so many numbers fit into 32 bits.
pub const MOST_NEIGHBOURS: usize = 1024;

/// Points in clusters that are at most [`RINGS`] edges away from an end of an edge that joins two clusters, ascending. A
/// point in no cluster is passed, but an edge to it is no seam: what stays is pinned, and what is beside it hardly moves.
pub(in crate::blur) fn find(mesh: &Mesh, labels: &[u32]) -> Vec<u32> {
    let neighbours = mesh.neighbours();
    let is_end = |p: &u32| {
        let own = labels[*p as usize];
        own > 0 && neighbours.of(*p as usize).iter().any(|q| labels[*q as usize] > 0 && labels[*q as usize] != own)
    };
    let mut ring: Vec<u32> = (0..mesh.points() as u32).filter(is_end).collect();
    let mut near = vec![false; mesh.points()];
    ring.iter().for_each(|p| near[*p as usize] = true);
    for _ in 0..RINGS {
        let mut next = Vec::new();
        for q in ring.iter().flat_map(|p| neighbours.of(*p as usize)) {
            if !std::mem::replace(&mut near[*q as usize], true) {
                next.push(*q);
            }
        }
        ring = next;
    }
    let smoothed = |p: usize| near[p] && labels[p] > 0 && neighbours.of(p).len() <= MOST_NEIGHBOURS;
    (0..mesh.points()).filter(|p| smoothed(*p)).map(|p| p as u32).collect()
}

/// The most neighbours of one of these points.
pub(in crate::blur) fn most_neighbours(neighbours: &Lists, points: &[u32]) -> u32 {
    points.iter().map(|point| neighbours.of(*point as usize).len() as u32).max().unwrap_or(0)
}
