//! Parameters of the kernels of `glsl/smoke`. The structures and constants are the shaders' own (build.rs).

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

pub use crate::shaders::smoke::blocks::*;
pub use crate::shaders::smoke::constants::*;
use crate::smoke::desc::Desc;
use crate::smoke::frame::{Frame, Shape};
use crate::smoke::layout::Layout;
use crate::smoke::search::{self, Pyramid};
use crate::smoke::settings::{Emitter, Settings};
use crate::view::{FireLight, Light, LightSource, Projection};

impl Control {
    /// The state at the start of a frame.
    pub fn reset() -> Control {
        let groups = [0, 1, 1, 0];
        let draw = [QUAD_VERTICES, 0, 0, 0];
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
    /// Parameters of a frame, as the kernels read them. `frames` counts from the last restart.
    pub fn new(desc: &Desc, layout: &Layout, frame: &Frame, shape: &Shape, frames: u32) -> SmokeParams {
        let mut params = SmokeParams::zeroed();
        params.set_picture(desc, layout, &Projection::of_valid(&frame.view, desc.size));
        params.corner = frame.target.map_or([0; 2], |target| target.offset);
        params.set_volume(&desc.settings, shape);
        params.set_light(desc, layout, &frame.light, shape);
        params.set_more_light(frame);
        params.set_particles(desc, layout, frame.dt, frames);
        params.set_look(&desc.settings, layout);
        params.set_height(&desc.settings, &frame.light, &Projection::of_valid(&frame.view, desc.size));
        params
    }

    fn set_picture(&mut self, desc: &Desc, layout: &Layout, projection: &Projection) {
        let size = DVec2::from_array(desc.size.map(f64::from));
        let half_extent = size / 2.0 / projection.focal;
        let off_axis = projection.slope_at(size / 2.0);
        *self = SmokeParams {
            camera: CameraRows::new(projection),
            half_extent: half_extent.as_vec2().to_array(),
            off_axis: off_axis.as_vec2().to_array(),
            depth_terms: projection.terms(),
            is_orthographic: projection.is_orthographic.into(),
            near: projection.near as f32,
            far: projection.far as f32,
            size: desc.size,
            tiles: layout.tiles,
            row_groups: layout.row_groups,
            pixel_footprint: projection.focal.y.recip() as f32,
            occlusion_side: layout.occlusion_side,
            occlusion_blocks: layout.occlusion_blocks,
            ..*self
        };
    }

    fn set_volume(&mut self, settings: &Settings, shape: &Shape) {
        let Shape { dimensions: [nx, ny, nz], voxel_size: [hx, hy, hz], origin: [ox, oy, oz] } = *shape;
        let Pyramid { row_words, levels, .. } = Pyramid::new(shape.dimensions);
        let cells = Pyramid::of_cells(shape.dimensions);
        // Checked before: none is too wide.
        let [dx, dy, dz] = search::detail(settings, shape).ok().flatten().unwrap_or_default();
        let [wx, wy, wz] = [dx, dy, dz].map(search::detail_window);
        let (mut first, mut last) = ([0; 3], [nx, ny, nz].map(|n| n as i32 - 1));
        if let Some(Emitter { min, max }) = settings.emitter {
            for axis in 0..3 {
                (first[axis], last[axis]) = overlapped(shape, axis, min[axis], max[axis]);
            }
        }
        let (min, max) = settings.emitter.map_or_else(Default::default, |emitter| (emitter.min, emitter.max));
        *self = SmokeParams {
            voxel_size: [hx, hy, hz, 0.0],
            origin: [ox, oy, oz, 0.0],
            dimensions: [nx, ny, nz, 0],
            row_words,
            levels: if settings.has_surface() { cells.levels } else { levels },
            crossing_row_words: cells.row_words,
            detail_weights: search::detail_weights([dx, dy, dz]),
            detail_window: [wx, wy, wz, 0],
            smallest_side: hx.min(hy).min(hz),
            threshold: settings.threshold,
            has_emitter: settings.emitter.is_some().into(),
            emitter_first: [first[0], first[1], first[2], 0],
            emitter_last: [last[0], last[1], last[2], 0],
            emitter_min: [min[0], min[1], min[2], 0.0],
            emitter_max: [max[0], max[1], max[2], 0.0],
            ..*self
        };
    }

    fn set_light(&mut self, desc: &Desc, layout: &Layout, light: &Light, shape: &Shape) {
        let corner = DVec3::from(shape.origin.map(f64::from));
        let extent =
            DVec3::from_array([0, 1, 2].map(|a| f64::from(shape.voxel_size[a]) * f64::from(shape.dimensions[a])));
        let corners = (0..8_u32)
            .map(|i| corner + extent * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let vector = |v: DVec3| v.as_vec3().extend(0.0).to_array();
        let (nearest, farthest);
        match light.source {
            LightSource::Direction(direction) => {
                let towards = -direction.normalize();
                let (right, up) = towards.any_orthonormal_pair();
                (self.light, self.light_right, self.light_up) = (vector(towards), vector(right), vector(up));
                nearest = corners.clone().map(|c| -c.dot(towards)).fold(f64::MAX, f64::min);
                farthest = corners.clone().map(|c| -c.dot(towards)).fold(f64::MIN, f64::max);
                let across = corners.map(|c| DVec2::new(c.dot(right), c.dot(up)));
                let (low, high) = across.fold((DVec2::MAX, DVec2::MIN), |(low, high), at| (low.min(at), high.max(at)));
                let side = (high - low).max_element().max(1e-30);
                self.light_low = low.as_vec2().to_array();
                self.light_inverse_side = (1.0 / side) as f32;
                self.caster_distance = 2.0 * extent.length() as f32;
            }
            LightSource::Position(position) => {
                self.is_point_light = 1;
                self.light = vector(position);
                farthest = corners.map(|c: DVec3| c.distance(position)).fold(0.0, f64::max);
                nearest = (farthest - 2.0 * extent.length()).max(0.0);
                self.light_inverse_side = 1.0;
                self.caster_distance = (farthest + extent.length()) as f32;
            }
        }
        *self = SmokeParams {
            light_nearest: nearest as f32,
            light_inverse_span: (1.0 / (farthest - nearest).max(1e-30)) as f32,
            ambient: light.ambient as f32,
            fill: light.fill_axis(),
            softness: desc.settings.softness,
            light_levels: layout.light_levels,
            light_cells: layout.light_cells,
            light_faces: layout.light_faces,
            shadow_filter: desc.settings.shadow_filter,
            ..*self
        };
    }

    fn set_more_light(&mut self, frame: &Frame) {
        (self.second_light, self.second_strength) = frame.light.second_terms();
        self.rim = frame.light.rim as f32;
        // Without a fire there is none of its light.
        if let Some(FireLight { position, colour: [r, g, b], reach }) = frame.fire {
            self.fire = position.extend(reach.powi(-2)).as_vec4().to_array();
            self.fire_colour = [r, g, b, 0.0];
        }
    }

    /// Heights are along the light's way up.
    fn set_height(&mut self, settings: &Settings, light: &Light, projection: &Projection) {
        let [from, to] = settings.gradient;
        let up = light.up.normalize();
        let eye = projection.eye.dot(up) - f64::from(from);
        self.height = (projection.axes * up).extend(eye).as_vec4().to_array();
        self.gradient_height = to - from;
        self.tones_above = settings.tones_above.as_ref().map_or(0, |tones| tones.len() as u32);
    }

    /// After [`Self::set_volume`].
    fn set_particles(&mut self, desc: &Desc, layout: &Layout, dt: f32, frames: u32) {
        let settings = &desc.settings;
        *self = SmokeParams {
            particles: settings.particles,
            fade: settings.fade,
            spheres: layout.spheres,
            seed: desc.seed,
            frames,
            has_velocity: desc.velocity.into(),
            lifetime: settings.lifetime.unwrap_or(0),
            ring_row: if settings.fade == 0 { 0 } else { frames % settings.fade },
            dt,
            still_speed: settings.still * self.smallest_side / dt,
            scale: settings.scale,
            radius_smoothing: settings.radius_smoothing,
            boil: settings.boil,
            group_count: settings.group_count(),
            group_depth: settings.group_depth.unwrap_or(0.0),
            range_smoothing: settings.range_smoothing,
            hysteresis: settings.hysteresis,
            ..*self
        };
    }

    fn set_look(&mut self, settings: &Settings, layout: &Layout) {
        let pixels = &layout.pixels;
        let outline = &pixels.outline;
        let (silhouettes, inner) = (outline.silhouettes(), outline.inner_lines());
        let colour = |[r, g, b]: [f32; 3], w| [r, g, b, w];
        *self = SmokeParams {
            window: pixels.window(),
            window_blocks: layout.window_blocks,
            tone_count: settings.tones.len() as u32,
            tone_softness: pixels.tone_softness,
            smallest: pixels.smallest,
            silhouette_colour: colour(silhouettes.colour, silhouettes.strength),
            inner_colour: colour(inner.colour, 0.0),
            silhouette_width: silhouettes.width,
            inner_width: inner.width,
            inner_strength: inner.strength,
            outline_taper: outline.taper,
            shortest_line: outline.shortest,
            trace_reach: outline.trace_reach(),
            piece_reach: outline.piece_reach(),
            ..*self
        };
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
