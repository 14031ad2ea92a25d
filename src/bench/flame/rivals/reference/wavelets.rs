//! Wavelet transparency (Aizenshtein, Smal and McGuire 2022): the absorbance before a depth, a sum of steps, in orthonormal Haar
//! wavelets up to a level, the rank. They hold the mean in each of as many bins as there are coefficients.

use glam::DVec3;

use super::{Fog, Layer, layers, normalised};
use crate::shaders::flame::constants::{WAVELET_BINS, WAVELET_RANK};

/// Bins of depth, and coefficients.
const BINS_OF_DEPTH: usize = WAVELET_BINS as usize;

/// One of the functions: a constant, or a wavelet.
#[derive(Clone, Copy)]
enum Basis {
    Constant,
    /// Number `.1` of the level `.0`.
    Wavelet(u32, usize),
}

impl Basis {
    fn all() -> impl Iterator<Item = Basis> {
        let level = |level| (0..1_usize << level).map(move |number| Basis::Wavelet(level, number));
        std::iter::once(Basis::Constant).chain((0..=WAVELET_RANK).flat_map(level))
    }

    /// Its value and where that is, twice: both halves.
    fn halves(self) -> [(f64, [f64; 2]); 2] {
        match self {
            Basis::Constant => [(1.0, [0.0, 0.5]), (1.0, [0.5, 1.0])],
            Basis::Wavelet(level, number) => {
                let scale = f64::from(1 << level);
                let at = |halves: f64| (number as f64 + 0.5 * halves) / scale;
                [(scale.sqrt(), [at(0.0), at(1.0)]), (-scale.sqrt(), [at(1.0), at(2.0)])]
            }
        }
    }

    fn value(self, x: f64) -> f64 {
        let inside = |(value, [low, high]): (f64, [f64; 2])| if (low..high).contains(&x) { value } else { 0.0 };
        self.halves().into_iter().map(inside).sum()
    }

    /// Inner product with a step at `x`.
    fn behind(self, x: f64) -> f64 {
        self.halves().into_iter().map(|(value, [low, high])| value * (high - x.clamp(low, high))).sum()
    }
}

/// Where a layer is. None is in the last bin, whose mean is therefore the total.
fn place(depth: f64) -> f64 {
    depth * (BINS_OF_DEPTH - 1) as f64 / BINS_OF_DEPTH as f64
}

/// What remains of layers.
pub(in super::super) struct Wavelets(Vec<(Basis, f64)>);

impl Wavelets {
    pub(in super::super) fn new(layers: &[Layer]) -> Wavelets {
        let coefficient = |basis: Basis| -> f64 {
            layers.iter().map(|layer| layer.absorbance * basis.behind(place(layer.depth))).sum()
        };
        Wavelets(Basis::all().map(|basis| (basis, coefficient(basis))).collect())
    }

    /// Mean in a bin; before the first there is nothing.
    fn mean(&self, bin: Option<usize>) -> f64 {
        let x = |bin: usize| (bin as f64 + 0.5) / BINS_OF_DEPTH as f64;
        bin.map_or(0.0, |bin| self.0.iter().map(|(basis, coefficient)| coefficient * basis.value(x(bin))).sum())
    }

    /// Before a depth from 0 to 1: from the mean of the bin before to that of its own.
    pub(in super::super) fn absorbance_before(&self, depth: f64) -> f64 {
        let place = place(depth) * BINS_OF_DEPTH as f64;
        let bin = place as usize;
        let along = place - bin as f64;
        (1.0 - along) * self.mean(bin.checked_sub(1)) + along * self.mean(Some(bin))
    }

    /// Behind all layers.
    fn total(&self) -> f64 {
        self.mean(Some(BINS_OF_DEPTH - 1))
    }
}

/// What blending by wavelets says. Each layer is left out of what it sees.
pub(in super::super) fn blended(fogs: &[Fog], range: [f64; 2]) -> DVec3 {
    let layers = layers(fogs, range);
    normalised(fogs, &layers, |i| {
        let others = [&layers[..i], &layers[i + 1..]].concat();
        Wavelets::new(&others).absorbance_before(layers[i].depth)
    })
}

#[cfg(test)]
mod tests {
    use super::super::{RANGE, coloured, sorted};
    use super::*;
    use crate::random::{hash, unit};

    fn error(fogs: &[Fog]) -> f64 {
        (blended(fogs, RANGE) - sorted(fogs)).abs().max_element()
    }

    #[test]
    fn the_basis_is_orthonormal() {
        let basis: Vec<Basis> = Basis::all().collect();
        assert_eq!(basis.len(), BINS_OF_DEPTH);
        for (i, a) in basis.iter().enumerate() {
            for (j, b) in basis.iter().enumerate() {
                let product = |bin: usize| {
                    let x = (bin as f64 + 0.5) / BINS_OF_DEPTH as f64;
                    a.value(x) * b.value(x) / BINS_OF_DEPTH as f64
                };
                let inner: f64 = (0..BINS_OF_DEPTH).map(product).sum();
                assert!((inner - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}: {inner}");
            }
        }
    }

    #[test]
    fn means_of_bins_and_the_total_are_exact() {
        let draw = |i, dimension| f64::from(unit(hash(5, i, 0, dimension)));
        let layers: Vec<Layer> = (0..40).map(|i| Layer { depth: draw(i, 0), absorbance: 3.0 * draw(i, 1) }).collect();
        let wavelets = Wavelets::new(&layers);
        for bin in 0..BINS_OF_DEPTH {
            let share = |depth: f64| (bin as f64 + 1.0 - place(depth) * BINS_OF_DEPTH as f64).clamp(0.0, 1.0);
            let expected: f64 = layers.iter().map(|layer| layer.absorbance * share(layer.depth)).sum();
            assert!((wavelets.mean(Some(bin)) - expected).abs() < 1e-12, "{bin}");
        }
        let total: f64 = layers.iter().map(|layer| layer.absorbance).sum();
        assert!((wavelets.total() - total).abs() < 1e-12);
    }

    /// Layers where bins begin are exact there, and so is blending of layers between which a bin is whole.
    #[test]
    fn layers_that_bins_tell_apart_are_exact() {
        let edge = |bin: usize| bin as f64 / (BINS_OF_DEPTH - 1) as f64;
        let layers: Vec<Layer> = (0..BINS_OF_DEPTH).map(|bin| Layer { depth: edge(bin), absorbance: 0.3 }).collect();
        let wavelets = Wavelets::new(&layers);
        for (bin, layer) in layers.iter().enumerate() {
            // A rounding may put an edge into the bin before: interpolation is continuous.
            assert!((wavelets.absorbance_before(layer.depth) - 0.3 * bin as f64).abs() < 1e-12, "{bin}");
        }
        assert!(error(&coloured(&[(0.37, 0.8)])) < 1e-12);
        assert!(error(&coloured(&[(0.33, 0.6), (0.33 + 2.0 * edge(1), 0.6)])) < 1e-12);
        assert!(error(&coloured(&[(0.0, 0.6), (0.15, 0.9), (0.6, 0.2), (0.8, 0.5), (1.0, 0.7)])) < 1e-12);
        let close = error(&coloured(&[(0.34, 0.6), (0.35, 0.6)]));
        assert!((0.05..0.3).contains(&close), "two layers in a bin: {close}");
    }

    #[test]
    fn an_opaque_layer_hides_what_is_behind() {
        assert!(error(&coloured(&[(0.3, 1.0)])) < 1e-4);
        assert!(error(&coloured(&[(0.3, 1.0), (0.6, 1.0)])) < 1e-4);
    }
}
