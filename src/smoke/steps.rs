//! Which steps a frame takes, in which order, and why others are left out.

use std::mem::offset_of;
use std::ops::Range;

use crate::effect::DeviceTraits;
use crate::host::Background;
use crate::layout::MOST_GROUPS;
use crate::plan::{Command, PassId, Plan};
use crate::scan;
use crate::shaders::smoke as glsl;
use crate::smoke::desc::Desc;
use crate::smoke::frame::{Frame, Shape};
use crate::smoke::layout::*;
use crate::smoke::limits::luminance_entries;
use crate::smoke::params::*;
use crate::smoke::passes::Passes;
use crate::smoke::search::{Pyramid, chosen_grow, growth_rows};
use crate::smoke::settings::{Grow, Radius, Settings, Shadow};
use crate::smoke::tables::Tables;
use crate::view::View;

/// The relation of a frame to the ones before, from which the effect chooses the steps.
#[derive(Clone, Copy, Debug)]
pub struct FrameDelta {
    /// Shape of the volume.
    pub shape: Shape,
    /// All particles are born anew.
    pub restart: bool,
    /// A volume came with this frame.
    pub new_volume: bool,
    /// What is made from volumes and settings is that of other settings.
    pub stale: bool,
    /// Tables are to be written.
    pub new_tables: bool,
    /// Why particles stay as they are, if they do.
    pub still: Option<&'static str>,
    /// Why the shadows of the last frame serve, if they do.
    pub same_shadow: Option<&'static str>,
    /// The view of the frame before; none if this one begins anew.
    pub view_before: Option<View>,
    /// How far particles have moved since then is on the device.
    pub moves: bool,
}

/// How radii are searched in a frame.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Growth,
    Field,
    Pyramid,
    Surface,
}

impl Way {
    fn of(settings: &Settings, shape: &Shape, traits: &DeviceTraits) -> Way {
        match chosen_grow(settings, shape, traits) {
            _ if settings.has_surface() => Way::Surface,
            Grow::Growth => Way::Growth,
            Grow::Field => Way::Field,
            _ => Way::Pyramid,
        }
    }

    /// Whether a search goes on in further dispatches.
    fn goes_on(self) -> bool {
        !matches!(self, Way::Field | Way::Surface)
    }
}

/// Fills a plan with the steps of a frame.
pub struct Steps<'a> {
    /// To be filled.
    pub plan: &'a mut Plan,
    /// The passes that may run.
    pub passes: &'a Passes,
    /// The description that the effect was made for.
    pub desc: &'a Desc,
    /// Sizes.
    pub layout: &'a Layout,
    /// The traits of the device.
    pub traits: &'a DeviceTraits,
    /// The relation of this frame to the ones before.
    pub delta: &'a FrameDelta,
}

