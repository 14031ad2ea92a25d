//! The settings of the smoke's ink line.

use crate::settings::{settings, words};
use crate::shaders::smoke::constants::{PIECE_REACH, TRACE_REACH};
use crate::toon::settings::{BROADEST, STRONGEST};
use crate::toon::{Scale, ink_reach};
use crate::view::BRIGHTEST;

/// The most that a line can be asked to reach over, in pixels at 1080 lines.
const LONGEST: f32 = 64.0;

words! {
    /// How lines are found in the depth image.
    pub enum Operator {
        /// Steps, seen from their nearer side, that are high enough or go on from one that is: black or nothing.
        #[default]
        Step = "step",
        /// Squares of diagonal differences (the paper's way, section 3.5).
        Roberts = "roberts",
        /// Squares of second differences: no false lines on slopes.
        Second = "second",
    }
}

settings! {
    /// A kind of line. What is not given is that of all lines.
    #[derive(Copy)]
    pub struct Line {
        /// Of a silhouette: its opacity. Of an inner line: as of all.
        strength: Option<f32> = None, "", 0.0..=STRONGEST, "off";
        /// How broad it is.
        width: Option<f32> = None, "pixels at 1080 lines", 1.0..=BROADEST;
        /// What it is drawn with.
        colour: Option<[f32; 3]> = None, "linear [red, green, blue]", 0.0..=BRIGHTEST;
    }
}

settings! {
    /// The ink line.
    #[derive(Copy)]
    pub struct Outline {
        /// What steps in depth count: with 1, a step of a voxel is a line. The other operators darken by its square.
        strength: f32 = 1.0, "", 0.0..=STRONGEST, "off";
        /// How broad the line is; at least a pixel of the picture.
        width: f32 = 3.0, "pixels at 1080 lines", 1.0..=BROADEST;
        /// What it is drawn with.
        colour: [f32; 3] = [0.0; 3], "linear [red, green, blue]", 0.0..=BRIGHTEST;
        /// What makes a line: a "step" in depth is black or nothing; "roberts" and "second" differences fade.
        operator: Operator = Operator::default();
        /// Of steps: how much thinner a line is where the step is low, as towards its ends.
        taper: f32 = 0.5, "share of the width", 0.0..=1.0;
        /// Of steps: how far a line goes on along steps that are too low to begin one. No more counts than 16 pixels of the
        /// picture.
        follow: f32 = 16.0, "pixels at 1080 lines", 0.0..=LONGEST, "nowhere";
        /// Of steps: lines that do not reach over so much go. No more counts than 13 pixels of the picture.
        shortest: f32 = 16.0, "pixels at 1080 lines", 0.0..=LONGEST, "all stay";
        /// The line around the smoke.
        silhouette: Line = Line::default();
        /// Lines within the smoke.
        inner: Line = Line::default();
    }
}

/// A kind of line as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawn {
    pub(crate) strength: f32,
    /// In pixels.
    pub(crate) width: f32,
    /// Linear RGB.
    pub(crate) colour: [f32; 3],
}

impl Outline {
    /// Whether there is a line.
    pub fn is_on(&self) -> bool {
        self.silhouettes().strength > 0.0 || self.inner_lines().strength > 0.0
    }

    /// Whether lines are steps, black or nothing.
    pub(crate) fn is_hard(&self) -> bool {
        self.operator == Operator::Step
    }

    /// With sizes in pixels of a picture. Lines are as broad as a pixel at least, and what is
    /// looked at along them has an end.
    pub(super) fn scaled(&self, scale: Scale) -> Outline {
        let width = |width: f32| scale.line(width);
        let line = |line: &Line| Line { width: line.width.map(width), ..*line };
        Outline {
            width: width(self.width),
            follow: scale.size(self.follow).min(TRACE_REACH as f32),
            shortest: scale.size(self.shortest).min(PIECE_REACH as f32),
            silhouette: line(&self.silhouette),
            inner: line(&self.inner),
            ..*self
        }
    }

    /// Silhouettes; strength is their opacity.
    pub(crate) fn silhouettes(&self) -> Drawn {
        let opacity = if self.strength > 0.0 { 1.0 } else { 0.0 };
        let drawn = self.drawn(&self.silhouette, opacity);
        Drawn { strength: drawn.strength.min(1.0), ..drawn }
    }

    /// Lines within the smoke.
    pub(crate) fn inner_lines(&self) -> Drawn {
        self.drawn(&self.inner, self.strength)
    }

    /// Pixels from which a line can reach a pixel.
    pub(crate) fn reach(&self) -> u32 {
        ink_reach(self.silhouettes().width.max(self.inner_lines().width))
    }

    /// Pixels that a line goes on.
    pub(crate) fn trace_reach(&self) -> u32 {
        self.follow.round() as u32
    }

    /// Pixels along a line that are looked at: a straight one of the least length is known from each of its pixels.
    pub(crate) fn piece_reach(&self) -> u32 {
        self.shortest.ceil() as u32
    }

    fn drawn(&self, line: &Line, strength: f32) -> Drawn {
        Drawn {
            strength: line.strength.unwrap_or(strength),
            width: line.width.unwrap_or(self.width),
            colour: line.colour.unwrap_or(self.colour),
        }
    }
}
