//! Outputs for temporal upscalers.

use super::Steps;
use crate::blur::frame::{Frame, FrameView};
use crate::blur::params::BeforeConstants;
use crate::plan::Command;

impl Steps<'_> {
    /// Motion vectors and reactive mask of the mesh in this interval, while the host's depth still decides where it is seen.
    pub(super) fn temporal(&mut self, frame: &Frame) {
        let draw = Command::Draw { vertices: 4 };
        if let (Some(pass), Some(interval)) = (self.passes.motion, &frame.interval) {
            self.plan.step_with(pass, draw, &BeforeConstants::new(&interval.views));
        }
        if let Some(pass) = self.passes.reactive {
            self.plan.step(pass, draw);
        }
    }

    /// Skips both.
    pub(super) fn skip_temporal(&mut self, reason: &'static str) {
        let passes = [self.passes.motion, self.passes.reactive].into_iter().flatten();
        passes.for_each(|pass| self.plan.skip(pass, reason));
    }
}

impl BeforeConstants {
    /// What is said of frame i - 1. It is the one before frame i, or none if nothing is.
    fn new([before, previous, next, _]: &[FrameView; 4]) -> BeforeConstants {
        let jitter_change = [0, 1].map(|axis| (next.view.jitter[axis] - before.view.jitter[axis]) as f32);
        let has_before = before.frame.checked_add(1) == Some(previous.frame);
        BeforeConstants { jitter_change, has_before: has_before.into() }
    }
}
