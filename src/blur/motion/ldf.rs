//! Binary division by a linear discriminant function on position and velocity.
//!
//! The paper names it (section 2.4, after Hanaizumi, Chino, Fujimura 1995) without its rules. This reading maximises the
//! share of the variance that is between the two parts, by turns over the axis and over the cut: it never falls, so that
//! it ends.

use super::movers::{Mover, Sorting};

/// The most rounds of axis and cut.
const MOST_ROUNDS: usize = 30;
/// Eigenvalues below this share of the largest are 0: the values do not vary that way.
const RANK: f64 = 1e-10;

type Vector = [f64; 4];
type Matrix = [[f64; 4]; 4];

/// What movers are divided in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    sorting: Sorting,
    trial: Vec<Mover>,
    /// Points of two parts.
    points: [Vec<u32>; 2],
}

impl Scratch {
    /// Sorts movers along the best axis that is found, and says where to divide them; `None` if all are equal.
    pub(super) fn split(&mut self, movers: &mut [Mover]) -> Option<usize> {
        let scatter = Scatter::new(movers);
        let raw = (0..4).filter_map(|axis| {
            let mut unit = [0.0; 4];
            unit[axis] = 1.0;
            self.sorting.otsu(movers, |mover| scatter.along(&unit, mover)).map(|(_, share)| (unit, share))
        });
        let (axis, mut best) = raw.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        let mut middle = self.sorting.otsu(movers, |mover| scatter.along(&axis, mover))?.0;
        for _ in 0..MOST_ROUNDS {
            let next = scatter.discriminant(&movers[..middle], &movers[middle..]);
            self.trial.clear();
            self.trial.extend_from_slice(movers);
            match self.sorting.otsu(&mut self.trial, |mover| scatter.along(&next, mover)) {
                Some((place, share)) if share > best => {
                    let stands = place == middle && self.has_first(&movers[..middle]);
                    movers.copy_from_slice(&self.trial);
                    (best, middle) = (share, place);
                    if stands {
                        break;
                    }
                }
                _ => break,
            }
        }
        Some(middle)
    }

    /// Whether the first movers of the trial are these, in any order.
    fn has_first(&mut self, movers: &[Mover]) -> bool {
        for (points, part) in self.points.iter_mut().zip([movers, &self.trial[..movers.len()]]) {
            points.clear();
            points.extend(part.iter().map(|mover| mover.point));
            points.sort_unstable();
        }
        self.points[0] == self.points[1]
    }
}

/// How values vary together.
struct Scatter {
    /// A whole number near the mean: what is measured from it is exact.
    centre: [i64; 4],
    /// One over the deviation of each value, 0 where it does not vary.
    scale: Vector,
    /// Pseudo-inverse of the correlations.
    inverse: Matrix,
}

impl Scatter {
    fn new(movers: &[Mover]) -> Scatter {
        let count = movers.len() as i128;
        let sums = sums(movers);
        let centre = sums.map(|sum| (sum / count) as i64);
        // From the centre on numbers are small; the products of 2^41 units stay within 128 bits for any number of them.
        let from = |m: &Mover, a: usize| i128::from(m.place[a] - centre[a]);
        let rest = [0, 1, 2, 3].map(|a| movers.iter().map(|m| from(m, a)).sum::<i128>());
        let scatter: Matrix = std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                let products: i128 = movers.iter().map(|m| from(m, a) * from(m, b)).sum();
                products as f64 - rest[a] as f64 * rest[b] as f64 / count as f64
            })
        });
        let scale = [0, 1, 2, 3].map(|a| if scatter[a][a] > 0.0 { scatter[a][a].sqrt().recip() } else { 0.0 });
        let correlation = std::array::from_fn(|a| std::array::from_fn(|b| scatter[a][b] * scale[a] * scale[b]));
        Scatter { centre, scale, inverse: pseudo_inverse(correlation) }
    }

    fn along(&self, axis: &Vector, mover: &Mover) -> f64 {
        (0..4).map(|a| axis[a] * (mover.place[a] - self.centre[a]) as f64).sum()
    }

    /// The axis that separates two parts best: the inverse scatter times the difference of their means.
    fn discriminant(&self, first: &[Mover], second: &[Mover]) -> Vector {
        let mean = |part: &[Mover]| sums(part).map(|sum| sum as f64 / part.len() as f64);
        let (a, b) = (mean(first), mean(second));
        let apart: Vector = std::array::from_fn(|i| (b[i] - a[i]) * self.scale[i]);
        std::array::from_fn(|i| self.scale[i] * (0..4).map(|j| self.inverse[i][j] * apart[j]).sum::<f64>())
    }
}

