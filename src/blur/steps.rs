//! A frame's list: which passes run, over how much, in which order, and why others do not. Pure.

use crate::blur::limits::{CHOOSE_ROUNDS, DRAWN_PLACES, LIGHT_CANDIDATES, MOST_KNOTS, MOST_LINES, inward_dispatches};
use crate::effect::{DeviceTraits, Effort};
use std::mem::offset_of;
use std::ops::Range;

use bytemuck::Zeroable;

use crate::blur::desc::Desc;
use crate::blur::frame::{DepthInput, Drawn, Frame, FrameView, IntervalInput, Trajectories};
use crate::blur::layout::*;
use crate::blur::motion::ROW;
use crate::blur::params::{
    self, BackgroundConstants, BlurParams, ChooseConstants, Control, DIRECTIONS, DescribeConstants, GhostConstants,
    Knot, LINE_VERTICES, LightConstants, LinesConstants, NONE, NOTHING_SEEN, OccluderConstants, ROUNDS, Round,
    RoundConstants, SeamConstants, SettleConstants, ToneConstants, ToonParams, VisibilityConstants,
};
use crate::blur::parts::PartSizes;
use crate::blur::passes::Passes;
use crate::blur::settings::{Completion, MOST_TEETH, Settings};
use crate::host::{Background, words_of};
use crate::plan::{Command, PassId, Plan, Shader};
use crate::shaders::blur as glsl;
use crate::view::Projection;

mod inputs;
mod temporal;
mod toon;

use toon::ToonFrames;

/// Fills a frame's plan.
pub struct Steps<'a> {
    /// To be filled.
    pub plan: &'a mut Plan,
    /// The effect's passes.
    pub passes: &'a Passes,
    /// The description that it is made for.
    pub desc: &'a Desc,
    /// Its sizes.
    pub layout: &'a Layout,
    /// The traits of the device.
    pub traits: &'a DeviceTraits,
    /// How much of its work is done.
    pub effort: Effort,
    /// Frames that are drawn already, each in its place.
    pub drawn: &'a [Option<Drawn>; DRAWN_PLACES],
}

/// The data of frame i + 1 that the device has.
#[derive(Clone, Copy, Debug, Default)]
struct There {
    /// Parameters and clip coordinates.
    is_projected: bool,
    /// The output's view of the mesh, at four samples a pixel.
    is_seen: bool,
    /// Its coverage of pixels.
    is_composed: bool,
    /// Normals, and those of frame i.
    has_normals: bool,
    /// The objects that samples see, if layers are kept.
    has_objects: bool,
}

/// Why an output is the image of frame i + 1, if that is known before the device has looked.
pub fn still(desc: &Desc, frame: &Frame) -> Option<&'static str> {
    match &frame.interval {
        None => Some("nothing moves"),
        Some(interval) if interval.counts.clusters == 0 => Some("nothing moves"),
        Some(_) if !desc.settings.smears() && !desc.settings.draws_behind() => Some("strength is 0"),
        Some(_) if desc.triangles == 0 => Some("the mesh has no triangles"),
        Some(_) => None,
    }
}

/// Frames i - 1 to i + 2 where an output needs them and the host has no images of them.
pub fn drawn(desc: &Desc, frame: &Frame) -> [Option<Drawn>; 4] {
    let [before, previous, next, after] = frame.drawn(desc);
    let [before, previous, after] =
        [before, previous, after].map(|drawn| drawn.filter(|_| still(desc, frame).is_none()));
    [before, previous, next, after]
}

