//! Common parts of cel-shaded effects: flat tones and the ink line.

pub mod settings;

pub use settings::{Operator, Outline, Tone};

/// How far a line of a width reaches from its middle, in whole pixels or samples as the width is.
pub(crate) fn ink_reach(width: f32) -> u32 {
    width.ceil() as u32 - 1
}
