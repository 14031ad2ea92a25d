//! Division by the direction of motion, and into parts that are connected on screen.

use std::f64::consts::TAU;

use super::movers::{Joined, Mover, Sorting};
use crate::blur::mesh::Mesh;

/// Side of a cell in pixels at 1080 lines: points in one or in neighbouring cells are connected.
pub(super) const CELL: f32 = 32.0;

/// What movers are divided and connected in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    sorting: Sorting,
    angles: Vec<f64>,
    /// The cell of each mover, and its point; sorted.
    keyed: Vec<(Cell, u32)>,
    cells: Vec<Cell>,
    joined: Joined,
    cell_of: Vec<u32>,
}

/// Class, row and column.
type Cell = (u32, i32, i32);

impl Scratch {
    /// Sorts movers by the angle of their direction, from the far end of the widest gap between two angles on, and says where to divide
    /// them; `None` if all directions are equal. By the angle and not along an axis: there, what goes to either side of it is one.
    pub(super) fn split(&mut self, movers: &mut [Mover]) -> Option<usize> {
        let angle = |mover: &Mover| {
            let [x, y] = mover.direction.map(|c| c as f64);
            y.atan2(x)
        };
        self.angles.clear();
        self.angles.extend(movers.iter().map(angle));
        self.angles.sort_unstable_by(f64::total_cmp);
        let (first, last) = (*self.angles.first()?, *self.angles.last()?);
        let gaps = self.angles.windows(2).map(|pair| (pair[1] - pair[0], pair[1]));
        let (_, start) =
            gaps.fold((first + TAU - last, first), |widest, gap| if gap.0 > widest.0 { gap } else { widest });
        self.sorting.otsu(movers, |mover| (angle(mover) - start).rem_euclid(TAU)).map(|(middle, _)| middle)
    }

    /// Divides classes into parts that are connected: points in one or neighbouring cells of side `cell`, or at the two
    /// ends of an edge. (A coarse mesh has less than a point in each cell that it covers.) Classes become numbers of parts,
    /// from 1.
    pub(super) fn connect(
        &mut self,
        mesh: &Mesh,
        movers: &[Mover],
        motion: &[[f32; 4]],
        cell: f64,
        classes: &mut [u32],
    ) {
        let most = f64::from(1 << 30);
        let place = |c: f32| (f64::from(c) / cell).floor().clamp(-most, most) as i32;
        let key = |mover: &Mover| {
            let [x, y, ..] = motion[mover.point as usize];
            (classes[mover.point as usize], place(y), place(x))
        };
        self.keyed.clear();
        self.keyed.extend(movers.iter().map(|mover| (key(mover), mover.point)));
        self.keyed.sort_unstable();
        self.join_cells(mesh.points());
        let Scratch { joined, cell_of, .. } = self;
        for mover in movers {
            for other in mesh.neighbours().of(mover.point as usize) {
                if *other < mover.point && classes[*other as usize] == classes[mover.point as usize] {
                    joined.join(cell_of[*other as usize], cell_of[mover.point as usize]);
                }
            }
        }
        movers.iter().map(|mover| mover.point as usize).for_each(|p| classes[p] = joined.root(cell_of[p]) + 1);
    }

    /// Joins neighbouring cells of the sorted movers, and finds the cell of each of the mesh's points.
    fn join_cells(&mut self, points: usize) {
        let Scratch { keyed, cells, joined, cell_of, .. } = self;
        cells.clear();
        cell_of.clear();
        cell_of.resize(points, 0);
        for (cell, point) in keyed {
            if cells.last() != Some(cell) {
                cells.push(*cell);
            }
            cell_of[*point as usize] = cells.len() as u32 - 1;
        }
        joined.part(cells.len());
        for (i, (class, y, x)) in cells.iter().enumerate() {
            for neighbour in [(*class, *y, x + 1), (*class, y + 1, x - 1), (*class, y + 1, *x), (*class, y + 1, x + 1)]
            {
                if let Ok(other) = cells.binary_search(&neighbour) {
                    joined.join(i as u32, other as u32);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn movers(degrees: &[f64]) -> Vec<Mover> {
        let mover = |(point, angle): (u32, &f64)| {
            let (y, x) = angle.to_radians().sin_cos();
            Mover { point, direction: [x, y].map(|c| (c * 1_048_576.0).round() as i64), place: [0; 4] }
        };
        (0..).zip(degrees).map(mover).collect()
    }

    fn split(movers: &mut [Mover]) -> Option<usize> {
        Scratch::default().split(movers)
    }

    fn first(degrees: &[f64]) -> Vec<u32> {
        let mut movers = movers(degrees);
        let middle = split(&mut movers).unwrap();
        let mut first: Vec<u32> = movers[..middle].iter().map(|mover| mover.point).collect();
        first.sort_unstable();
        first
    }

    #[test]
    fn the_cut_is_between_the_two_directions() {
        assert_eq!(first(&[0.0, 180.0, 5.0, 175.0, -5.0, 185.0]), [0, 2, 4]);
        assert_eq!(first(&[90.0, 95.0, -80.0, -90.0]), [2, 3]);
        assert_eq!(first(&[10.0, 170.0]), [0]);
        assert_eq!(split(&mut movers(&[33.0; 5])), None);
        assert_eq!(split(&mut []), None);
    }

    /// Bars of a rotor: a cut never goes through one, wherever it stands.
    #[test]
    fn bars_of_a_rotor_stay_whole() {
        for (bars, turned) in [(8, 0.0), (8, 11.0), (7, 3.0), (4, 45.0), (3, 90.0), (5, 180.0)] {
            let angle = |i: u32| f64::from(i % bars) * 360.0 / f64::from(bars) + turned + f64::from(i / bars) - 7.0;
            let all: Vec<f64> = (0..15 * bars).map(angle).collect();
            let mut movers = movers(&all);
            let middle = split(&mut movers).unwrap();
            let of = |movers: &[Mover]| {
                movers.iter().map(|mover| mover.point % bars).collect::<std::collections::BTreeSet<_>>()
            };
            assert!(of(&movers[..middle]).is_disjoint(&of(&movers[middle..])), "{bars} bars, turned by {turned}");
        }
    }
}
