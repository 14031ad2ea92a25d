//! Parameters of the kernels of `glsl/flame`. The structures and constants are the shaders' own (build.rs).

use bytemuck::Zeroable;

use crate::flame::desc::Desc;
use crate::flame::frame::Frame;
use crate::flame::layout::Layout;
use crate::flame::settings::{MOST_REPETITIONS, Settings, Shape};
use crate::flame::tables::Tables;
pub use crate::shaders::flame::blocks::*;
pub use crate::shaders::flame::constants::*;
use crate::view::Projection;

/// Bits of an index into the Sobol sequence for so many repetitions, 1 to 20.
pub fn sobol_bits(repetitions: u32) -> u32 {
    repetitions.max(1).next_power_of_two().trailing_zeros().clamp(1, MOST_REPETITIONS.trailing_zeros())
}

impl Control {
    /// The state at the start of a frame.
    pub fn reset() -> Control {
        Control {
            nearest: NOTHING,
            range_low: NOTHING,
            depth_low: NOTHING,
            tile_groups: [0, 1, 1, 0],
            active_groups: [0, 1, 1, 0],
            tile_draw: [QUAD_VERTICES, 0, 0, 0],
            screen_draw: [QUAD_VERTICES, 1, 0, 0],
            sprite_draw: [QUAD_VERTICES, 0, 0, 0],
            ..Control::zeroed()
        }
    }
}

/// The facts of a frame besides its [`Frame`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// Particles.
    pub count: u32,
    /// Whether they have ids.
    pub ids: bool,
    /// Whether they have velocities.
    pub velocities: bool,
    /// Repetitions that earlier frames have added.
    pub before: u32,
    /// How far sprites are from their particle at most, in metres.
    pub spread: f32,
}

/// The space that a particle's render particles fill, and their size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    /// How far they are from the particle at most, in metres.
    pub spread: f32,
    /// Side of a sprite in metres, unless it is given in pixels.
    pub sprite: f32,
    /// The same in spreads: all that the table of the expected image depends on; 0 without a spread.
    pub relative: f32,
}

impl Space {
    /// Of a frame with that spread: sprites are as large unless the settings say their size.
    pub fn new(settings: &Settings, spread: f32) -> Space {
        let sprite = settings.size.unwrap_or(spread);
        // The table is over the depth of a particle's space, which must have one.
        let spread = if settings.is_expected() { spread.max(sprite / 256.0) } else { spread };
        Space { spread, sprite, relative: if spread > 0.0 { sprite / spread } else { 0.0 } }
    }
}

impl FlameParams {
    /// Parameters of a frame, as the kernels read them.
    pub fn new(desc: &Desc, layout: &Layout, frame: &Frame, given: &Given, tables: &Tables, max_alpha: f32) -> Self {
        let table = &tables.colours;
        let settings = &desc.settings;
        let projection = &Projection::of_valid(&frame.view, desc.size);
        // Draws are renewed as a whole, and the fraction is those particles' whose phases make one more of it.
        let flickered = u64::from(frame.number) * (f64::from(settings.flicker) * 65536.0).round() as u64;
        let iterations = if settings.is_expected() { settings.bins } else { settings.repetitions };
        let Space { spread, sprite, relative } = Space::new(settings, given.spread);
        // Sprites of given pixels have no depth of their own.
        let slab = settings.shines() * if settings.size_pixels.is_some() { spread } else { sprite };
        let [red, green, blue] = table.shift;
        let mut cell_levels = [CellLevel::zeroed(); MAX_CELL_LEVELS as usize];
        cell_levels.iter_mut().zip(&layout.levels).for_each(|(to, level)| *to = *level);
        FlameParams {
            camera: CameraRows::new(projection),
            near: projection.near as f32,
            far: projection.far as f32,
            focal_length: projection.focal.as_vec2().to_array(),
            pixel_slope: projection.focal.recip().as_vec2().to_array(),
            principal_point: projection.centre.as_vec2().to_array(),
            depth_terms: projection.terms(),
            is_orthographic: projection.is_orthographic.into(),
            pixel_footprint: projection.focal.min_element().recip() as f32,
            squash: if settings.size_pixels.is_some() { 1.0 } else { (projection.focal.x / projection.focal.y) as f32 },
            size: desc.size,
            corner: frame.target.offset,
            tiles: layout.tiles,
            cell_count: layout.cells,
            cell_level_count: layout.levels.len() as u32,
            bucket_count: layout.buckets,
            iterations,
            repetitions_before: given.before,
            particle_count: given.count,
            seed: desc.seed,
            variants: settings.variants,
            sobol_bits: sobol_bits(settings.repetitions),
            flicker_whole: (flickered >> 16) as u32,
            flicker_fraction: (flickered & 0xffff) as u32,
            is_skipping: 1,
            is_in_pixels: settings.size_pixels.is_some().into(),
            has_ids: given.ids.into(),
            sprite_size: settings.size_pixels.unwrap_or(sprite),
            spread,
            bounding_radius: if settings.shape == Shape::Cube { spread * 3.0_f32.sqrt() } else { spread },
            relative_size: relative,
            slabs: if slab > 0.0 { slab.recip().min(1e30) } else { 0.0 },
            alpha_scale: settings.alpha_scale,
            threshold: settings.threshold,
            count: settings.count,
            hottest: settings.hottest,
            max_temperature: desc.hottest,
            max_alpha,
            intensity: settings.intensity,
            adaptive: settings.adaptive,
            light: settings.light,
            stretch: settings.stretch,
            has_velocities: given.velocities.into(),
            falloff: table.falloff,
            tone_softness: tables.pixels.tone_softness,
            tone_count: settings.tones.0.len() as u32,
            window: tables.pixels.window() as i32,
            half_sums: tables.half_sums,
            ink_width: tables.pixels.outline.width,
            glow_window: tables.pixels.glow.window() as i32,
            glow: settings.glow.strength * tables.glow_scale,
            embers: settings.embers.share,
            ember_radius: 0.5 * tables.pixels.embers.size,
            ember_rise: settings.embers.height(given.spread),
            ink: [
                settings.outline.colour[0],
                settings.outline.colour[1],
                settings.outline.colour[2],
                settings.outline.strength,
            ],
            table_scale: table.scale,
            table_offset: table.offset,
            table_last: table.entries.len() as f32 - 1.0,
            table_shift: [red, green, blue, 0.0],
            cell_levels,
            ..FlameParams::zeroed()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_hold_the_repetitions() {
        let given = [0, 1, 2, 3, 4, 20, 64, 65, 1 << 20, u32::MAX >> 1];
        assert_eq!(given.map(sobol_bits), [1, 1, 1, 2, 2, 5, 6, 7, 20, 20]);
    }
}