fn sums(movers: &[Mover]) -> [i128; 4] {
    [0, 1, 2, 3].map(|a| movers.iter().map(|mover| i128::from(mover.place[a])).sum())
}

/// Inverse of a symmetric matrix on the space in which it is not 0, by Jacobi's rotations.
fn pseudo_inverse(mut matrix: Matrix) -> Matrix {
    let mut vectors: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    for _ in 0..16 {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            rotate(&mut matrix, &mut vectors, p, q);
        }
    }
    let largest = (0..4).map(|i| matrix[i][i]).fold(0.0, f64::max);
    let inverse = [0, 1, 2, 3].map(|i| if matrix[i][i] > RANK * largest { matrix[i][i].recip() } else { 0.0 });
    std::array::from_fn(|a| std::array::from_fn(|b| (0..4).map(|i| vectors[a][i] * inverse[i] * vectors[b][i]).sum()))
}

/// Makes the element (p, q) 0.
fn rotate(matrix: &mut Matrix, vectors: &mut Matrix, p: usize, q: usize) {
    if matrix[p][q] == 0.0 {
        return;
    }
    let half = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
    let tangent = half.signum() / (half.abs() + half.hypot(1.0));
    let cosine = tangent.hypot(1.0).recip();
    let sine = tangent * cosine;
    for row in matrix.iter_mut().chain(vectors.iter_mut()) {
        (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
    }
    let (a, b) = (matrix[p], matrix[q]);
    for i in 0..4 {
        (matrix[p][i], matrix[q][i]) = (cosine * a[i] - sine * b[i], sine * a[i] + cosine * b[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::hash;

    fn mover(point: u32, place: [i64; 4]) -> Mover {
        Mover { point, direction: [1, 0], place }
    }

    fn split(movers: &mut [Mover]) -> Option<usize> {
        Scratch::default().split(movers)
    }

    #[test]
    fn the_pseudo_inverse_undoes_what_has_rank() {
        let full = [[4.0, 1.0, 0.5, 0.0], [1.0, 3.0, 0.2, 0.1], [0.5, 0.2, 2.0, 0.3], [0.0, 0.1, 0.3, 1.0]];
        let spin = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, -1.0, 0.0], [0.0, -1.0, 1.0, 0.0], [1.0, 0.0, 0.0, 1.0]];
        for matrix in [full, spin, [[0.0; 4]; 4]] {
            let inverse = pseudo_inverse(matrix);
            let product = |a: &Matrix, b: &Matrix| -> Matrix {
                std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
            };
            let again = product(&product(&matrix, &inverse), &matrix);
            for (a, b) in again.iter().flatten().zip(matrix.iter().flatten()) {
                assert!((a - b).abs() < 1e-12, "{again:?} {matrix:?}");
            }
        }
    }

    #[test]
    fn the_discriminant_finds_what_no_single_value_shows() {
        // Two thin clouds beside each other, along the diagonal of x and the horizontal velocity.
        let point = |i: u32| {
            let t = i64::from(hash(1, i, 0, 0) >> 14);
            mover(i, [t, 0, t + if i < 300 { 125_000 } else { -125_000 }, 0])
        };
        let mut movers: Vec<Mover> = (0..600).map(point).collect();
        assert_eq!(split(&mut movers), Some(300));
        let below = movers[0].point < 300;
        assert!(movers[..300].iter().all(|mover| (mover.point < 300) == below));
    }

    #[test]
    fn equal_points_are_not_split() {
        assert_eq!(split(&mut [mover(0, [5, 6, 7, 8]); 9]), None);
        assert_eq!(split(&mut [mover(0, [5, 6, 7, 8])]), None);
        assert_eq!(split(&mut [mover(0, [5, 6, 7, 8]), mover(1, [5, 6, 7, 9])]), Some(1));
    }
}
