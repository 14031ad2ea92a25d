//! The layers of the flame effect.

use super::input::FlameBrought;
use crate::flame::Desc;
use crate::flame::layout::{HEAT_LAYER, MASK, MEAN, NEAREST, PARTICLES, PICTURE, POSITIONS, TONE_LAYER, VARIANCE};
use crate::flame::params::{MASK_SIDE, Particle};
use crate::program::layers::{LayerData, LayerEntry, Made};

pub(super) const LAYERS: &[LayerEntry] = &[
    LayerEntry::array("flame.particles", &[POSITIONS, PARTICLES], particles),
    LayerEntry::array("flame.mask", &[MASK], mask),
    LayerEntry::image("flame.mean", &[MEAN], |made| LayerData::Rgb(made.image(MEAN).iter().map(colour).collect())),
    LayerEntry::image("flame.variance", &[VARIANCE], |made| {
        LayerData::Rgb(made.image(VARIANCE).iter().map(colour).collect())
    }),
    LayerEntry::image("flame.coverage", &[MEAN], |made| LayerData::Value(made.image(MEAN).iter().map(last).collect())),
    LayerEntry::image("flame.depth", &[NEAREST], |made| LayerData::Value(made.image(NEAREST))),
    LayerEntry::image("flame.repetitions", &[VARIANCE], |made| {
        LayerData::Value(made.image(VARIANCE).iter().map(last).collect())
    }),
    LayerEntry::image("flame.heat", &[HEAT_LAYER], |made| {
        LayerData::Value(smoothed(made).map(|[heat, _]| heat).collect())
    }),
    LayerEntry::image("flame.tone", &[TONE_LAYER], |made| LayerData::Colour(made.image(TONE_LAYER))),
    LayerEntry::image("flame.outline", &[HEAT_LAYER], |made| {
        LayerData::Value(smoothed(made).map(|[_, line]| line).collect())
    }),
    LayerEntry::image("flame", &[PICTURE], |made| LayerData::Colour(made.image(PICTURE))),
];

/// Columns of `flame.particles`: x, y, z, temperature, mean count, alpha, r, g, b.
const PARTICLE_COLUMNS: u64 = 9;

fn colour([r, g, b, _]: &[f32; 4]) -> [f32; 3] {
    [*r, *g, *b]
}

fn last([.., last]: &[f32; 4]) -> f32 {
    *last
}

/// Heat, and opacity of the line.
fn smoothed(made: &Made) -> impl Iterator<Item = [f32; 2]> {
    made.image(HEAT_LAYER).into_iter()
}

fn mask(made: &Made) -> LayerData {
    let variants = made.desc::<Desc>().map_or(0, |desc| desc.settings.variants);
    let shape = [variants, MASK_SIDE, MASK_SIDE].map(u64::from);
    let texels = shape.iter().product::<u64>() as usize;
    LayerData::Array { shape: shape.to_vec(), values: made.read(MASK, texels) }
}

/// The particles that are not dropped, in row order. Buffers may be longer than this frame's particles.
fn particles(made: &Made) -> LayerData {
    let count = made.brought().map_or(0, |brought: &FlameBrought| brought.count);
    let positions: Vec<[f32; 4]> = made.read(POSITIONS, count);
    let prepared: Vec<Particle> = made.read(PARTICLES, count);
    let kept = positions.iter().zip(&prepared).filter(|(_, particle)| particle.count > 0);
    let row = |([x, y, z, temperature], particle): (&[f32; 4], &Particle)| {
        let [r, g, b, alpha] = particle.colour;
        [*x, *y, *z, *temperature, particle.mean_count, alpha, r, g, b]
    };
    LayerData::table(PARTICLE_COLUMNS, kept.flat_map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::Settings;
    use crate::offline::TARGET_FORMAT;
    use crate::program::layers::tests::{of, values};
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
            (POSITIONS, bytemuck::cast_slice(&positions)),
            (PARTICLES, bytemuck::cast_slice(&prepared)),
            (MASK, bytemuck::cast_slice(&mask)),
            (MEAN, bytemuck::cast_slice(&mean)),
            (VARIANCE, bytemuck::cast_slice(&variance)),
            (NEAREST, bytemuck::cast_slice(&nearest)),
            (HEAT_LAYER, bytemuck::cast_slice(&[[0.5_f32, 0.25], [1.0, 0.75]])),
            (TONE_LAYER, bytemuck::cast_slice(&mean)),
            (PICTURE, bytemuck::cast_slice(&picture)),
        ];
        let settings = Settings { variants: 2, ..Settings::default() };
        let desc = Desc {
            size: [2, 1],
            lines: None,
            target_format: TARGET_FORMAT,
            scene: None,
            accumulates: false,
            particles: 4,
            hottest: 2000.0,
            seed: 0,
            settings,
            layers: true,
            temporal: Default::default(),
        };
        let brought = FlameBrought::of(3);
        let layers = of(LAYERS, &desc, &bytes, &picture, Some(&brought), (true, &[]));
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
        assert_eq!(values(&layers, "flame.heat"), [0.5, 1.0]);
        assert_eq!(values(&layers, "flame.tone"), mean.as_flattened());
        assert_eq!(values(&layers, "flame.outline"), [0.25, 0.75]);
        assert_eq!(values(&layers, "flame"), picture.as_flattened());
        let shapes = layers.iter().filter_map(|layer| match &layer.data {
            LayerData::Array { shape, values } => Some((layer.name, shape.clone(), values.len())),
            _ => None,
        });
        let expected = [("flame.particles", vec![2, 9], 18), ("flame.mask", vec![2, 64, 64], 8192)];
        assert_eq!(shapes.collect::<Vec<_>>(), expected);
    }
}
