//! The rivals in f64 on the CPU, from their publications.

pub(super) mod moments;
pub(super) mod wavelets;

use glam::DVec3;

use crate::flame::params::MOST_ABSORBANCE;

/// A particle as fog at one pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fog {
    pub(super) depth: f64,
    pub(super) colour: DVec3,
    pub(super) opacity: f64,
}

/// Of fog that is in the order of depth.
pub(super) fn sorted(fogs: &[Fog]) -> DVec3 {
    let step =
        |(mean, left): (DVec3, f64), fog: &Fog| (mean + left * fog.opacity * fog.colour, left * (1.0 - fog.opacity));
    fogs.iter().fold((DVec3::ZERO, 1.0), step).0
}

/// McGuire and Bavoil 2013, equations 6 and 10. `range`: depths that anything can have.
pub(super) fn weighted(fogs: &[Fog], range: [f64; 2]) -> DVec3 {
    let weight = |fog: &Fog| {
        let depth = (fog.depth - range[0]) / (range[1] - range[0]);
        fog.opacity * fog.opacity * (3e3 * (1.0 - depth).powi(3)).max(1e-2)
    };
    let sum: f64 = fogs.iter().map(weight).sum();
    let colour: DVec3 = fogs.iter().map(|fog| weight(fog) * fog.colour).sum();
    let left: f64 = fogs.iter().map(|fog| 1.0 - fog.opacity).product();
    if sum > 0.0 { (1.0 - left) * colour / sum } else { DVec3::ZERO }
}

/// An absorbance at a depth from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    pub(super) depth: f64,
    pub(super) absorbance: f64,
}

/// Fog as layers, on a logarithmic scale of depth.
pub(super) fn layers(fogs: &[Fog], range: [f64; 2]) -> Vec<Layer> {
    let depth = |fog: &Fog| (fog.depth / range[0]).ln() / (range[1] / range[0]).ln();
    let layer = |fog| Layer { depth: depth(fog), absorbance: (-(-fog.opacity).ln_1p()).min(MOST_ABSORBANCE.into()) };
    fogs.iter().map(layer).collect()
}

/// Colours with what is left of them before each layer, normalised to the total opacity (Münstermann et al. 2018).
pub(super) fn normalised(fogs: &[Fog], layers: &[Layer], absorbance_before: impl Fn(usize) -> f64) -> DVec3 {
    let weights: Vec<f64> = layers
        .iter()
        .enumerate()
        .map(|(i, layer)| -(-layer.absorbance).exp_m1() * (-absorbance_before(i)).exp())
        .collect();
    let sum: f64 = weights.iter().sum();
    let colour: DVec3 = fogs.iter().zip(&weights).map(|(fog, weight)| *weight * fog.colour).sum();
    let total: f64 = layers.iter().map(|layer| layer.absorbance).sum();
    if sum > 0.0 { -(-total).exp_m1() * colour / sum } else { DVec3::ZERO }
}

/// Red, green and blue fog of these depths and opacities, for tests of limits; depths are on a logarithmic scale from 0 to 1 over
/// [`RANGE`].
fn coloured(fogs: &[(f64, f64)]) -> Vec<Fog> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let fog = |(i, (depth, opacity)): (usize, &(f64, f64))| Fog {
        depth: RANGE[0] * (RANGE[1] / RANGE[0]).powf(*depth),
        colour: axes[i % axes.len()],
        opacity: *opacity,
    };
    fogs.iter().enumerate().map(fog).collect()
}

/// Of view depth in tests.
const RANGE: [f64; 2] = [2.0, 5.0];
