//! A frame's list: which passes run, over how much, in which order, and why others do not. Pure.

use std::mem::offset_of;

use crate::effect::DeviceTraits;
use crate::flame::desc::{Desc, SceneFormat};
use crate::flame::frame::{Frame, SceneDepth};
use crate::flame::layout::*;
use crate::flame::limits::{Cost, Stage, is_raster, iterations, kernels};
use crate::flame::params::{
    AccumulateConstants, AdaptConstants, AddConstants, Control, FlameParams, Given, KernelTable, MASK_LEVELS,
    MASK_SIDE, MipsConstants, MotionConstants, PARTICLE_VERTICES, PartsConstants, RasterConstants, RebuildConstants,
    SceneConstants,
};
use crate::flame::passes::Passes;
use crate::flame::settings::Shape;
use crate::flame::tables::Tables;
use crate::host::{Background, words_of};
use crate::plan::{Command, PassId, Plan, Shader};
use crate::scan;
use crate::shaders::flame as glsl;
use crate::view::View;

/// The relation of this frame to the ones before.
#[derive(Clone, Copy, Debug)]
pub struct FrameDelta {
    /// Its particles.
    pub given: Given,
    /// The view of the last frame that saw fire.
    pub view: Option<View>,
    /// Whether its sprites had as many spreads.
    pub has_size: bool,
    /// The view of the frame before.
    pub view_before: Option<View>,
    /// Tables and mask are not on the device yet, and asked for.
    pub make_tables: bool,
    /// Why no fire can be seen, if it is known before the device has looked.
    pub dark: Option<&'static str>,
}

/// Fills a frame's plan.
pub(super) struct Steps<'a> {
    pub(super) plan: &'a mut Plan,
    pub(super) passes: &'a Passes,
    pub(super) desc: &'a Desc,
    pub(super) layout: &'a Layout,
    pub(super) traits: &'a DeviceTraits,
    pub(super) delta: &'a FrameDelta,
}

