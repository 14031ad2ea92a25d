//! Division by the direction of motion, and into parts that are connected on screen.

use super::movers::{Joined, Mover, Sorting};
use crate::blur::mesh::Mesh;

/// Side of a cell in pixels at 1080 lines: points in one or in neighbouring cells are connected.
pub(super) const CELL: f32 = 32.0;

/// What movers are divided and connected in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    sorting: Sorting,
    /// The cell of each mover, and its point; sorted.
    keyed: Vec<(Cell, u32)>,
    cells: Vec<Cell>,
    joined: Joined,
    cell_of: Vec<u32>,
}

/// Class, row and column.
type Cell = (u32, i32, i32);

impl Scratch {
    /// Sorts movers along the axis on which their directions vary most, and says where to divide them; `None` if all
    /// directions are equal.
    pub(super) fn split(&mut self, movers: &mut [Mover]) -> Option<usize> {
        let axis = axis(movers);
        let along = |mover: &Mover| axis[0] * mover.direction[0] as f64 + axis[1] * mover.direction[1] as f64;
        self.sorting.otsu(movers, along).map(|(middle, _)| middle)
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

/// Eigenvector of the larger eigenvalue of the directions' covariance, of any length; x where both are equal.
fn axis(movers: &[Mover]) -> [f64; 2] {
    let count = movers.len() as i128;
    let sum = |value: &dyn Fn([i64; 2]) -> i64| movers.iter().map(|m| i128::from(value(m.direction))).sum::<i128>();
    let [x, y] = [sum(&|d| d[0]), sum(&|d| d[1])];
    let xx = (count * sum(&|d| d[0] * d[0]) - x * x) as f64;
    let xy = (count * sum(&|d| d[0] * d[1]) - x * y) as f64;
    let yy = (count * sum(&|d| d[1] * d[1]) - y * y) as f64;
    let half = 0.5 * (xx - yy);
    let root = half.hypot(xy);
    // Of the two forms of the vector, the one that does not cancel.
    match half >= 0.0 {
        true if root == 0.0 => [1.0, 0.0],
        true => [half + root, xy],
        false => [xy, root - half],
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
        assert_eq!(first(&[0.0, 180.0, 5.0, 175.0, -5.0, 185.0]), [1, 3, 5]);
        assert_eq!(first(&[90.0, 95.0, -80.0, -90.0]), [2, 3]);
        assert_eq!(first(&[10.0, 170.0]), [1]);
        assert_eq!(split(&mut movers(&[33.0; 5])), None);
    }

    #[test]
    fn the_axis_is_that_of_the_largest_variance() {
        for angle in [0.0, 20.0, 45.0, 80.0, 90.0, 110.0, 135.0, 179.0] {
            let axis = axis(&movers(&[angle, angle + 180.0, angle + 20.0, angle - 20.0, angle + 160.0, angle + 200.0]));
            let found = axis[1].atan2(axis[0]).to_degrees();
            assert!(((found - angle + 270.0).rem_euclid(180.0) - 90.0).abs() < 1e-3, "{angle} {found}");
        }
        assert_eq!(axis(&movers(&[0.0, 90.0, 180.0, 270.0])), [1.0, 0.0]);
    }
}
