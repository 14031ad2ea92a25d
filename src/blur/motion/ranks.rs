//! The order of clusters, which depends on nothing but what is in them.

use super::trace::Traces;
use crate::blur::mesh::Mesh;
use crate::random::pcg;

/// What classes are ordered by: size, and a fingerprint for those of one size.
pub(super) type Rank = (u32, u64);

/// What classes are numbered in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    ranks: Vec<Rank>,
    objects: Vec<u32>,
    order: Vec<u32>,
    label_of: Vec<u32>,
}

impl Scratch {
    /// Numbers classes from 1 by their size, so that numbers depend on nothing else (but fingerprints, for equal sizes).
    pub(super) fn number(&mut self, mesh: &Mesh, traces: Traces, classes: &mut [u32]) {
        let Scratch { ranks, objects, order, label_of } = self;
        find(traces, classes, ranks);
        objects.clear();
        objects.resize(ranks.len(), 0);
        classes.iter().zip(mesh.point_objects()).for_each(|(class, object)| objects[*class as usize] = *object);
        order.clear();
        order.extend((1..ranks.len() as u32).filter(|class| ranks[*class as usize].0 > 0));
        order.sort_unstable_by_key(|class| {
            let (size, fingerprint) = ranks[*class as usize];
            (size, objects[*class as usize], fingerprint, *class)
        });
        label_of.clear();
        label_of.resize(ranks.len(), 0);
        order.iter().zip(1..).for_each(|(class, label)| label_of[*class as usize] = label);
        classes.iter_mut().for_each(|class| *class = label_of[*class as usize]);
    }
}

/// The rank of each class, in the place of what is in `ranks`.
pub(super) fn find(traces: Traces, classes: &[u32], ranks: &mut Vec<Rank>) {
    let count = classes.iter().max().map_or(0, |last| *last as usize);
    ranks.clear();
    ranks.resize(count + 1, (0, 0));
    for (point, class) in classes.iter().enumerate().filter(|(_, class)| **class > 0) {
        let rank = &mut ranks[*class as usize];
        *rank = (rank.0 + 1, rank.1.wrapping_add(fingerprint(&traces.motion[point])));
    }
}

/// A number for a set of points that depends on where they are and how they move, and not on their order.
fn fingerprint(motion: &[f32; 4]) -> u64 {
    let [a, b] = [0, 1].map(|seed| motion.iter().fold(seed, |h, c| pcg(h ^ c.to_bits())));
    u64::from(a) << 32 | u64::from(b)
}
