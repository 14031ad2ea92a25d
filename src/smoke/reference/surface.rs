//! Radius of a particle up to the surface: where the density between voxel centres is the threshold.

use super::grid::Grid;
use crate::smoke::settings::Radius;

/// A box is searched no further when its diagonal is this share of the smallest side of a voxel: what [`radius`] gives is
/// too small by at most that.
pub const FINEST: f64 = 0.004;

/// What is beyond counts as that much.
const LARGEST: f32 = 1e30;

/// Density less the threshold at the centre of a voxel, as f32 has it, between -1e30 and 1e30. Outside of the volume and
/// where it is no number, the density is 0, or the threshold where that is lower.
pub fn excess(grid: &Grid, threshold: f32, voxel: [i64; 3]) -> f64 {
    let empty = threshold.min(0.0);
    let density = grid.density_of(voxel).filter(|density| !density.is_nan()).unwrap_or(empty);
    (density - threshold).clamp(-LARGEST, LARGEST).into()
}

/// The cell between eight voxel centres, and where in it `p` is, in sides from its low corner.
struct Cell {
    /// Low first along x, then y, then z.
    corners: [f64; 8],
    at: [f64; 3],
    sides: [f64; 3],
}

impl Cell {
    /// Of the cell whose low corner is the centre of voxel `low`.
    fn new(grid: &Grid, threshold: f32, low: [i64; 3], p: [f32; 3]) -> Cell {
        let voxel = |corner: usize| [0, 1, 2].map(|a| low[a] + (corner >> a & 1) as i64);
        Cell {
            corners: std::array::from_fn(|corner| excess(grid, threshold, voxel(corner))),
            at: std::array::from_fn(|a| offset(grid, a, p[a]) - low[a] as f64),
            sides: grid.voxel_size.map(f64::from),
        }
    }

    /// Trilinear.
    fn excess(&self, t: [f64; 3]) -> f64 {
        let weight = |corner: usize, a: usize| if corner >> a & 1 == 1 { t[a] } else { 1.0 - t[a] };
        let share = |corner: usize| (0..3).map(|a| weight(corner, a)).product::<f64>();
        // What has no share does not count, however large it is.
        (0..8).map(|corner| (share(corner), self.corners[corner])).filter(|(s, _)| *s > 0.0).map(|(s, e)| s * e).sum()
    }

    /// Whether a box in it holds a place that is not above the threshold: the least is at a corner.
    fn holds(&self, low: [f64; 3], high: [f64; 3]) -> bool {
        let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { high[a] } else { low[a] });
        (0..8).any(|i| self.excess(corner(i)) <= 0.0)
    }

    /// Distance to a box in it.
    fn to_box(&self, low: [f64; 3], high: [f64; 3], kind: Radius) -> f64 {
        norm(kind, [0, 1, 2].map(|a| (low[a] - self.at[a]).max(self.at[a] - high[a]).max(0.0) * self.sides[a]))
    }

    /// Distance to the nearest place in it that is not above the threshold, if it is below `nearest`.
    fn nearest(&self, kind: Radius, nearest: f64) -> f64 {
        match kind {
            Radius::Box => self.growing_box(nearest),
            Radius::Ball => self.halved([0.0; 3], [1.0; 3], nearest),
        }
    }

    /// What a box around the particle has of the cell is a box: it grows until it holds such a place.
    fn growing_box(&self, nearest: f64) -> f64 {
        let holds = |half: f64| {
            let reach = [0, 1, 2].map(|a| half / self.sides[a]);
            let low = [0, 1, 2].map(|a| (self.at[a] - reach[a]).clamp(0.0, 1.0));
            let high = [0, 1, 2].map(|a| (self.at[a] + reach[a]).clamp(0.0, 1.0));
            self.holds(low, high)
        };
        let farthest =
            norm(Radius::Box, [0, 1, 2].map(|a| self.at[a].abs().max((self.at[a] - 1.0).abs()) * self.sides[a]));
        let (mut short, mut long) = (self.to_box([0.0; 3], [1.0; 3], Radius::Box), nearest.min(farthest));
        if !holds(long) {
            return nearest;
        }
        for _ in 0..50 {
            let half = 0.5 * (short + long);
            *(if holds(half) { &mut long } else { &mut short }) = half;
        }
        long
    }

    /// Halves a box along its longest side, the nearer half first, until it is small.
    fn halved(&self, low: [f64; 3], high: [f64; 3], nearest: f64) -> f64 {
        let reach = self.to_box(low, high, Radius::Ball);
        if reach >= nearest || !self.holds(low, high) {
            return nearest;
        }
        let lengths = [0, 1, 2].map(|a| (high[a] - low[a]) * self.sides[a]);
        let smallest = self.sides.iter().copied().fold(f64::INFINITY, f64::min);
        if norm(Radius::Ball, lengths) <= FINEST * smallest {
            return reach;
        }
        let longest = (0..3).max_by(|a, b| lengths[*a].total_cmp(&lengths[*b])).unwrap_or(0);
        let middle = 0.5 * (low[longest] + high[longest]);
        let (mut lower, mut upper) = (high, low);
        lower[longest] = middle;
        upper[longest] = middle;
        let halves = [(low, lower), (upper, high)];
        let order = if self.at[longest] < middle { [0, 1] } else { [1, 0] };
        order.into_iter().fold(nearest, |nearest, half| self.halved(halves[half].0, halves[half].1, nearest))
    }
}

