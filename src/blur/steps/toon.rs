//! Frames that are drawn in flat tones because the host has no images of them: their part of a plan.

use super::{Steps, There, drawn};
use crate::blur::desc::Desc;
use crate::blur::frame::{Drawn, Frame, ToonInput};
use crate::blur::layout::{HOST_BACKGROUND, PARAMS, TARGET, TOON_BUFFER};
use crate::blur::params::{BackgroundConstants, BlurParams, ToonParams, VisibilityConstants};
use crate::plan::Command;

/// Frames i - 1 to i + 2, as far as they are drawn because the host has no images of them.
pub(super) struct ToonFrames {
    /// Those that the output needs.
    frames: [Option<Drawn>; 4],
    /// Those of them that are not there since an earlier output.
    missing: [Option<Drawn>; 4],
    /// Frame i + 1.
    next: Drawn,
    input: ToonInput,
}

impl ToonFrames {
    /// Those that are missing, with their places among the four.
    fn missing(&self) -> impl Iterator<Item = (u32, Drawn)> + '_ {
        (0..).zip(self.missing).filter_map(|(index, drawn)| Some((index, drawn?)))
    }

    fn first(&self) -> Option<(u32, Drawn)> {
        self.missing().next()
    }

    /// Frames whose normals they need: i and i + 1, or all four.
    fn normals(&self) -> u32 {
        if self.missing[0].or(self.missing[3]).is_some() { 4 } else { 2 }
    }

    fn params(&self, desc: &Desc, drawn: &Drawn) -> ToonParams {
        ToonParams::new(desc, drawn.view(), &self.input.light)
    }

    /// What is there once they are drawn.
    pub(super) fn there(&self, before: There) -> There {
        let is_missing = self.first().is_some();
        There {
            is_projected: before.is_projected || is_missing,
            // Each frame is seen in the same place: what the last one has left is there.
            is_seen: self.missing[2].is_some() && self.missing[3].is_none(),
            has_normals: is_missing,
            ..before
        }
    }
}

impl Steps<'_> {
    /// Draws what the host has no images of, where nothing moves.
    pub(super) fn toon(&mut self, frame: &Frame) -> There {
        let Some(toon) = self.toon_frames(frame) else { return There::default() };
        if toon.first().is_some() {
            let params = BlurParams::of_views(self.desc, &[toon.input.view; 4], frame);
            self.plan.update(self.passes.params, PARAMS, &params);
        }
        self.begin_toon(&toon);
        if toon.first().is_some() {
            self.plan.step(self.passes.toon_project, Command::Dispatch { threads: [self.desc.points, 4, 1] });
        }
        self.see_toon(&toon);
        self.draw_toon(frame, &toon);
        toon.there(There::default())
    }

    /// Which frames are drawn, if the host has no images of them.
    pub(super) fn toon_frames(&self, frame: &Frame) -> Option<ToonFrames> {
        let frames = drawn(self.desc, frame);
        let (next, input) = (frames[2]?, frame.toon?);
        let is_there = |new: &Drawn| {
            self.drawn[new.place(self.desc)] == Some(*new) && frame.new_poses().all(|frame| frame != new.frame())
        };
        let missing = frames.map(|drawn| drawn.filter(|drawn| !(self.effort.skips() && is_there(drawn))));
        Some(ToonFrames { frames, missing, next, input })
    }

    /// What kernels are told of the first frame that is missing.
    pub(super) fn begin_toon(&mut self, toon: &ToonFrames) {
        for (wanted, missing) in toon.frames.iter().zip(&toon.missing) {
            if wanted.is_some() && missing.is_none() {
                self.plan.skip(self.passes.toon_params, "the frame is there since an earlier output");
            }
        }
        if let Some((_, first)) = toon.first() {
            self.begin_normals(toon.normals());
            self.plan.update(self.passes.toon_params, TOON_BUFFER, &toon.params(self.desc, &first));
        }
    }

    /// Which triangles it shows, and normals.
    pub(super) fn see_toon(&mut self, toon: &ToonFrames) {
        if let Some((index, _)) = toon.first() {
            self.normals(toon.normals());
            self.see_frame(index);
        }
    }

    /// The rest of it, and all of the others; then the target begins with frame i + 1.
    pub(super) fn draw_toon(&mut self, frame: &Frame, toon: &ToonFrames) {
        if let Some((index, first)) = toon.first() {
            self.large_normals();
            self.draw_frame(index, &first);
        }
        for (index, drawn) in toon.missing().skip(1) {
            self.plan.update(self.passes.toon_params, TOON_BUFFER, &toon.params(self.desc, &drawn));
            self.see_frame(index);
            self.draw_frame(index, &drawn);
        }
        if self.desc.depth.is_some() {
            return self.under(frame);
        }
        let constants = BackgroundConstants::new(frame.background, &frame.target);
        let begin = self.passes.toon_background[toon.next.place(self.desc)];
        self.plan.step_with(begin, Command::Draw { vertices: 4 }, &constants);
    }

    /// The background alone: what the host has drawn may hide the frame, which comes when its depth is known.
    fn under(&mut self, frame: &Frame) {
        let extent = self.desc.size;
        // Where there is none, nothing is behind.
        let command = Command::background(&frame.background, HOST_BACKGROUND, TARGET, extent);
        let command = command.unwrap_or(Command::Clear { image: TARGET, value: [0; 4], extent });
        self.plan.step(self.passes.under, command);
    }

    /// The triangles of a frame, of i - 1 to i + 2 that of this `index`.
    fn see_frame(&mut self, index: u32) {
        let vertices = 3 * self.desc.triangles;
        let constants = VisibilityConstants { frame: index };
        self.plan.step_with(self.passes.toon_see, Command::Draw { vertices }, &constants);
    }

    /// A frame whose triangles are known.
    fn draw_frame(&mut self, index: u32, drawn: &Drawn) {
        let [width, height] = self.desc.size;
        if self.desc.settings.toon.outline.is_on() {
            let samples = Command::Dispatch { threads: [2 * width, 2 * height, 1] };
            self.plan.step(self.passes.toon_lines, samples);
        }
        let pass = self.passes.toon[drawn.place(self.desc)];
        self.plan.step_with(pass, Command::Draw { vertices: 4 }, &VisibilityConstants { frame: index });
    }
}
