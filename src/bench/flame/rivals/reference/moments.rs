//! Moment-based order-independent transparency (Münstermann, Krumpen, Klein and Peters 2018): absorbance over depth is known by
//! its power moments alone.

use glam::DVec3;

use super::{Fog, Layer, layers, normalised};
use crate::flame::params::OVERESTIMATION;

/// The paper's in single precision, of 4 and of 6 moments: how much of moments is replaced, and by which. Odd ones are 0.
const BIASES: [(f64, &[f64]); 2] = [(5e-7, &[0.375, 0.375]), (5e-6, &[0.48, 0.451, 0.45])];

/// Coefficients, the constant first.
type Polynomial = Vec<f64>;

/// What remains of layers.
pub(in super::super) struct Moments {
    total: f64,
    /// Orthogonal polynomials of the normalised absorbance over depths from -1 to 1, and the squares of their norms.
    orthogonal: Vec<(Polynomial, f64)>,
}

impl Moments {
    /// 4 or 6 of them.
    pub(in super::super) fn new(layers: &[Layer], count: usize) -> Moments {
        let (bias, towards) = BIASES[count / 2 - 2];
        let total: f64 = layers.iter().map(|layer| layer.absorbance).sum();
        let moment = |k: i32| {
            let sum: f64 = layers.iter().map(|layer| layer.absorbance * (2.0 * layer.depth - 1.0).powi(k)).sum();
            let limit = if k == 0 { 1.0 } else { f64::from(1 - k % 2) * towards[(k as usize - 1) / 2] };
            (1.0 - bias) * sum / total + bias * limit
        };
        let moments: Vec<f64> = (0..=count as i32).map(moment).collect();
        Moments { total, orthogonal: orthogonal(&moments) }
    }

    /// K(z, x) as a polynomial of x, in Christoffel's and Darboux's formula.
    fn kernel(&self, z: f64) -> Polynomial {
        let mut sum = vec![0.0; self.orthogonal.len()];
        for (polynomial, norm) in &self.orthogonal {
            let scale = value(polynomial, z) / norm;
            sum.iter_mut().zip(polynomial).for_each(|(sum, c)| *sum += scale * c);
        }
        sum
    }

    /// The canonical representation: points, `z` the first of them, and weights that have the moments.
    fn representation(&self, z: f64) -> Vec<(f64, f64)> {
        let points = std::iter::once(z).chain(roots(&self.kernel(z)));
        points.map(|x| (x, value(&self.kernel(x), x).recip())).collect()
    }

    /// Before a depth from 0 to 1.
    pub(in super::super) fn absorbance_before(&self, depth: f64) -> f64 {
        let z = 2.0 * depth - 1.0;
        let points = self.representation(z);
        let before: f64 = points[1..].iter().filter(|(x, _)| *x < z).map(|(_, weight)| weight).sum();
        self.total * (f64::from(OVERESTIMATION) * points[0].1 + before)
    }
}

/// What blending by 4 or 6 moments says.
pub(in super::super) fn blended(fogs: &[Fog], range: [f64; 2], count: usize) -> DVec3 {
    let layers = layers(fogs, range);
    let moments = Moments::new(&layers, count);
    normalised(fogs, &layers, |i| moments.absorbance_before(layers[i].depth))
}

/// Gram's and Schmidt's method on 1, x, x^2...
fn orthogonal(moments: &[f64]) -> Vec<(Polynomial, f64)> {
    let inner = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().enumerate().flat_map(|(i, a)| b.iter().enumerate().map(move |(j, b)| a * b * moments[i + j])).sum()
    };
    let mut found: Vec<(Polynomial, f64)> = Vec::new();
    for degree in 0..=moments.len() / 2 {
        let mut next = vec![0.0; degree + 1];
        next[degree] = 1.0;
        for (polynomial, norm) in &found {
            let scale = inner(&next, polynomial) / norm;
            next.iter_mut().zip(polynomial).for_each(|(c, other)| *c -= scale * other);
        }
        let norm = inner(&next, &next);
        found.push((next, norm));
    }
    found
}