impl Steps<'_> {
    /// The steps of `frame`.
    pub fn fill(mut self, frame: &Frame, params: &SmokeParams, tables: &Tables) {
        if frame.target.is_some() {
            self.background(&frame.background);
        }
        if self.desc.settings.particles == 0 {
            if self.desc.layers && frame.target.is_some() {
                self.plan.update(self.passes.params, CONTROL, &Control::reset());
                self.clear();
            }
            self.skip_particles("no particles");
            return self.skip_picture("no particles");
        }
        self.plan.update(self.passes.params, PARAMS, params);
        self.plan.update(self.passes.params, CONTROL, &Control::reset());
        if self.delta.new_tables {
            self.plan.update_slice(self.passes.tables, WEIGHTS, &tables.weights);
            self.plan.update_slice(self.passes.tables, TONES, &tables.tones);
        } else {
            self.plan.skip(self.passes.tables, "unchanged");
        }
        self.clears(frame);
        self.volume();
        self.particles();
        match frame.target {
            Some(_) => self.picture(frame),
            None => self.skip_picture("no target: the frame only moves the particles on"),
        }
    }

    /// What kernels add to begins empty: all of it first, so that nothing waits for it later.
    fn clears(&mut self, frame: &Frame) {
        if self.delta.restart {
            for buffer in [DYING, SPHERES, GROUPS] {
                self.plan.step(self.passes.restart, Command::Fill { buffer, word: 0 });
            }
        }
        if self.delta.still.is_none() && self.way().goes_on() {
            self.plan.step(self.passes.grow_reset, Command::Fill { buffer: CONTINUATIONS, word: 0 });
        }
        if frame.target.is_none() {
            return;
        }
        if self.unshadowed().is_none() && self.desc.settings.is_exact() {
            self.plan.step(self.passes.shadow_reset, Command::Fill { buffer: CELLS, word: 0 });
        }
        self.clear();
        self.plan.step(self.passes.occlusion_reset, Command::Fill { buffer: OCCLUSION, word: f32::INFINITY.to_bits() });
    }

    fn skip_particles(&mut self, reason: &'static str) {
        let Passes { occupancy, advect, grow_reset, listing, .. } = self.passes;
        for pass in [occupancy, advect, grow_reset, listing] {
            self.plan.skip(*pass, reason);
        }
    }

    fn skip_picture(&mut self, reason: &'static str) {
        let Passes { shadow_reset, occluders, spheres, tiles, luminance, .. } = self.passes;
        let Passes { gaussian: [rows, columns], outline, tone, composite, .. } = self.passes;
        for pass in [shadow_reset, occluders, spheres, tiles, luminance, rows, columns, &outline[0], tone] {
            self.plan.skip(*pass, reason);
        }
        let temporal = [self.passes.motion, self.passes.reactive].into_iter().flatten();
        temporal.chain([*composite]).for_each(|pass| self.plan.skip(pass, reason));
    }

    fn background(&mut self, background: &Background) {
        match Command::background(background, BACKGROUND, TARGET, self.desc.size) {
            Some(command) => self.plan.step(self.passes.background, command),
            None => self.plan.skip(self.passes.background, "the target is kept"),
        }
    }

    fn way(&self) -> Way {
        Way::of(&self.desc.settings, &self.delta.shape, self.traits)
    }

    fn volume(&mut self) {
        if !self.delta.new_volume && !self.delta.stale {
            self.plan.skip(self.passes.volume, "unchanged");
            self.plan.skip(self.passes.detail[0], "volume and detail unchanged");
            self.plan.skip(self.passes.occupancy, "volume and threshold unchanged");
            return;
        }
        let shape = &self.delta.shape;
        let bytes = 4 * shape.voxels();
        let copies = [(HOST_DENSITY, DENSITY, bytes), (HOST_VELOCITY, VELOCITY, 3 * bytes)];
        for (from, to, bytes) in copies.into_iter().take(if self.desc.velocity { 2 } else { 1 }) {
            if self.delta.new_volume {
                self.plan.step(self.passes.volume, Command::CopyBuffer { from, to, bytes });
            }
        }
        match self.desc.settings.is_detailed() {
            true => {
                let [x, y, z] = shape.dimensions;
                let [across, along] = self.passes.detail;
                let blocks = [x.div_ceil(DETAIL_COLUMNS), y.div_ceil(DETAIL_RUN), z];
                self.plan.step(across, Command::Dispatch { threads: blocks });
                self.plan.step(along, Command::Dispatch { threads: [x, y, z.div_ceil(DETAIL_RUN)] });
            }
            false => self.plan.skip(self.passes.detail[0], "detail is 0"),
        }
        let pyramid = Pyramid::new(shape.dimensions);
        let words = pyramid.row_words * shape.dimensions[1] * shape.dimensions[2];
        let births = 4 * u64::from(words.div_ceil(BIRTH_BLOCK) + 1).next_multiple_of(4);
        self.plan.step(self.passes.occupancy, Command::Dispatch { threads: [words, 1, 1] });
        // Beside what the searches need, of which each step waits for the one before.
        let [sums, add] = self.passes.births;
        scan::step(self.plan, sums, births);
        self.search_structure(&pyramid, 0..1);
        scan::step(self.plan, add, births);
        self.search_structure(&pyramid, 1..usize::MAX);
    }

    /// Some of the steps that make what radii are searched in.
    fn search_structure(&mut self, pyramid: &Pyramid, range: Range<usize>) {
        let is_first = range.start == 0;
        match self.way() {
            Way::Surface => {
                let cells = Pyramid::of_cells(self.delta.shape.dimensions);
                for (level, [x, y, z]) in cells.cell_dispatches().skip(range.start).take(range.len()) {
                    let command = Command::Dispatch { threads: [x * glsl::crossings::SHADER.local_size[0], y, z] };
                    self.plan.step_with(self.passes.crossings, command, &CrossingsConstants { level });
                }
                if is_first {
                    self.plan.skip(self.passes.field[0], "the surface is searched");
                    self.plan.skip(self.passes.pyramid, "the surface is searched");
                }
            }
            Way::Field => {
                let [nx, ny, nz] = self.delta.shape.dimensions;
                let threads = [nx.div_ceil(FIELD_VOXELS) * ny, nz, 1];
                let passes = self.passes.field.into_iter().skip(range.start).take(range.len());
                passes.for_each(|pass| self.plan.step(pass, Command::Dispatch { threads }));
                if is_first {
                    self.plan.skip(self.passes.pyramid, "the field is searched");
                }
            }
            Way::Pyramid => {
                let levels = (0..pyramid.count).zip(&pyramid.levels).skip(1 + range.start).take(range.len());
                for (level, PyramidLevel { rows_y, rows_z, .. }) in levels {
                    let command = Command::Dispatch { threads: [pyramid.row_words * rows_y * rows_z, 1, 1] };
                    self.plan.step_with(self.passes.pyramid, command, &PyramidConstants { level });
                }
                if is_first {
                    self.plan.skip(self.passes.field[0], "the pyramid is searched");
                }
            }
            Way::Growth if is_first => self.plan.skip(self.passes.field[0], "voxels are searched one by one"),
            Way::Growth => {}
        }
    }

    fn particles(&mut self) {
        let threads = [self.desc.settings.particles, 1, 1];
        if let Some(reason) = self.delta.still {
            self.plan.skip(self.passes.advect, reason);
            self.plan.skip(self.passes.grow_reset, reason);
        } else {
            self.plan.step(self.passes.advect, Command::Dispatch { threads });
            let pyramid = Pyramid::new(self.delta.shape.dimensions);
            match self.way() {
                Way::Surface => self.surface(),
                Way::Field => self.plan.step(self.passes.grow_field, Command::Dispatch { threads }),
                Way::Growth => {
                    self.search(self.passes.grow_growth, &pyramid, growth_rows(&self.delta.shape));
                }
                Way::Pyramid => self.search(self.passes.grow_pyramid, &pyramid, pyramid.leaves()),
            }
        }
        let spheres = [self.layout.spheres.div_ceil(LIST_RUN), 1, 1];
        self.plan.step(self.passes.count, Command::Dispatch { threads: spheres });
        self.plan.step(self.passes.listing, Command::Dispatch { threads: spheres });
    }

    /// A search in as many dispatches as the loop budget may ask for; all but the first are empty unless needed.
    fn search(&mut self, pass: PassId, pyramid: &Pyramid, last: u32) {
        let iterations = pyramid.iterations(self.traits);
        // A walk of the pyramid also visits the inner nodes.
        let visits = if pass == self.passes.grow_pyramid { last.saturating_mul(4).div_ceil(3) } else { last };
        let parts = visits.div_ceil(iterations).max(1);
        let is_ball = u32::from(self.desc.settings.radius == Radius::Ball);
        for part in 0..parts {
            let constants = SearchConstants { part, iterations, is_ball, last };
            self.plan.step_with(pass, self.part(part), &constants);
        }
    }

    /// The search for the surface: a workgroup a particle.
    fn surface(&mut self) {
        let particles = self.desc.settings.particles;
        let columns = particles.min(MOST_GROUPS as u32);
        let [x, y, _] = glsl::grow_surface::SHADER.local_size;
        let threads = [columns * x, particles.div_ceil(columns) * y, 1];
        let constants = SurfaceConstants { top: Pyramid::of_cells(self.delta.shape.dimensions).surface_top() };
        self.plan.step_with(self.passes.grow_surface, Command::Dispatch { threads }, &constants);
    }

    /// The dispatch of a part of a search.
    fn part(&self, part: u32) -> Command {
        match part {
            0 => Command::Dispatch { threads: [self.desc.settings.particles, 1, 1] },
            _ => Command::DispatchIndirect { arguments: CONTINUATIONS, offset: 16 * u64::from(part - 1) },
        }
    }

    fn picture(&mut self, frame: &Frame) {
        let settings = &self.desc.settings;
        self.shadow_and_spheres();
        self.tiles();
        let entries = luminance_entries(self.traits);
        for part in 0..self.layout.luminance_parts {
            let command = Command::DispatchIndirect { arguments: LUMINANCE_PARTS, offset: 16 * u64::from(part) };
            match settings.shadow {
                Shadow::None => self.plan.step(self.passes.luminance, command),
                Shadow::Exact => {
                    let constants = LuminanceConstants { part, entries };
                    self.plan.step_with(self.passes.luminance, command, &constants);
                }
                Shadow::Map => {
                    self.plan.step_with(self.passes.luminance, command, &MapConstants { texels: settings.shadow_map })
                }
            }
        }
        let tiles = dispatch(offset_of!(Control, tile_groups));
        self.outline_and_gaussian();
        self.plan.step(self.passes.tone, tiles);
        let tiles = draw(offset_of!(Control, tile_draw));
        if frame.depth.is_some() {
            self.edges(frame);
        }
        self.temporal(frame, tiles);
        match &frame.depth {
            Some(_) => {
                let constants = CompositeConstants { has_edges: frame.edges.is_some().into() };
                self.plan.step_with(self.passes.composite, tiles, &constants)
            }
            None => self.plan.step(self.passes.composite, tiles),
        }
    }

    /// Outputs for temporal upscalers.
    fn temporal(&mut self, frame: &Frame, tiles: Command) {
        if let Some(pass) = self.passes.motion {
            let FrameDelta { view_before, moves, .. } = self.delta;
            let constants = MotionConstants::new(view_before.as_ref(), &frame.view, self.desc.size, *moves);
            let has_edges = frame.edges.and(frame.depth).is_some().into();
            self.plan.step_with(pass, tiles, &MotionConstants { has_edges, ..constants });
        }
        if let Some(pass) = self.passes.reactive {
            self.plan.step(pass, tiles);
        }
    }

    /// Partial coverage of pixels.
    fn edges(&mut self, frame: &Frame) {
        let [width, height] = self.desc.size;
        let bytes = size_of::<Edge>() as u64 * u64::from(width) * u64::from(height);
        match frame.edges {
            Some(_) => self.plan.step(self.passes.edges, Command::CopyBuffer { from: HOST_EDGES, to: EDGES, bytes }),
            None => self.plan.skip(self.passes.edges, "nothing covers pixels in part"),
        }
    }

    /// Clears images where reads beyond occupied tiles must find them empty; layers are whole images.
    fn clear(&mut self) {
        self.plan.step(self.passes.clear, Command::Fill { buffer: PIXELS, word: 0 });
        self.plan.step(self.passes.clear, Command::Fill { buffer: DEPTH, word: f32::INFINITY.to_bits() });
        if self.desc.settings.outline.is_on() {
            self.plan.step(self.passes.clear, Command::Fill { buffer: LINES, word: 0 });
            if self.desc.settings.outline.is_hard() {
                self.plan.step(self.passes.clear, Command::Fill { buffer: INK_BITS, word: 0 });
            }
        }
        if self.desc.layers {
            self.plan.step(self.passes.clear, Command::Fill { buffer: SHADOW, word: 1.0_f32.to_bits() });
            for buffer in [SMOOTH, PICTURE].into_iter().chain(COLOUR_LAYERS) {
                self.plan.step(self.passes.clear, Command::Fill { buffer, word: 0 });
            }
        }
    }

    /// Why no shadow is made, if none is.
    fn unshadowed(&self) -> Option<&'static str> {
        match self.desc.settings.casts_shadows() {
            true => self.delta.same_shadow,
            false => Some("shadow is \"none\""),
        }
    }

    /// What the light sees and what the camera sees, step by step beside each other: neither waits for the other. Quads are
    /// no larger than what can be seen of their spheres.
    fn shadow_and_spheres(&mut self) {
        let live = dispatch(offset_of!(Control, live_groups));
        let spheres = draw(offset_of!(Control, draw));
        let [x, y, _] = glsl::tiles::SHADER.local_size;
        let tiles = Command::Dispatch { threads: [self.layout.tiles[0] * x, self.layout.tiles[1] * y, 1] };
        let unshadowed = self.unshadowed();
        if let Some(reason) = unshadowed {
            self.plan.skip(self.passes.shadow_reset, reason);
        }
        let is_exact = unshadowed.is_none() && self.desc.settings.is_exact();
        let [sums, add] = self.passes.shadow_scan;
        let cells = self.layout.size(CELLS);
        if is_exact {
            self.plan.step(self.passes.shadow_count, live);
        }
        self.plan.step(self.passes.occluders, live);
        if is_exact {
            scan::step(self.plan, sums, cells);
        }
        self.plan.step(self.passes.quads, live);
        if is_exact {
            scan::step(self.plan, add, cells);
        }
        if unshadowed.is_none() {
            self.shadow_maps();
        }
        self.plan.step(self.passes.spheres, spheres);
        if is_exact {
            self.plan.step(self.passes.shadow_fill, live);
        }
        self.plan.step(self.passes.tiles, tiles);
    }

    fn shadow_maps(&mut self) {
        for (face, pass) in self.passes.shadow_map.iter().enumerate() {
            let constants = ShadowConstants { face: face as u32, texels: self.desc.settings.shadow_map as f32 };
            self.plan.step_with(*pass, draw(offset_of!(Control, light_draw)), &constants);
        }
    }

    /// Which tiles are worked on, and with which of their groups.
    fn tiles(&mut self) {
        let tiles = self.layout.tiles[0] * self.layout.tiles[1];
        let (parts, part_entries) = (self.layout.luminance_parts, luminance_entries(self.traits));
        let cells = if parts > 1 { self.layout.light_cells * self.layout.light_faces } else { 0 };
        let threads = Command::Dispatch { threads: [tiles, 1, 1] };
        let [sums, occupied] = self.passes.occupied;
        self.plan.step_with(sums, threads, &OccupiedSumConstants { cells });
        let is_filtered = self.desc.settings.is_filtered();
        if is_filtered {
            let blocks = tiles * TILE_BLOCKS * TILE_BLOCKS;
            self.plan.step(self.passes.dilate, Command::Dispatch { threads: [blocks, 1, 1] });
            self.items(0, 0);
        }
        self.plan.step_with(occupied, threads, &OccupiedConstants { parts, part_entries });
        if is_filtered {
            self.items(0, 1);
        }
    }

    /// Half of the list of what the Gaussian works on in a batch of groups.
    fn items(&mut self, batch: u32, half: usize) {
        let (first, count) = self.desc.settings.summed();
        let before = batch * self.layout.batch_groups;
        let (first_group, group_count) = (first + before, self.layout.batch_groups.min(count - before));
        let constants = ItemsConstants { batch, first_group, group_count, capacity: self.layout.batch_capacity };
        let threads = [self.layout.tiles[0] * self.layout.tiles[1] * group_count, 1, 1];
        self.plan.step_with(self.passes.items[half], Command::Dispatch { threads }, &constants);
    }

    /// Lines and smoothed luminance, step by step beside each other: neither waits for the other.
    fn outline_and_gaussian(&mut self) {
        let [rows, columns] = self.passes.gaussian;
        self.outline(0);
        self.gaussian(rows, 0, 0);
        self.outline(1);
        self.gaussian(columns, 0, 1);
        for batch in 1..self.layout.batches {
            self.items(batch, 0);
            self.items(batch, 1);
            self.gaussian(rows, batch, 0);
            self.gaussian(columns, batch, 1);
        }
        if self.desc.settings.is_filtered() {
            self.channels();
        }
    }

    /// The Gaussian of what is smoothed beside luminance: of the same pixels, as listed for it.
    fn channels(&mut self) {
        for [rows, columns] in &self.passes.channels {
            for batch in 0..self.layout.batches {
                self.gaussian(*rows, batch, 0);
                self.gaussian(*columns, batch, 1);
            }
        }
    }

    /// One of the steps that make lines, if there is one.
    fn outline(&mut self, step: usize) {
        let Some(pass) = self.passes.outline.get(step) else { return };
        match self.desc.settings.outline.is_on() {
            true => self.plan.step(*pass, dispatch(offset_of!(Control, tile_groups))),
            false => self.plan.skip(*pass, "strength is 0"),
        }
    }

    /// Half of the Gaussian of a batch of groups.
    fn gaussian(&mut self, pass: PassId, batch: u32, half: u32) {
        if !self.desc.settings.is_filtered() {
            return self.plan.skip(pass, "sigma is 0");
        }
        let constants = GaussianConstants { base: batch * self.layout.batch_capacity };
        let offset = 16 * u64::from(2 * batch + half);
        self.plan.step_with(pass, Command::DispatchIndirect { arguments: ITEM_ARGUMENTS, offset }, &constants);
    }
}

/// A dispatch whose groups the device has counted.
fn dispatch(member: usize) -> Command {
    Command::DispatchIndirect { arguments: CONTROL, offset: member as u64 }
}

/// A draw whose quads the device has counted.
fn draw(member: usize) -> Command {
    Command::DrawIndirect { arguments: CONTROL, offset: member as u64 }
}
