//! A frame of smoke as it is measured: from its layers alone.

use glam::DVec3;

use super::motion::Moment;
use super::plane::Plane;
use super::still::{Surface, Tones, steepest};
use super::take::Still;
use crate::view::Projection;

/// The layers of a frame of smoke. Where there is no smoke, tone and line are 0.
pub(super) struct SmokeFrame {
    projection: Projection,
    /// View depth in metres.
    depth: Plane<f32>,
    pub(super) tone: Tones,
    /// Opacity of lines, 0 to 1.
    pub(super) line: Plane<f32>,
    mask: Plane<u32>,
    smooth: Plane<f32>,
    /// Centres of the visible spheres in metres.
    pub(super) spheres: Vec<DVec3>,
}

impl SmokeFrame {
    /// Of a frame `width` pixels wide, with tones of these colours (linear RGB). A pixel has the tone whose colour is
    /// nearest to its own in the layer `smoke.tone`, where borders between tones are antialiased.
    pub(super) fn new(still: &Still, width: usize, colours: &[[f32; 3]]) -> SmokeFrame {
        let depth = Plane::new(width, still.values("smoke.depth").to_vec());
        let is_smoke = |i: usize| depth.values[i].is_finite() && depth.values[i] > 0.0;
        let toned = still.colours("smoke.tone");
        // Tones are flat: most pixels have the colour of the one before.
        let mut before = ([f32::NAN; 4], 0);
        let tones = (0..depth.values.len()).map(|i| {
            let Some(colour) = toned.get(i).filter(|_| is_smoke(i)) else { return 0 };
            if before.0 != *colour {
                before = (*colour, nearest(colours, *colour));
            }
            before.1
        });
        let tone = Plane::new(width, tones.collect());
        let of_smoke = |values: &[f32]| depth.filled(|i| values.get(i).copied().filter(|_| is_smoke(i)).unwrap_or(0.0));
        let spheres = still.values("smoke.spheres").chunks_exact(5);
        SmokeFrame {
            projection: still.projection,
            line: of_smoke(still.values("smoke.outline")),
            mask: of_smoke(still.values("smoke.id")).map(|id| *id as u32),
            smooth: of_smoke(still.values("smoke.smooth")),
            spheres: spheres.map(|row| DVec3::new(row[0].into(), row[1].into(), row[2].into())).collect(),
            tone,
            depth,
        }
    }

    /// Its pixels of smoke.
    pub(super) fn smoke(&self) -> Plane<bool> {
        self.tone.map(|tone| *tone != 0)
    }

    pub(super) fn moment(&self) -> Moment<'_> {
        let SmokeFrame { projection, depth, tone, line, .. } = self;
        Moment { projection, depth, tone, line }
    }

    /// With voxels whose smallest side has so many metres, and a Gaussian of `sigma` pixels.
    pub(super) fn surface(&self, voxel: f64, sigma: f64) -> Surface<'_> {
        let SmokeFrame { tone, depth, mask, smooth, .. } = self;
        Surface { tone, depth, mask, smooth, voxel, steepest: steepest(sigma) }
    }
}

/// Number, from 1, of the colour that is nearest in linear RGB.
fn nearest(colours: &[[f32; 3]], [r, g, b, _]: [f32; 4]) -> u16 {
    let distance = |colour: &[f32; 3]| (colour[0] - r).powi(2) + (colour[1] - g).powi(2) + (colour[2] - b).powi(2);
    let all = colours.iter().enumerate();
    all.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map_or(1, |(i, _)| i as u16 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn antialiased_colours_belong_to_the_nearest_tone() {
        let colours = [[0.3, 0.33, 0.42], [0.62, 0.65, 0.72], [0.95, 0.95, 0.93]];
        let found = [[0.3, 0.33, 0.42, 1.0], [0.5, 0.53, 0.6, 1.0], [0.9, 0.9, 0.9, 1.0], [9.0; 4]];
        assert_eq!(found.map(|colour| nearest(&colours, colour)), [1, 2, 3, 3]);
        assert_eq!(nearest(&[], [0.0; 4]), 1);
    }
}
