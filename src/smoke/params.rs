//! What the host tells the kernels of `glsl/smoke`. The structures and constants are the shaders' own (build.rs).

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

pub use crate::shaders::smoke::blocks::*;
pub use crate::shaders::smoke::constants::*;
use crate::smoke::frame::{Desc, Frame, Shape};
use crate::smoke::layout::{Layout, Pyramid};
use crate::smoke::settings::{Emitter, Settings};
use crate::view::{Camera, CameraRows, Light, LightSource};

/// Levels that the occupancy pyramid can have.
pub const MAX_LEVELS: usize = 12;

impl Control {
    /// What a frame starts with.
    pub fn reset() -> Control {
        let groups = [0, 1, 1, 0];
        let draw = [4, 0, 0, 0];
        Control {
            live_groups: groups,
            draw,
            light_draw: draw,
            tile_groups: groups,
            tile_draw: draw,
            depth_low: u32::MAX,
            light_low_x: u32::MAX,
            light_low_y: u32::MAX,
            light_low_z: u32::MAX,
            ..Control::zeroed()
        }
    }
}

impl SmokeParams {
    /// What a frame's kernels are told. `frames` counts from the last restart.
    pub fn new(desc: &Desc, layout: &Layout, frame: &Frame, shape: &Shape, frames: u32) -> SmokeParams {
        let settings = &desc.settings;
        let mut params = SmokeParams::zeroed();
        params.set_camera(desc, layout, &frame.camera);
        params.set_volume(settings, shape);
        params.set_light(desc, layout, &frame.light, shape);
        let smallest = shape.voxel_size.iter().copied().fold(f32::MAX, f32::min);
        params.shade[1] = settings.softness;
        params.shade[2] = settings.scale;
        params.shade[3] = frame.dt;
        params.motion = [
            settings.still * smallest / frame.dt,
            settings.range_smoothing,
            settings.hysteresis,
            settings.group_depth.unwrap_or(0.0),
        ];
        params.counts = [settings.particles, settings.fade, layout.spheres, desc.seed];
        params.frame = [frames, u32::from(desc.velocity), settings.lifetime.unwrap_or(0), settings.group_count()];
        let ring = if settings.fade == 0 { 0 } else { frames % settings.fade };
        params.filtering = [settings.window(), layout.window_blocks, settings.tones.len() as u32, ring];
        let outline = &settings.outline;
        let footprint = 2.0 * frame.camera.half_extent(desc.size).y / f64::from(desc.size[1]);
        params.ink = [outline.strength, outline.width, smallest, footprint as f32];
        let [r, g, b] = outline.colour;
        params.ink_colour = [r, g, b, settings.tone_softness];
        params
    }

    fn set_camera(&mut self, desc: &Desc, layout: &Layout, camera: &Camera) {
        let CameraRows { eye, rows, lens } = CameraRows::new(camera, desc.size);
        [self.eye, self.eye_low] = eye;
        [[self.right, self.right_low], [self.up, self.up_low], [self.forward, self.forward_low]] = rows;
        self.lens = lens;
        self.image = [desc.size[0], desc.size[1], layout.tiles[0], layout.tiles[1]];
        let [across, down] = layout.occlusion_blocks;
        self.blocks = [layout.occlusion_side, across, down, 0];
    }

    fn set_volume(&mut self, settings: &Settings, shape: &Shape) {
        let Shape { dimensions: [nx, ny, nz], voxel_size: [hx, hy, hz], origin: [ox, oy, oz] } = *shape;
        let pyramid = Pyramid::new(shape.dimensions);
        self.grid = [nx, ny, nz, pyramid.row_words];
        self.voxel = [hx, hy, hz, hx.min(hy).min(hz)];
        self.origin = [ox, oy, oz, settings.threshold];
        self.levels = pyramid.levels;
        self.emitter_last = [nx as i32 - 1, ny as i32 - 1, nz as i32 - 1, 0];
        if let Some(Emitter { min, max }) = settings.emitter {
            for axis in 0..3 {
                let (first, last) = overlapped(shape, axis, min[axis], max[axis]);
                self.emitter_first[axis] = first;
                self.emitter_last[axis] = last;
            }
            self.emitter_first[3] = 1;
            self.emitter_low = [min[0], min[1], min[2], 0.0];
            self.emitter_high = [max[0], max[1], max[2], 0.0];
        }
    }

    fn set_light(&mut self, desc: &Desc, layout: &Layout, light: &Light, shape: &Shape) {
        let corner = DVec3::from(shape.origin.map(f64::from));
        let extent =
            DVec3::from_array([0, 1, 2].map(|a| f64::from(shape.voxel_size[a]) * f64::from(shape.dimensions[a])));
        let corners = (0..8_u32)
            .map(|i| corner + extent * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let vector = |v: DVec3, w: f32| v.as_vec3().extend(w).to_array();
        match light.source {
            LightSource::Direction(direction) => {
                let towards = -direction.normalize();
                let (right, up) = towards.any_orthonormal_pair();
                self.light = vector(towards, 0.0);
                (self.light_right, self.light_up) = (vector(right, 0.0), vector(up, 0.0));
                let nearest = corners.clone().map(|c| -c.dot(towards)).fold(f64::MAX, f64::min);
                let farthest = corners.clone().map(|c| -c.dot(towards)).fold(f64::MIN, f64::max);
                self.light_range = [nearest as f32, (1.0 / (farthest - nearest).max(1e-30)) as f32, 0.0, 0.0];
                let across = corners.map(|c| DVec2::new(c.dot(right), c.dot(up)));
                let (low, high) = across.fold((DVec2::MAX, DVec2::MIN), |(low, high), at| (low.min(at), high.max(at)));
                let side = (high - low).max_element().max(1e-30);
                self.light_frame = [low.x as f32, low.y as f32, (1.0 / side) as f32, 2.0 * extent.length() as f32];
            }
            LightSource::Position(position) => {
                self.light = vector(position, 1.0);
                let farthest = corners.map(|c: DVec3| c.distance(position)).fold(0.0, f64::max);
                self.light_frame = [0.0, 0.0, 1.0, (farthest + extent.length()) as f32];
                let nearest = (farthest - 2.0 * extent.length()).max(0.0);
                self.light_range = [nearest as f32, (1.0 / (farthest - nearest).max(1e-30)) as f32, 0.0, 0.0];
            }
        }
        self.shade[0] = light.ambient as f32;
        self.shadow = [layout.light_levels, layout.light_cells, layout.light_faces, desc.settings.shadow_filter];
    }
}

/// First and last voxel along an axis that overlap an interval; first > last if none does. A flat interval lies in the
/// voxel that holds it.
fn overlapped(shape: &Shape, axis: usize, min: f32, max: f32) -> (i32, i32) {
    let face = |index: i32| shape.origin[axis] + index as f32 * shape.voxel_size[axis];
    let count = shape.dimensions[axis] as i32;
    let overlaps = |index: &i32| {
        let (low, high) = (face(*index), face(index + 1));
        min < high && (low < max || low <= min)
    };
    let first = (0..count).find(overlaps).unwrap_or(count);
    let last = (0..count).rev().find(overlaps).unwrap_or(-1);
    (first, last)
}