fn norm(kind: Radius, d: [f64; 3]) -> f64 {
    match kind {
        Radius::Box => d[0].max(d[1]).max(d[2]),
        Radius::Ball => (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt(),
    }
}

/// `p` along an axis, in voxels from the centre of voxel 0.
fn offset(grid: &Grid, axis: usize, p: f32) -> f64 {
    (f64::from(p) - f64::from(grid.origin[axis])) / f64::from(grid.voxel_size[axis]) - 0.5
}

/// Radius in metres of the sphere of a particle at `p`, before `scale` and fade: the distance to the nearest place where the
/// density is not above the threshold, in the chessboard norm (`Box`) or the Euclidean one (`Ball`); 0 at such a place.
/// Between the centres of voxels the density is trilinear, those around the volume included; beyond them there is none.
///
/// Brute force: every cell that may be nearer is searched. One that is all above the threshold holds no such place.
pub fn radius(grid: &Grid, threshold: f32, p: [f32; 3], kind: Radius) -> f64 {
    let counts = grid.dimensions.map(i64::from);
    let own = [0, 1, 2].map(|a| offset(grid, a, p[a]).floor() as i64);
    if !(0..3).all(|a| p[a].is_finite() && (-1..counts[a]).contains(&own[a])) {
        return 0.0;
    }
    let cell = Cell::new(grid, threshold, own, p);
    if cell.excess(cell.at) <= 0.0 {
        return 0.0;
    }
    let mut nearest = cell.nearest(kind, f64::MAX);
    for z in -1..counts[2] {
        for y in -1..counts[1] {
            let row = Cell { corners: [0.0; 8], ..cell_at(grid, [own[0], y, z], p) };
            if row.to_box([-1e9, 0.0, 0.0], [1e9, 1.0, 1.0], kind) >= nearest {
                continue;
            }
            for x in -1..counts[0] {
                if cell_at(grid, [x, y, z], p).to_box([0.0; 3], [1.0; 3], kind) < nearest {
                    nearest = Cell::new(grid, threshold, [x, y, z], p).nearest(kind, nearest);
                }
            }
        }
    }
    nearest
}

/// Where a cell is, without its corners.
fn cell_at(grid: &Grid, low: [i64; 3], p: [f32; 3]) -> Cell {
    let at = std::array::from_fn(|a| offset(grid, a, p[a]) - low[a] as f64);
    Cell { corners: [0.0; 8], at, sides: grid.voxel_size.map(f64::from) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(dimensions: [u32; 3], density: &[f32]) -> Grid<'_> {
        Grid { dimensions, voxel_size: [1.0; 3], origin: [0.0; 3], density, velocity: None }
    }

    #[test]
    fn one_voxel_has_its_surface_between_its_centre_and_the_ones_around() {
        // From 2 at the centre to 0 a metre on: 0.5 is met at 3/4, along an axis and along the box's corner earlier.
        let one = grid([1; 3], &[2.0]);
        assert!((radius(&one, 0.5, [0.5; 3], Radius::Ball) - radius_on_a_diagonal()).abs() < FINEST);
        // On the diagonal 2 (1 - t)^3 = 1/2.
        let corner = 1.0 - 0.25_f64.cbrt();
        assert!((radius(&one, 0.5, [0.5; 3], Radius::Box) - corner).abs() < 1e-12);
        assert_eq!(radius(&one, 0.5, [1.3, 0.5, 0.5], Radius::Box), 0.0);
        assert_eq!(radius(&one, 0.5, [7.0, 0.5, 0.5], Radius::Ball), 0.0);
    }

    /// The least of sqrt(3) t on 2 (1 - t)^3 = 1/2, t on 2 (1 - t) = 1/2 and sqrt(2) t on 2 (1 - t)^2 = 1/2.
    fn radius_on_a_diagonal() -> f64 {
        let diagonal = 3.0_f64.sqrt() * (1.0 - 0.25_f64.cbrt());
        diagonal.min(0.75).min(2.0_f64.sqrt() * 0.5)
    }

    #[test]
    fn a_slope_has_its_surface_where_it_meets_the_threshold() {
        // 5 at x = 0.5, less by 1 each metre: 0.25 at x = 5.25; far from the other faces.
        let density: Vec<f32> = (0..9 * 40 * 40).map(|i| 5.0 - (i % 9) as f32).collect();
        let slope = grid([9, 40, 40], &density);
        for kind in [Radius::Box, Radius::Ball] {
            for x in [2.6_f32, 3.0, 4.1, 5.2] {
                let found = radius(&slope, 0.25, [x, 20.3, 19.8], kind);
                assert!((found - (5.25 - f64::from(x))).abs() <= FINEST, "{kind:?} at {x}: {found}");
            }
            assert_eq!(radius(&slope, 0.25, [5.26, 20.3, 19.8], kind), 0.0);
        }
    }

    #[test]
    fn what_is_no_number_or_outside_is_empty_whatever_the_threshold() {
        let values = grid([3, 1, 1], &[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
        for threshold in [-2.0, 0.0, 0.5] {
            let at = |x| excess(&values, threshold, [x, 0, 0]);
            assert!(at(0) <= 0.0 && at(-1) <= 0.0 && at(3) <= 0.0, "{threshold}");
            assert_eq!((at(1), at(2)), (f64::from(LARGEST), f64::from(-LARGEST)));
        }
    }
}
