//! Parts that are too small to be smeared for themselves.

use super::movers::{Joined, Mover};
use super::ranks::{self, Rank};
use super::trace::Traces;
use crate::blur::mesh::Mesh;

/// A part with fewer than one in so many of its object's moving points is a crumb.
const CRUMB: usize = 200;

/// What crumbs are found in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Moving points of each point's object.
    least: Vec<usize>,
    ranks: Vec<Rank>,
    /// A crumb and its neighbour, for each edge between them.
    borders: Vec<(u32, u32)>,
    joined: Joined,
}

impl Scratch {
    /// Joins each crumb to the neighbour that shares most edges with it, the largest of those that share as many; all at
    /// once, until none is left but those without neighbour. Movers are those of one object after those of another.
    pub(super) fn merge(&mut self, mesh: &Mesh, traces: Traces, movers: &[Mover], classes: &mut [u32]) {
        let object = |mover: &Mover| mesh.point_objects()[mover.point as usize];
        self.least.clear();
        self.least.resize(mesh.points(), 0);
        for members in movers.chunk_by(|a, b| object(a) == object(b)) {
            members.iter().for_each(|mover| self.least[mover.point as usize] = members.len());
        }
        loop {
            ranks::find(traces, classes, &mut self.ranks);
            self.find_borders(mesh, movers, classes);
            if self.borders.is_empty() {
                return;
            }
            self.join();
            classes.iter_mut().for_each(|class| *class = self.joined.root(*class));
        }
    }

    /// Finds the borders of all crumbs, sorted.
    fn find_borders(&mut self, mesh: &Mesh, movers: &[Mover], classes: &[u32]) {
        let Scratch { least, ranks, borders, .. } = self;
        let is_crumb = |point: usize| (ranks[classes[point] as usize].0 as usize) * CRUMB < least[point];
        borders.clear();
        for mover in movers.iter().filter(|mover| is_crumb(mover.point as usize)) {
            let own = classes[mover.point as usize];
            let others = mesh.neighbours().of(mover.point as usize).iter().map(|other| classes[*other as usize]);
            borders.extend(others.filter(|other| *other != 0 && *other != own).map(|other| (own, other)));
        }
        borders.sort_unstable();
    }

    /// Joins each crumb to the best of its neighbours, the first of those that are as good.
    fn join(&mut self) {
        let Scratch { ranks, borders, joined, .. } = self;
        joined.part(ranks.len());
        for borders in borders.chunk_by(|a, b| a.0 == b.0) {
            let neighbours = borders.chunk_by(|a, b| a == b).map(|border| (border.len(), border[0].1));
            let is_better =
                |a: &(usize, u32), b: &(usize, u32)| (a.0, ranks[a.1 as usize]) < (b.0, ranks[b.1 as usize]);
            if let Some((_, best)) = neighbours.reduce(|a, b| if is_better(&a, &b) { b } else { a }) {
                joined.join(borders[0].0, best);
            }
        }
    }
}
