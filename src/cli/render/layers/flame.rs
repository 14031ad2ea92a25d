//! The layers of the flame effect.

use super::{LayerName, read};
use crate::cli::render::outputs::{Layer, LayerData};
use crate::flame::layout;
use crate::flame::params::{MASK_SIDE, Particle};
use crate::plan::BufferId;

/// Every layer's name, and whether it is an array.
pub(super) const LAYERS: [LayerName; 8] = [
    ("flame.particles", true),
    ("flame.mask", true),
    ("flame.mean", false),
    ("flame.variance", false),
    ("flame.coverage", false),
    ("flame.depth", false),
    ("flame.repetitions", false),
    ("flame", false),
];

/// The buffers that layers are made of, in the order in which [`decode`] takes them.
pub(super) const BUFFERS: [BufferId; 7] = [
    layout::POSITIONS,
    layout::PARTICLES,
    layout::MASK,
    layout::MEAN,
    layout::VARIANCE,
    layout::NEAREST,
    layout::PICTURE,
];

/// Columns of `flame.particles`: x, y, z, temperature, mean count, alpha, r, g, b.
const COLUMNS: u64 = 9;

/// Makes the layers of a picture of `pixels` pixels from so many particles and different masks.
pub(super) fn decode(bytes: [&[u8]; BUFFERS.len()], pixels: usize, particles: usize, variants: u32) -> Vec<Layer> {
    let [positions, prepared, mask, mean, variance, nearest, picture] = bytes;
    let shape = [variants, MASK_SIDE, MASK_SIDE].map(u64::from);
    let texels = shape.iter().product::<u64>() as usize;
    let mean: Vec<[f32; 4]> = read(mean, pixels);
    let variance: Vec<[f32; 4]> = read(variance, pixels);
    let data = [
        LayerData::table(COLUMNS, rows(positions, prepared, particles)),
        LayerData::Array { shape: shape.to_vec(), values: read(mask, texels) },
        LayerData::Rgb(mean.iter().map(colour).collect()),
        LayerData::Rgb(variance.iter().map(colour).collect()),
        LayerData::Value(mean.iter().map(|pixel| pixel[3]).collect()),
        LayerData::Value(read(nearest, pixels)),
        LayerData::Value(variance.iter().map(|pixel| pixel[3]).collect()),
        LayerData::Colour(read(picture, pixels)),
    ];
    LAYERS.into_iter().zip(data).map(|((name, _), data)| Layer { name, data }).collect()
}

fn colour([r, g, b, _]: &[f32; 4]) -> [f32; 3] {
    [*r, *g, *b]
}

/// The particles that are not dropped, in row order. Buffers may be longer than this frame's particles.
fn rows(positions: &[u8], prepared: &[u8], particles: usize) -> Vec<f32> {
    let positions: Vec<[f32; 4]> = read(positions, particles);
    let prepared: Vec<Particle> = read(prepared, particles);
    let kept = positions.iter().zip(&prepared).filter(|(_, particle)| particle.count > 0);
    let row = |([x, y, z, temperature], particle): (&[f32; 4], &Particle)| {
        let [r, g, b, alpha] = particle.colour;
        [*x, *y, *z, *temperature, particle.mean_count, alpha, r, g, b]
    };
    kept.flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::values;
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn dropped_particles_are_left_out_and_pixels_taken_apart() {
        let positions: Vec<[f32; 4]> = (0..4).map(|i| [i as f32, 10.0, 20.0, 1000.0 + i as f32]).collect();
        let particle = |count: u32| Particle {
            view: [7.0; 2],
            mean_count: 6.5,
            colour: [0.5, 0.25, 0.125, 2.5],
            id: 9,
            count,
            ..Particle::zeroed()
        };
        // The last row is one of an earlier frame with more particles.
        let prepared: Vec<Particle> = [3, 0, 1, 5].map(particle).to_vec();
        let mask = vec![0.75_f32; 2 * 64 * 64];
        let mean = [[0.1_f32, 0.2, 0.3, 0.4], [0.0; 4]];
        let variance = [[0.5_f32, 0.6, 0.7, 20.0], [0.0, 0.0, 0.0, 16.0]];
        let nearest = [2.0_f32, f32::INFINITY];
        let picture = [[1.0_f32, 2.0, 3.0, 0.4], [0.0; 4]];
        let bytes = [
            bytemuck::cast_slice(&positions),
            bytemuck::cast_slice(&prepared),
            bytemuck::cast_slice(&mask),
            bytemuck::cast_slice(&mean),
            bytemuck::cast_slice(&variance),
            bytemuck::cast_slice(&nearest),
            bytemuck::cast_slice(&picture),
        ];
        let layers = decode(bytes, 2, 3, 2);
        let rows = [
            [0.0, 10.0, 20.0, 1000.0, 6.5, 2.5, 0.5, 0.25, 0.125],
            [2.0, 10.0, 20.0, 1002.0, 6.5, 2.5, 0.5, 0.25, 0.125],
        ];
        assert_eq!(values(&layers, "flame.particles"), rows.as_flattened());
        assert_eq!(values(&layers, "flame.mean"), [0.1, 0.2, 0.3, 0.0, 0.0, 0.0]);
        assert_eq!(values(&layers, "flame.variance"), [0.5, 0.6, 0.7, 0.0, 0.0, 0.0]);
        assert_eq!(values(&layers, "flame.coverage"), [0.4, 0.0]);
        assert_eq!(values(&layers, "flame.depth"), [2.0, f32::INFINITY]);
        assert_eq!(values(&layers, "flame.repetitions"), [20.0, 16.0]);
        assert_eq!(values(&layers, "flame"), picture.as_flattened());
        let shapes = layers.iter().filter_map(|layer| match &layer.data {
            LayerData::Array { shape, values } => Some((layer.name, shape.clone(), values.len())),
            _ => None,
        });
        let expected = [("flame.particles", vec![2, 9], 18), ("flame.mask", vec![2, 64, 64], 8192)];
        assert_eq!(shapes.collect::<Vec<_>>(), expected);
    }
}