impl Steps<'_> {
    /// Fills it.
    pub fn fill(&mut self, frame: &Frame) {
        let extent = self.desc.size;
        let has_image_behind = matches!(frame.background, Background::Copy(_));
        if has_image_behind {
            self.plan.step(self.passes.behind, Command::CopyImage { from: HOST_BACKGROUND, to: BACKGROUND, extent });
        }
        if frame.images.is_some() {
            self.plan.skip(self.passes.toon_params, "images are given");
            let from = HOST_FRAMES[1];
            if has_image_behind {
                self.plan.step(self.passes.frame_behind, Command::CopyImage { from, to: FRAMES[1], extent });
                let constants = BackgroundConstants::new(frame.background, &frame.target);
                self.plan.step_with(self.passes.frame_background, Command::Draw { vertices: 4 }, &constants);
            } else {
                self.plan.step(self.passes.background, Command::CopyImage { from, to: TARGET, extent });
            }
        }
        match &frame.mesh {
            Some(mesh) => {
                self.mesh();
                self.groups();
                self.colours(mesh);
                self.shares(mesh);
                self.parts(mesh);
            }
            None => self.plan.skip(self.passes.mesh, "unchanged"),
        }
        if frame.new_poses().next().is_none() {
            self.plan.skip(self.passes.poses, "none are new");
        }
        frame.poses.iter().for_each(|poses| self.poses(poses));
        frame.skinned.iter().for_each(|skinned| self.gather(skinned));
        let still = still(self.desc, frame);
        let Some(interval) = frame.interval.as_ref().filter(|_| still.is_none()) else {
            let reason = still.unwrap_or_default();
            self.skip_motion(reason);
            self.skip_picture(reason);
            let there = self.toon(frame);
            return self.depth(frame, there);
        };
        let [before, _, _, after] = drawn(self.desc, frame);
        let outer = [frame.outer[0].is_some() || before.is_some(), frame.outer[1].is_some() || after.is_some()];
        let mut params = BlurParams::new(self.desc, self.layout, interval, frame, outer);
        if !self.effort.skips() {
            params.is_whole = 1;
        }
        self.plan.update(self.passes.params, PARAMS, &params);
        self.plan.update(self.passes.params, CONTROL, &Control::reset());
        self.plan.update_slice(self.passes.params, ROUND_LIST, &params::rounds(self.desc));
        self.interval(interval);
        self.clears(frame, interval);
        self.knots(interval);
        let toon = self.toon_frames(frame);
        toon.iter().for_each(|toon| self.begin_toon(toon));
        self.plan.step(self.passes.project, Command::Dispatch { threads: [self.desc.points, 4, 1] });
        self.heads();
        self.trajectory(interval);
        toon.iter().for_each(|toon| self.see_toon(toon));
        self.settle(frame, interval, toon.as_ref());
        let projected = There { is_projected: true, ..There::default() };
        let there = toon.map_or(projected, |toon| toon.there(projected));
        self.refine();
        self.frames(frame, outer);
        self.draw(frame, &interval.views, outer);
        if !self.desc.settings.smears() {
            // The target has frame i + 1, and only what is behind the mesh is missing.
            self.skip_picture("strength is 0");
        } else {
            self.tiles(frame);
            self.learn(frame, there);
            self.shade(frame);
        }
        self.ghosts();
        self.lines(interval);
        let is_composed = self.desc.settings.smears();
        self.depth(frame, There { is_seen: true, is_composed, has_objects: true, ..there });
    }

    /// Skips all that follows from motion where nothing moves.
    fn skip_motion(&mut self, reason: &'static str) {
        let Passes { params, interval, trajectory, extent, seams, begin, visibility: [visibility, _], .. } =
            self.passes;
        let Passes { distort: [distort, _], layers, frames, ghost, lines, scenes, .. } = self.passes;
        for pass in [
            scenes, params, interval, trajectory, extent, seams, begin, visibility, distort, layers, frames, ghost,
            lines,
        ] {
            self.plan.skip(*pass, reason);
        }
    }

    /// Skips the passes of the smeared picture there, too, and where the picture is frame i + 1's.
    fn skip_picture(&mut self, reason: &'static str) {
        let Passes { tiles, cover, normals, learn, tone, shade, border: [border, _], compose, composite, .. } =
            self.passes;
        let ink = self.passes.ink.iter();
        for pass in [tiles, cover, normals, learn, tone, shade, border, compose, composite].into_iter().chain(ink) {
            self.plan.skip(*pass, reason);
        }
        self.skip_temporal(reason);
    }

    /// After-images, the earliest first.
    fn ghosts(&mut self) {
        let ghosts = self.desc.settings.ghosts;
        if !ghosts.are_on() {
            return self.plan.skip(self.passes.ghost, "none are asked for");
        }
        for ghost in (1..=ghosts.count).rev() {
            let constants = GhostConstants::new(&self.desc.settings, ghost, self.desc.size[1]);
            let draw = Command::DrawIndirect { arguments: CONTROL, offset: offset_of!(Control, draw) as u64 };
            self.plan.step_with(self.passes.ghost, draw, &constants);
            self.plan.step_with(self.passes.ghost_blend, Command::Draw { vertices: 4 }, &constants);
        }
    }

    /// Speed lines of each cluster.
    fn strips(&self, interval: &IntervalInput) -> u32 {
        let lines = self.desc.settings.lines;
        if lines.are_on() { lines.count.min(MOST_LINES / interval.counts.clusters) } else { 0 }
    }

    /// Speed lines.
    fn lines(&mut self, interval: &IntervalInput) {
        let lines = self.desc.settings.lines;
        if !lines.are_on() {
            return self.plan.skip(self.passes.lines, "none are asked for");
        }
        let (clusters, strips) = (interval.counts.clusters, self.strips(interval));
        if strips == 0 {
            return self.plan.skip(self.passes.lines, "there are too many clusters");
        }
        for round in 0..CHOOSE_ROUNDS {
            let constants = ChooseConstants { round, strips, variation: lines.variation };
            self.plan.step_with(self.passes.lines_choose, self.points(), &constants);
        }
        let [r, g, b] = lines.colour;
        let constants = LinesConstants {
            colour: [r, g, b, lines.opacity],
            length_of: lines.length,
            width: Settings::scaled(lines.width, self.desc.size[1]),
            variation: lines.variation,
        };
        let vertices = LINE_VERTICES * clusters * strips;
        self.plan.step_with(self.passes.lines, Command::Draw { vertices }, &constants);
    }

    /// Depth of the mesh in the output, for what is behind it.
    fn depth(&mut self, frame: &Frame, there: There) {
        let (Some(input), Some(pass)) = (&frame.depth, self.passes.depth) else {
            return self.plan.skip(self.passes.depth_params, "the host has no depth");
        };
        if !there.is_composed {
            self.surface(frame, input, there);
            if let Some(drawn) = drawn(self.desc, frame)[2] {
                let shown = self.passes.toon_background_depth[drawn.place(self.desc)];
                self.plan.step(shown, Command::Draw { vertices: 4 });
            }
        }
        self.plan.step(pass, Command::Draw { vertices: 4 });
    }

    /// The mesh's coverage of image i + 1.
    fn surface(&mut self, frame: &Frame, input: &DepthInput, there: There) {
        let Desc { size: [width, height], triangles, points, .. } = *self.desc;
        if !there.is_projected {
            let params = BlurParams::of_views(self.desc, &[input.view; 4], frame);
            self.plan.update(self.passes.depth_params, PARAMS, &params);
            self.plan.step(self.passes.depth_project, Command::Dispatch { threads: [points, 4, 1] });
        }
        if !there.is_seen {
            let constants = VisibilityConstants { frame: 2 };
            self.plan.step_with(self.passes.depth_see, Command::Draw { vertices: 3 * triangles }, &constants);
        }
        let (pass, from, background) = match drawn(self.desc, frame)[2] {
            Some(drawn) => (self.passes.depth_frame[1], TOON[drawn.place(self.desc)], frame.background),
            None => (self.passes.depth_frame[0], HOST_FRAMES[1], Background::Keep),
        };
        self.plan.step(pass, Command::CopyImage { from, to: FRAMES[1], extent: self.desc.size });
        let pixels = Command::Dispatch { threads: [width, height, 1] };
        if self.desc.layers && !there.has_objects {
            self.plan.step(self.passes.objects[0], pixels);
        }
        self.plan.step_with(self.passes.surface, pixels, &BackgroundConstants::new(background, &frame.target));
    }

    /// Which points of the parts move, and how.
    fn measure(&mut self) {
        let Some(PartSizes { parts, chunks, .. }) = self.desc.parts else { return };
        let [measure, support, outline, describe] = self.passes.measure[..] else { return };
        let settings = &self.desc.settings;
        self.plan.step(measure, self.points());
        let groups = |count| Command::Dispatch { threads: [DIRECTIONS * count, 1, 1] };
        self.plan.step(support, groups(chunks));
        self.plan.step(outline, groups(chunks));
        let constants = DescribeConstants {
            teeth: settings.teeth.unwrap_or(0),
            most_teeth: MOST_TEETH,
            tooth: Settings::scaled(settings.tooth_width(), self.desc.size[1]),
            row: if !self.passes.rows.is_empty() { Settings::scaled(ROW, self.desc.size[1]) } else { 0.0 },
        };
        self.plan.step_with(describe, groups(parts), &constants);
        if let [rows, mean] = self.passes.rows[..] {
            self.plan.step(rows, self.points());
            self.plan.step(mean, Command::Dispatch { threads: [glsl::rows_mean::SHADER.local_size[0] * parts, 1, 1] });
        }
    }

    fn points(&self) -> Command {
        Command::Dispatch { threads: [self.desc.points, 1, 1] }
    }

    /// What kernels add to begins empty: all of it first, so that nothing waits for it later.
    fn clears(&mut self, frame: &Frame, interval: &IntervalInput) {
        if self.strips(interval) > 0 {
            self.plan.step(self.passes.lines_begin, Command::Fill { buffer: TRAILING, word: NONE });
        }
        if !self.desc.settings.smears() {
            return;
        }
        self.plan.step(self.passes.tiles_begin, Command::Fill { buffer: TILES, word: 0 });
        self.plan.step(self.passes.tiles_begin, Command::Fill { buffer: SAMPLE_STATES, word: NOTHING_SEEN });
        self.plan.step(self.passes.completing, Command::Fill { buffer: COMPLETING, word: 0 });
        if self.learns(frame) {
            self.plan.step(self.passes.sums, Command::Fill { buffer: SUMS, word: 0 });
        }
    }

    /// What stands before that, once it is empty.
    fn heads(&mut self) {
        if !self.desc.settings.smears() {
            return;
        }
        let mut head = [0; TILE_WORDS];
        for (kind, workgroups) in [1, 2, 4].into_iter().enumerate() {
            head[tile_dispatch(kind) + 2] = workgroups;
        }
        self.plan.update_slice(self.passes.tiles_begin, TILES, &head);
        self.plan.update_slice(self.passes.completing, COMPLETING, &params::completing(self.desc));
    }

    fn knots(&mut self, interval: &IntervalInput) {
        match interval.trajectories {
            Trajectories::Poses(knots) => {
                let mut rows = [Knot::zeroed(); MOST_KNOTS];
                rows.iter_mut().zip(knots).for_each(|(row, knot)| *row = Knot::new(knot, &interval.views, self.desc));
                self.plan.update_slice(self.passes.knots, KNOTS, &rows[..knots.len()]);
            }
            Trajectories::Pieces(_) => {
                let piece = size_of::<params::Piece>() as u64;
                let bytes = u64::from(self.desc.points) * piece;
                for segment in 0..interval.segments.len() as u64 {
                    let to = segment * u64::from(self.layout.vertices) * piece;
                    let command =
                        Command::CopyRange { from: (HOST_INTERVAL[6], segment * bytes), to: (SPLINES, to), bytes };
                    self.plan.step(self.passes.pieces, command);
                }
            }
        }
    }

    fn trajectory(&mut self, interval: &IntervalInput) {
        if matches!(interval.trajectories, Trajectories::Poses(_)) {
            self.plan.step(self.passes.trajectory, self.points());
        }
        self.measure();
        self.plan.step(self.passes.extent, self.points());
    }

    /// How far points are distorted; beside it, frames are drawn: neither waits for the other.
    fn settle(&mut self, frame: &Frame, interval: &IntervalInput, toon: Option<&ToonFrames>) {
        let seams = interval.counts.seams;
        let rounds = if seams > 0 { self.desc.settings.seam_smoothing } else { 0 };
        self.smooth(seams, 0..rounds.min(1));
        toon.into_iter().for_each(|toon| self.draw_toon(frame, toon));
        self.smooth(seams, 1..rounds);
        if rounds == 0 {
            self.plan.skip(self.passes.seams, "no clusters meet, or seam_smoothing is 0");
        }
        self.plan.step_with(self.passes.settle, self.points(), &SettleConstants { from: rounds % 2 });
    }

    /// Rounds of smoothing at so many points where clusters meet.
    fn smooth(&mut self, seams: u32, rounds: Range<u32>) {
        for round in rounds {
            let command = Command::Dispatch { threads: [seams, 1, 1] };
            self.plan.step_with(self.passes.seams, command, &SeamConstants { from: round % 2 });
        }
    }

    fn refine(&mut self) {
        let triangles = Command::Dispatch { threads: [self.desc.triangles, 1, 1] };
        self.plan.step(self.passes.begin, triangles);
        for round in 0..=ROUNDS {
            let constants = RoundConstants { round };
            let offset = u64::from(round) * size_of::<Round>() as u64 + offset_of!(Round, groups) as u64;
            let groups = Command::DispatchIndirect { arguments: ROUND_LIST, offset };
            let parity = (round % 2) as usize;
            self.plan.step_with(self.passes.count[parity], groups, &constants);
            self.plan.step_with(self.passes.emit[parity], groups, &constants);
        }
    }

    /// The mesh in frame i - 1 (0) to i + 2 (3), behind what the host has drawn before it.
    fn see(&mut self, frame: &Frame, views: &[FrameView; 4], index: usize) {
        let [[before, after], [previous, next]] = [self.passes.outer_visibility, self.passes.visibility];
        let mut pass = [before, previous, next, after][index];
        if let (Some(_), Some(made)) = (frame.occluders[index], self.desc.occluders) {
            let extent = self.desc.size;
            let copy = Command::CopyDepth { from: HOST_SCENES[index], to: SCENE_WORDS, extent };
            self.plan.step(self.passes.scenes, copy);
            let terms = Projection::of_valid(&views[index].view, extent).terms();
            let constants = OccluderConstants { terms, kind: words_of(made.format) };
            self.plan.step_with(self.passes.occluders[index], Command::Draw { vertices: 4 }, &constants);
            pass = self.passes.hidden_visibility[index];
        }
        let command = Command::Draw { vertices: 3 * self.desc.triangles };
        self.plan.step_with(pass, command, &VisibilityConstants { frame: index as u32 });
    }

    fn draw(&mut self, frame: &Frame, views: &[FrameView; 4], outer: [bool; 2]) {
        if self.desc.occluders.is_none() {
            self.plan.skip(self.passes.scenes, "images come without depth");
        }
        let outer = [0, 3].into_iter().zip(outer).filter(|(_, is_there)| *is_there);
        for index in [1, 2].into_iter().chain(outer.map(|(index, _)| index)) {
            self.see(frame, views, index);
        }
        let draw = Command::DrawIndirect { arguments: CONTROL, offset: offset_of!(Control, draw) as u64 };
        for pass in self.passes.distort {
            self.plan.step(pass, draw);
        }
        if !self.desc.layers {
            return self.plan.skip(self.passes.layers, "no layers are kept");
        }
        let [width, height] = self.desc.size;
        let pixels = Command::Dispatch { threads: [width, height, 1] };
        self.plan.step(self.passes.layers, pixels);
        self.plan.step(self.passes.objects[1], pixels);
    }

    fn frames(&mut self, frame: &Frame, outer: [bool; 2]) {
        let [before, previous, next, after] = drawn(self.desc, frame);
        for ((from, to), drawn) in HOST_FRAMES.into_iter().zip(FRAMES).zip([previous, next]) {
            let (pass, from) = match drawn {
                Some(drawn) => (self.passes.toon_frames, TOON[drawn.place(self.desc)]),
                None => (self.passes.frames, from),
            };
            self.plan.step(pass, Command::CopyImage { from, to, extent: self.desc.size });
        }
        for i in [0, 1].into_iter().filter(|i| outer[*i]) {
            let (pass, from) = match [before, after][i] {
                Some(drawn) => (self.passes.toon_outer_frames[i], TOON[drawn.place(self.desc)]),
                None => (self.passes.outer_frames[i], HOST_OUTER[i]),
            };
            self.plan.step(pass, Command::CopyImage { from, to: OUTER_FRAMES[i], extent: self.desc.size });
        }
    }

    /// No group of normals, of frames i and i + 1, or of all four, has many triangles yet.
    fn begin_normals(&mut self, frames: u32) {
        let none: [u32; LARGE_WORDS] = [0, frames, 1, 0];
        self.plan.update_slice(self.passes.large_groups, LARGE_GROUPS, &none);
    }

    fn normals(&mut self, frames: u32) {
        self.plan.step(self.passes.normals, Command::Dispatch { threads: [self.desc.groups, frames, 1] });
    }

    fn large_normals(&mut self) {
        self.plan.step(self.passes.normals_large, Command::DispatchIndirect { arguments: LARGE_GROUPS, offset: 0 });
    }

    /// A dispatch over tiles, of one, two or four workgroups each.
    fn over_tiles(kind: usize) -> Command {
        Command::DispatchIndirect { arguments: TILES, offset: 4 * tile_dispatch(kind) as u64 }
    }

    /// So many workgroups.
    fn groups_of(shader: &Shader, count: u32) -> Command {
        Command::Dispatch { threads: [shader.local_size[0] * count, 1, 1] }
    }

    /// Which tiles are worked on; what the others have is nothing. And where ink is on them.
    fn tiles(&mut self, frame: &Frame) {
        let [width, height] = self.desc.size;
        if let Some((_, input)) = self.shade_drawn(frame).zip(frame.toon.as_ref()) {
            let params = ToonParams::new(self.desc, &input.view, &input.light);
            self.plan.update(self.passes.shade_params, TOON_BUFFER, &params);
        }
        self.plan.step(self.passes.tiles, Command::Dispatch { threads: [width, height, 1] });
        match (self.passes.ink, frame.images) {
            (Some(lines), None) => self.plan.step(lines, Self::over_tiles(2)),
            (Some(lines), Some(_)) => self.plan.skip(lines, "images have their own"),
            (None, _) => {}
        }
    }

    /// The pass that knows what frames that are drawn hide, if they are.
    fn shade_drawn(&self, frame: &Frame) -> Option<PassId> {
        self.passes.shade_drawn.filter(|_| frame.images.is_none())
    }

    /// Whether colours of completion are learned.
    fn learns(&self, frame: &Frame) -> bool {
        self.shade_drawn(frame).is_none() && self.layout.tables > 0
    }

    fn learn(&mut self, frame: &Frame, there: There) {
        self.plan.step(self.passes.cover, Self::over_tiles(0));
        let is_drawn = self.shade_drawn(frame).is_some();
        match is_drawn || self.layout.tables > 0 {
            true if there.has_normals => {}
            true => {
                self.begin_normals(2);
                self.normals(2);
                self.large_normals();
            }
            false => self.plan.skip(self.passes.normals, "completion does not follow from the surface"),
        }
        if !self.learns(frame) {
            let reason = match is_drawn {
                true => "what drawn frames hide can be drawn",
                false => "completion does not follow from the surface",
            };
            return [self.passes.learn, self.passes.tone].into_iter().for_each(|pass| self.plan.skip(pass, reason));
        }
        let pixels = Self::over_tiles(1);
        self.plan.step(self.passes.learn, pixels);
        self.plan.step(self.passes.fill, Self::groups_of(&glsl::fill::SHADER, 2 * self.layout.tables));
        self.plan.step(self.passes.pairs, pixels);
        for (round, candidates) in (0..).zip(LIGHT_CANDIDATES) {
            let command = Self::groups_of(&glsl::light::SHADER, candidates);
            self.plan.step_with(self.passes.light, command, &LightConstants { round });
        }
        for (is_own, groups) in [(0, 1), (1, self.layout.tables)] {
            let command = Self::groups_of(&glsl::tone::SHADER, groups);
            self.plan.step_with(self.passes.tone, command, &ToneConstants { is_own });
        }
    }

    /// Samples that get their colour from neighbours: no group runs where there are none.
    fn inward(&mut self, gradient: usize) {
        let at = |word: usize| Command::DispatchIndirect { arguments: COMPLETING, offset: 4 * word as u64 };
        self.plan.step(self.passes.border[gradient], at(params::border_dispatch(gradient)));
        for _ in 0..inward_dispatches(self.traits)[gradient] {
            self.plan.step(self.passes.inward[gradient], at(params::inward_dispatch(gradient)));
        }
    }

    fn shade(&mut self, frame: &Frame) {
        let pass = self.shade_drawn(frame).unwrap_or(self.passes.shade);
        self.plan.step(pass, Self::over_tiles(2));
        if self.desc.layers {
            let [width, height] = self.desc.size;
            self.plan.step(self.passes.sides, Command::Dispatch { threads: [width, height, 1] });
        }
        if self.desc.settings.completion == Completion::Gradient {
            self.inward(1);
        }
        self.inward(0);
        self.plan.step(self.passes.compose, Self::over_tiles(0));
        self.temporal(frame);
        let draw = Command::Draw { vertices: 4 };
        self.plan.step(self.passes.composite, draw);
    }
}