fn value(polynomial: &[f64], x: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Roots of a polynomial that has no others than real ones: those of its derivative lie between them.
fn roots(polynomial: &[f64]) -> Vec<f64> {
    let degree = polynomial.len() - 1;
    if degree == 0 {
        return Vec::new();
    }
    let derivative: Polynomial = polynomial.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
    let most = polynomial.iter().map(|c| (c / polynomial[degree]).abs()).fold(0.0, f64::max);
    let mut ends = vec![-1.0 - most];
    ends.extend(roots(&derivative));
    ends.push(1.0 + most);
    let root = |ends: &[f64]| {
        let (mut low, mut high) = (ends[0], ends[1]);
        let rises = value(polynomial, high) > value(polynomial, low);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if (value(polynomial, middle) < 0.0) == rises {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    ends.windows(2).map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{RANGE, coloured, sorted};
    use super::*;
    use crate::random::{hash, unit};

    fn random_layers(count: u32, seed: u32) -> Vec<Layer> {
        let draw = |i, dimension| f64::from(unit(hash(seed, i, 0, dimension)));
        (0..count).map(|i| Layer { depth: draw(i, 0), absorbance: 3.0 * draw(i, 1) }).collect()
    }

    #[test]
    fn representations_have_the_moments() {
        for count in [4, 6] {
            for seed in 0..50 {
                let layers = random_layers(8, seed);
                let total: f64 = layers.iter().map(|layer| layer.absorbance).sum();
                let points = Moments::new(&layers, count).representation(0.37);
                assert_eq!(points.len(), count / 2 + 1);
                for k in 0..=count as i32 {
                    let moment = |(z, weight): (f64, f64)| weight * z.powi(k);
                    let expected: f64 =
                        layers.iter().map(|layer| moment((2.0 * layer.depth - 1.0, layer.absorbance / total))).sum();
                    let found: f64 = points.iter().copied().map(moment).sum();
                    // The bias.
                    assert!((found - expected).abs() < 1e-5, "{count} moments, {k}: {found} {expected}");
                }
            }
        }
    }

    /// As many layers as half the moments are the only ones that have them: what is before a depth is exact but for the
    /// bias, and at a layer it is what is before that, and a fourth of its own.
    #[test]
    fn few_layers_are_exact() {
        let all = [(0.2, 0.7), (0.45, 1.5), (0.8, 0.4)].map(|(depth, absorbance)| Layer { depth, absorbance });
        for count in [4, 6] {
            for layers in (1..=count / 2).map(|layers| &all[..layers]) {
                let moments = Moments::new(layers, count);
                let close = |depth: f64, expected: f64| {
                    let found = moments.absorbance_before(depth);
                    assert!((found - expected).abs() < 2e-4, "{count} moments at {depth}: {found} {expected}");
                };
                let mut sum = 0.0;
                for (i, layer) in layers.iter().enumerate() {
                    let nearer = if i == 0 { 0.0 } else { layers[i - 1].depth };
                    close(0.5 * (nearer + layer.depth), sum);
                    close(layer.depth, sum + f64::from(OVERESTIMATION) * layer.absorbance);
                    sum += layer.absorbance;
                }
                close(0.95, sum);
            }
        }
    }

    /// Where the depth is a layer's own, one layer more is exact. Normalisation takes out the overestimation if all have the same
    /// opacity; else the weight of each is (1 - opacity)^(1/4) times what it should be.
    #[test]
    fn few_equal_layers_are_blended_exactly() {
        for count in [4, 6] {
            for opacity in [0.1, 0.6, 0.95] {
                let fogs = coloured(&[0.15, 0.5, 0.7, 0.9].map(|depth| (depth, opacity)));
                for fogs in (1..=count / 2 + 1).map(|layers| &fogs[..layers]) {
                    let error = (blended(fogs, RANGE, count) - sorted(fogs)).abs().max_element();
                    assert!(error < 1e-5, "{count} moments of {} layers of {opacity}: {error}", fogs.len());
                }
            }
            let fogs = coloured(&[(0.15, 0.9), (0.7, 0.5)]);
            let own = |opacity: f64| (1.0 - opacity).powf(OVERESTIMATION.into());
            let weights = [0.9 * own(0.9), 0.5 * 0.1 * own(0.5)];
            let expected = 0.95 * DVec3::new(weights[0], weights[1], 0.0) / (weights[0] + weights[1]);
            assert!((blended(&fogs, RANGE, count) - expected).abs().max_element() < 1e-5);
        }
    }

    #[test]
    fn more_layers_are_not_exact() {
        let fogs = coloured(&[0.1, 0.3, 0.6, 0.7, 0.95].map(|depth| (depth, 0.5)));
        for count in [4, 6] {
            let fogs = &fogs[..count / 2 + 2];
            let error = (blended(fogs, RANGE, count) - sorted(fogs)).abs().max_element();
            assert!((5e-3..0.05).contains(&error), "{count} moments: {error}");
        }
    }

    #[test]
    fn an_opaque_layer_hides_what_is_behind() {
        for count in [4, 6] {
            let error = |fogs: &[Fog]| (blended(fogs, RANGE, count) - sorted(fogs)).abs().max_element();
            assert!(error(&coloured(&[(0.3, 1.0)])) < 1e-4);
            assert!(error(&coloured(&[(0.3, 1.0), (0.6, 1.0)])) < 1e-4);
        }
    }
}
