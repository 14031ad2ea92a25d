//! The structures of `glsl/flame/params.glsl` and the kernels' push constants. Offsets and sizes are compared with the
//! shaders' when the crate is built; what the fields mean stands there.
#![allow(missing_docs)] // the shader's declarations document the fields

use bytemuck::{Pod, Zeroable};

use crate::flame::colour::Table;
use crate::flame::frame::{Desc, Frame};
use crate::flame::layout::Layout;
use crate::flame::settings::{Mode, Shape};
use crate::layout::push_constants;
use crate::view::CameraRows;

/// Side of a screen tile in pixels.
pub const TILE: u32 = 16;
/// A particle stands at the level of cells where it touches at most so many across and down.
pub const CELLS_ACROSS: u32 = 4;
/// Texels of the mask along a side.
pub const MASK_SIDE: u32 = 64;
/// Levels of the mask.
pub const MASK_LEVELS: u32 = 7;
/// Levels that the cells of the screen can have.
pub const MAX_LEVELS: usize = 12;
/// Classes of the kernel table, by threshold: bits of a word.
pub const KERNEL_CLASSES: u32 = 32;
/// Its places along x and along y.
pub const KERNEL_PLACES: u32 = 97;
/// Its depths.
pub const KERNEL_DEPTHS: u32 = 16;
/// Most texels of pass shares along a side.
pub const SHARE_SIDE: u32 = 32;
/// Depth buckets of the stochastic mode.
pub const BUCKETS: u32 = 32;

/// `FlameParams`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FlameParams {
    pub eye: [f32; 4],
    pub eye_low: [f32; 4],
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub forward: [f32; 4],
    pub right_low: [f32; 4],
    pub up_low: [f32; 4],
    pub forward_low: [f32; 4],
    pub lens: [f32; 4],
    pub focal: [f32; 4],
    pub image: [u32; 4],
    pub counts: [u32; 4],
    pub draw: [u32; 4],
    pub flags: [u32; 4],
    pub model: [f32; 4],
    pub space: [f32; 4],
    pub light: [f32; 4],
    pub colour: [f32; 4],
    pub shift: [f32; 4],
    pub levels: [[u32; 4]; MAX_LEVELS],
}

/// `Control`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Control {
    pub brightest: u32,
    pub nearest: u32,
    pub range_low: u32,
    pub range_high: u32,
    pub visible: u32,
    pub most: u32,
    pub segments: u32,
    pub segment_entries: u32,
    pub part_repetitions: u32,
    pub listed: u32,
    pub classes: u32,
    pub new_classes: u32,
    pub base: u32,
    pub depth_low: u32,
    pub depth_high: u32,
    pub unused: u32,
    pub tile_groups: [u32; 4],
    pub active_groups: [u32; 4],
    pub tile_draw: [u32; 4],
    pub share_groups: [u32; 4],
    pub kernel_groups: [u32; 4],
    pub screen_draw: [u32; 4],
    pub sprite_draw: [u32; 4],
}

/// `Particle`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Particle {
    pub view: [f32; 4],
    pub centre: [f32; 4],
    pub slope: [f32; 4],
    pub colour: [f32; 4],
    pub draw: [u32; 4],
    pub light: [u32; 4],
}

/// `Lamp`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Lamp {
    pub place: [f32; 4],
    pub colour: [f32; 4],
}

push_constants! {
    /// Of `scan`.
    ScanConstants { cells: u32, turns: u32, base: u32, visit: u32, eighths: u32, repetitions: u32 }
    /// Of `tiles` and `adapt`.
    PartsConstants { first: u32, most: u32, repetitions: u32, stages: u32 }
    /// Of `mips`.
    MipsConstants { level: u32 }
    /// Of `scene`.
    SceneConstants { terms: [f32; 2], kind: u32 }
    /// Of `raster`.
    RasterConstants { repetition: u32 }
    /// Of `add`.
    AddConstants { is_first: u32 }
    /// Of `rebuild`.
    RebuildConstants { force: u32 }
    /// Of `accumulate` and `expected`, whose repetitions are bins.
    AccumulateConstants { part: u32, repetitions: u32, last: u32, before: u32 }
}

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
