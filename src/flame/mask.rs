//! The mask of the sprites: a cone times noise (Mabuchi, Fujishiro, Ohno, section 3.2). The device makes its own; what the
//! host must know of it is computed here.

use super::params::{MASK_SIDE, NOISE_CELLS};
use crate::noise::perlin;
use crate::random::{hash, unit};

/// Texels of a mask along a side.
pub const SIDE: usize = MASK_SIDE as usize;

/// Alpha at the texels of every variant.
#[derive(Clone, Debug)]
pub struct Mask {
    pub(super) texels: Vec<f64>,
}

impl Mask {
    /// The masks that belong to a seed.
    pub fn new(seed: u32, variants: u32) -> Mask {
        let texel = |i: usize| {
            let (variant, x, y) = (i / (SIDE * SIDE), i % SIDE, i / SIDE % SIDE);
            let draw = |dimension| hash(seed, variant as u32, 0, dimension);
            let whole = |dimension| f64::from(draw(dimension) >> 24);
            let [s, t] = [x, y].map(|c| (c as f64 + 0.5) / SIDE as f64);
            let (u, v) = (2.0 * s - 1.0, 2.0 * t - 1.0);
            // Off the lattice planes, on which noise is 0 at the corners of cells. A single number, as shaders have it.
            let z = f64::from((draw(2) >> 24) as f32 + (0.25 + 0.5 * unit(draw(3))));
            let cells = f64::from(NOISE_CELLS);
            let bumps = 0.5 + 0.5 * perlin([cells * s + whole(0), cells * t + whole(1), z]);
            ((1.0 - (u * u + v * v).sqrt()).max(0.0) * bumps).clamp(0.0, 1.0)
        };
        Mask { texels: (0..variants as usize * SIDE * SIDE).map(texel).collect() }
    }

    /// The largest alpha of any texel.
    pub fn largest(&self) -> f64 {
        self.texels.iter().copied().fold(0.0, f64::max)
    }
}