impl Steps<'_> {
    pub(super) fn fill(&mut self, frame: &Frame, params: &FlameParams, tables: &Tables) {
        self.background(&frame.background);
        self.particles(frame);
        self.clear();
        let dark = self.delta.dark;
        if self.delta.make_tables || dark.is_none() {
            self.plan.update(self.passes.params, PARAMS, params);
        }
        if self.delta.make_tables {
            self.plan.update_slice(self.passes.tables, COLOURS, &tables.colours.entries);
            self.plan.update_slice(self.passes.tables, WEIGHTS, &tables.weights);
            self.plan.update_slice(self.passes.tables, GLOW_WEIGHTS, &tables.glow_weights);
            self.plan.update_slice(self.passes.tables, TONES, &tables.tones);
            self.mask();
        } else {
            let reason = dark.unwrap_or("size and seed unchanged");
            self.plan.skip(self.passes.tables, reason);
            self.plan.skip(self.passes.mask, reason);
        }
        if let Some(reason) = dark {
            return self.skip_fire(reason);
        }
        self.plan.update(self.passes.params, CONTROL, &Control::reset());
        self.plan.step(self.passes.bin_reset, Command::Fill { buffer: CELLS, word: 0 });
        self.scene(frame);
        self.lists(frame);
        self.repetitions();
        self.light();
        self.picture();
        let tiles = dispatch(offset_of!(Control, tile_groups));
        self.passes.glow.iter().for_each(|pass| self.plan.step(*pass, tiles));
        self.temporal(frame);
        self.plan.step(self.passes.composite, draw(offset_of!(Control, tile_draw)));
        let embers = Command::Draw { vertices: PARTICLE_VERTICES * self.delta.given.count };
        let Passes { embers: drawn, embers_reactive, .. } = *self.passes;
        drawn.into_iter().chain(embers_reactive).for_each(|pass| self.plan.step(pass, embers));
    }

    /// From sums to the picture. Tones are made of the sums themselves, so nothing waits for what is resolved beside them.
    fn picture(&mut self) {
        let Passes { resolve, smooth, tone, .. } = *self.passes;
        let tiles = dispatch(offset_of!(Control, tile_groups));
        if !self.desc.settings.is_cel() {
            self.plan.step(resolve, tiles);
            return [smooth, tone].into_iter().for_each(|pass| self.plan.skip(pass, "look is \"light\""));
        }
        self.plan.step(smooth, tiles);
        match self.desc.keeps_depth() {
            true => self.plan.step(resolve, tiles),
            false => self.plan.skip(resolve, "look is \"cel\", and no layers or motion vectors are asked for"),
        }
        self.plan.step(tone, tiles);
    }

    /// Skips all that follows from particles where none can be seen.
    fn skip_fire(&mut self, reason: &'static str) {
        let Passes { scene, prepare, count, converge, light, resolve, smooth, tone, composite, .. } = self.passes;
        for pass in [scene, prepare, count, converge, light, resolve, smooth, tone] {
            self.plan.skip(*pass, reason);
        }
        let temporal = [self.passes.motion, self.passes.reactive].into_iter().flatten();
        temporal.chain([*composite]).chain(self.passes.embers).for_each(|pass| self.plan.skip(pass, reason));
    }

    fn background(&mut self, background: &Background) {
        match Command::background(background, BACKGROUND, TARGET, self.desc.size) {
            Some(command) => self.plan.step(self.passes.background, command),
            None => self.plan.skip(self.passes.background, "the target is kept"),
        }
    }

    fn particles(&mut self, frame: &Frame) {
        let Some(particles) = frame.particles.filter(|particles| particles.count > 0) else {
            return self.plan.skip(self.passes.particles, "unchanged, or none");
        };
        let count = u64::from(particles.count);
        let (from, to) = (HOST_POSITIONS, POSITIONS);
        self.plan.step(self.passes.particles, Command::CopyBuffer { from, to, bytes: 16 * count });
        if particles.ids.is_some() {
            let (from, to) = (HOST_IDS, IDS);
            self.plan.step(self.passes.particles, Command::CopyBuffer { from, to, bytes: 4 * count });
        }
        if let (Some(pass), Some(_)) = (self.passes.previous, particles.previous) {
            let (from, to) = (HOST_PREVIOUS, PREVIOUS);
            self.plan.step(pass, Command::CopyBuffer { from, to, bytes: 16 * count });
        }
        if let (Some(pass), Some(_)) = (self.passes.velocities, particles.velocity) {
            let (from, to) = (HOST_VELOCITIES, VELOCITIES);
            self.plan.step(pass, Command::CopyBuffer { from, to, bytes: 16 * count });
        }
    }

    /// Layers are whole images; the picture is one of them. Where no particle is prepared, none of an earlier frame, or of
    /// what the memory held before, is left in the list either.
    fn clear(&mut self) {
        if !self.desc.layers {
            return self.plan.skip(self.passes.clear, "no layers are kept");
        }
        let particles = self.delta.dark.map(|_| PARTICLES);
        let images = [PICTURE, MEAN, VARIANCE, HEAT_LAYER, TONE_LAYER];
        for buffer in images.into_iter().chain(particles) {
            self.plan.step(self.passes.clear, Command::Fill { buffer, word: 0 });
        }
        let word = f32::INFINITY.to_bits();
        self.plan.step(self.passes.clear, Command::Fill { buffer: NEAREST, word });
    }

    fn mask(&mut self) {
        let threads = [MASK_SIDE * MASK_SIDE * self.desc.settings.variants, 1, 1];
        self.plan.step(self.passes.mask, Command::Dispatch { threads });
        for level in 1..MASK_LEVELS {
            self.plan.step_with(self.passes.mips, Command::Dispatch { threads }, &MipsConstants { level });
        }
    }

    fn scene(&mut self, frame: &Frame) {
        let [width, height] = self.desc.size;
        let pixels = width * height;
        match (frame.scene, self.desc.scene) {
            (Some(SceneDepth::Buffer(_)), _) => {
                let (from, to, bytes) = (HOST_SCENE, SCENE, 4 * u64::from(pixels));
                self.plan.step(self.passes.scene_copy, Command::CopyBuffer { from, to, bytes });
            }
            (Some(SceneDepth::Image(_)), Some(SceneFormat::Image(made))) => {
                let (from, to, extent) = (HOST_DEPTH, SCENE_WORDS, self.desc.size);
                self.plan.step(self.passes.scene_copy, Command::CopyDepth { from, to, extent });
                let kind = words_of(made.format);
                let constants = SceneConstants { kind };
                self.plan.step_with(self.passes.scene, Command::Dispatch { threads: [pixels, 1, 1] }, &constants);
            }
            _ => self.plan.skip(self.passes.scene, "nothing else is in the scene"),
        }
    }

    /// Particles by tile and depth; and, beside it, the table of the expected image, where it is not that of this frame.
    fn lists(&mut self, frame: &Frame) {
        let particles = Command::Dispatch { threads: [self.delta.given.count, 1, 1] };
        let Passes { prepare, range, count, scan: [sums, add], fill, .. } = *self.passes;
        let cells = self.layout.size(CELLS);
        self.plan.step(prepare, particles);
        self.plan.step(range, particles);
        self.plan.step(count, particles);
        scan::step(self.plan, sums, cells);
        self.rebuild(frame);
        scan::step(self.plan, add, cells);
        self.table(self.passes.shares, offset_of!(KernelTable, share_groups));
        self.plan.step(fill, particles);
        self.table(self.passes.kernel, offset_of!(KernelTable, kernel_groups));
        if let Some(stage) = self.layout.stages.first() {
            let constants = self.parts_of(stage);
            let [sums, tiles] = self.passes.tiles;
            self.plan.step(sums, self.over_tiles());
            self.plan.step_with(tiles, self.over_tiles(), &constants);
        }
    }

    /// An invocation for each tile.
    fn over_tiles(&self) -> Command {
        Command::Dispatch { threads: [self.layout.tiles[0] * self.layout.tiles[1], 1, 1] }
    }

    /// Which classes of the table are missing.
    fn rebuild(&mut self, frame: &Frame) {
        let settings = &self.desc.settings;
        if !settings.is_expected() {
            return self.plan.skip(self.passes.kernel, "mode is \"stochastic\"");
        }
        // It is in spreads: nothing of it changes while sprites grow as their spread does. A cube is seen from another side
        // through another view.
        let turned = settings.shape == Shape::Cube && self.delta.view != Some(frame.view);
        let force = u32::from(self.delta.view.is_none() || turned || !self.delta.has_size);
        let once = one_group(&glsl::rebuild::SHADER);
        self.plan.step_with(self.passes.rebuild, once, &RebuildConstants { force });
    }

    /// A step that makes missing classes.
    fn table(&mut self, pass: PassId, member: usize) {
        if self.desc.settings.is_expected() {
            let command = Command::DispatchIndirect { arguments: KERNEL_STATE, offset: member as u64 };
            self.plan.step(pass, command);
        }
    }

    fn repetitions(&mut self) {
        if is_raster(self.desc) {
            return self.drawn(self.delta.given.before);
        }
        for (index, stage) in self.layout.stages.iter().enumerate() {
            if index > 0 {
                self.plan.step(self.passes.converge, dispatch(offset_of!(Control, active_groups)));
                let constants = self.parts_of(stage);
                let [sums, adapt] = self.passes.adapt;
                self.plan.step_with(sums, self.over_tiles(), &AdaptConstants { done: stage.first });
                self.plan.step_with(adapt, self.over_tiles(), &constants);
            }
            for (kernel, pass) in (0..).zip(&self.passes.accumulate) {
                for part in 0..stage.parts {
                    let argument = stage.arguments + kernel * stage.parts + part;
                    let offset = 16 * u64::from(argument);
                    let command = Command::DispatchIndirect { arguments: PART_ARGUMENTS, offset };
                    let constants = AccumulateConstants { part, first: stage.first, last: stage.last };
                    self.plan.step_with(*pass, command, &constants);
                }
            }
        }
    }

    fn parts_of(&self, stage: &Stage) -> PartsConstants {
        let Cost { base, visit, eighths } = Cost::new(self.desc);
        PartsConstants {
            budget: iterations(self.traits),
            base,
            visit,
            eighths,
            first: stage.arguments,
            parts: stage.parts,
            kernels: kernels(self.desc, self.traits),
            repetitions: stage.last - stage.first,
            done: stage.first,
        }
    }

    /// The paper's way: a render pass a repetition.
    fn drawn(&mut self, before: u32) {
        let particles = Command::Dispatch { threads: [self.delta.given.count, 1, 1] };
        self.passes.sprites.into_iter().for_each(|pass| self.plan.step(pass, particles));
        let [width, height] = self.desc.size;
        for repetition in before..before + self.desc.settings.repetitions {
            let sprites = draw(offset_of!(Control, sprite_draw));
            self.plan.step_with(self.passes.raster, sprites, &RasterConstants { repetition });
            let constants = AddConstants { is_first: u32::from(repetition == 0) };
            let threads = [width * height, 1, 1];
            self.plan.step_with(self.passes.add, Command::Dispatch { threads }, &constants);
        }
    }

    /// Outputs for temporal upscalers.
    fn temporal(&mut self, frame: &Frame) {
        let Passes { displacement, motion, reactive, .. } = *self.passes;
        let tiles = draw(offset_of!(Control, tile_draw));
        let moves = frame.particles.is_some_and(|particles| particles.previous.is_some());
        if let Some(pass) = displacement.filter(|_| moves) {
            let vertices = PARTICLE_VERTICES * self.delta.given.count;
            self.plan.step(pass, Command::Draw { vertices });
        }
        if let Some(pass) = motion {
            let before = self.delta.view_before.as_ref();
            self.plan.step_with(pass, tiles, &MotionConstants::new(before, &frame.view, self.desc.size, moves));
        }
        if let Some(pass) = reactive {
            self.plan.step(pass, tiles);
        }
    }

    /// The fire's light on the scene around it.
    fn light(&mut self) {
        if !self.desc.settings.lights() || self.desc.scene.is_none() {
            return self.plan.skip(self.passes.light, "light is 0, or nothing else is in the scene");
        }
        self.plan.step(self.passes.lamp, one_group(&glsl::light::SHADER));
        self.plan.step(self.passes.light, draw(offset_of!(Control, screen_draw)));
    }
}

/// A dispatch of a single workgroup.
fn one_group(shader: &Shader) -> Command {
    Command::Dispatch { threads: shader.local_size }
}

/// A dispatch whose groups the device has counted.
fn dispatch(member: usize) -> Command {
    Command::DispatchIndirect { arguments: CONTROL, offset: member as u64 }
}

/// A draw whose quads the device has counted.
fn draw(member: usize) -> Command {
    Command::DrawIndirect { arguments: CONTROL, offset: member as u64 }
}
