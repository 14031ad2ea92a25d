//! What the host tells the kernels of `glsl/flame`. The structures and constants are the shaders' own (build.rs).

use bytemuck::Zeroable;

use crate::flame::colour::Table;
use crate::flame::frame::{Desc, Frame};
use crate::flame::layout::Layout;
use crate::flame::settings::{Mode, Shape};
pub use crate::shaders::flame::blocks::*;
pub use crate::shaders::flame::constants::*;
use crate::view::CameraRows;

/// Levels that the cells of the screen can have.
pub const MAX_LEVELS: usize = 12;
/// Classes of the kernel table, by threshold: bits of a word.
pub const KERNEL_CLASSES: u32 = 32;
/// Its places along x and along y.
pub const KERNEL_PLACES: u32 = 97;
/// Its depths.
pub const KERNEL_DEPTHS: u32 = 16;
/// Depth buckets of the stochastic mode.
pub const BUCKETS: u32 = 32;

impl Control {
    /// What a frame starts with.
    pub fn reset() -> Control {
        Control {
            nearest: u32::MAX,
            range_low: u32::MAX,
            depth_low: u32::MAX,
            tile_groups: [0, 1, 1, 0],
            active_groups: [0, 1, 1, 0],
            tile_draw: [4, 0, 0, 0],
            screen_draw: [4, 1, 0, 0],
            sprite_draw: [4, 0, 0, 0],
            ..Control::zeroed()
        }
    }
}

/// What a frame is besides its [`Frame`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// Particles.
    pub count: u32,
    /// Whether they have ids.
    pub ids: bool,
    /// Repetitions that earlier frames have added.
    pub before: u32,
}

impl FlameParams {
    /// What a frame's kernels are told.
    pub fn new(desc: &Desc, layout: &Layout, frame: &Frame, given: &Given, table: &Table, max_alpha: f32) -> Self {
        let settings = &desc.settings;
        let CameraRows { eye, rows, lens } = CameraRows::new(&frame.camera, desc.size);
        let mut params = FlameParams::zeroed();
        [params.eye, params.eye_low] = eye;
        [[params.right, params.right_low], [params.up, params.up_low], [params.forward, params.forward_low]] = rows;
        params.lens = lens;
        let [width, height] = desc.size;
        let focal = f64::from(height) / 2.0 / frame.camera.half_extent(desc.size).y;
        params.focal = [focal as f32, width as f32 / 2.0, height as f32 / 2.0, (1.0 / focal) as f32];
        params.image = [width, height, layout.tiles[0], layout.tiles[1]];
        params.counts = [given.count, layout.buckets, layout.levels.len() as u32, 0];
        // Draws that have flickered on: whole ones, and the fraction that some particles' phases make one more.
        let flickered = u64::from(frame.number) * (f64::from(settings.flicker) * 65536.0).round() as u64;
        params.draw = [desc.seed, settings.variants, (flickered >> 16) as u32, (flickered & 0xffff) as u32];
        let bits = settings.repetitions.next_power_of_two().trailing_zeros().clamp(1, 20);
        let flags = u32::from(settings.size_pixels.is_some()) | u32::from(given.ids) << 1;
        params.flags = [u32::from(desc.skipping), bits, given.before, flags];
        params.model = [settings.alpha_scale, settings.threshold, settings.count, settings.hottest];
        let least = match settings.mode {
            Mode::Stochastic => 0.0,
            // The table is over the depth of a particle's space, which must have one.
            Mode::Expected => settings.sprite() / 256.0,
        };
        let spread = settings.spread.unwrap_or_default().max(least);
        let depth = if settings.shape == Shape::Cube { spread * 3.0_f32.sqrt() } else { spread };
        params.space = [spread, settings.size_pixels.unwrap_or(settings.sprite()), depth, desc.hottest];
        params.light = [settings.intensity, max_alpha, settings.adaptive, settings.light];
        params.colour = [table.scale, table.offset, table.entries.len() as f32 - 1.0, table.falloff];
        let [r, g, b] = table.shift;
        params.shift = [r, g, b, 0.0];
        for (to, level) in params.levels.iter_mut().zip(&layout.levels) {
            *to = *level;
        }
        params
    }
}

/// Depth buckets of an effect.
pub fn buckets(mode: Mode, bins: u32) -> u32 {
    match mode {
        Mode::Stochastic => BUCKETS,
        Mode::Expected => bins,
    }
}
