//! The settings of tones and ink.

use crate::error::{Error, Result, within};
use crate::shaders::toon::constants::MOST_TONES;
use crate::view::BRIGHTEST;

/// The operator that finds lines in the depth image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Operator {
    /// Diagonal differences (the paper's way, section 3.5).
    #[default]
    Roberts,
    /// Second differences: no false lines on slopes.
    Second,
}

impl Operator {
    /// Whether differences are second ones.
    pub(crate) fn is_second(self) -> bool {
        self == Operator::Second
    }
}

/// The ink line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Outline {
    /// Darkness w per squared depth step, >= 0; 1: a step of one voxel is black; 0 removes the line.
    pub strength: f32,
    /// Width in pixels, 1 to 16; 1 is the stencil alone.
    pub width: f32,
    /// Linear RGB, 0 to [`BRIGHTEST`].
    pub colour: [f32; 3],
    /// Which differences.
    pub operator: Operator,
}

impl Default for Outline {
    fn default() -> Self {
        Outline { strength: 1.0, width: 1.5, colour: [0.0; 3], operator: Operator::Roberts }
    }
}

impl Outline {
    /// Checks every value; `names` are the keys of strength, width and colour.
    pub(crate) fn validate(&self, names: [&'static str; 3]) -> Result<()> {
        within(names[0], self.strength, 0.0, 1e6, "0 (off) to 1e6")?;
        within(names[1], self.width, 1.0, 16.0, "pixels, 1 to 16")?;
        for c in self.colour {
            within(names[2], c, 0.0, BRIGHTEST, "linear RGB, 0 to 1e6")?;
        }
        Ok(())
    }
}

/// One tone: from luminance `from` upwards the colour is `colour`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(from = "(f32, [f32; 3])"))]
pub struct Tone {
    /// Luminance where the tone begins, 0 to 1, ascending; the first reads as 0.
    pub from: f32,
    /// Linear RGB, 0 to [`BRIGHTEST`].
    pub colour: [f32; 3],
}

impl From<(f32, [f32; 3])> for Tone {
    fn from((from, colour): (f32, [f32; 3])) -> Self {
        Tone { from, colour }
    }
}

/// Checks the tones of the key `name`.
pub(crate) fn validate_tones(name: &'static str, tones: &[Tone]) -> Result<()> {
    if tones.is_empty() || tones.len() > MOST_TONES as usize {
        return Err(Error::setting(name, format!("{} tones", tones.len()), "1 to 256 tones"));
    }
    for (i, tone) in tones.iter().enumerate() {
        if !(0.0..=1.0).contains(&tone.from) || (i > 0 && tone.from <= tones[i - 1].from) {
            return Err(Error::setting(name, tone.from, "luminances in 0 to 1, ascending"));
        }
        if tone.colour.iter().any(|c| !(0.0..=BRIGHTEST).contains(c)) {
            return Err(Error::setting(name, format!("{:?}", tone.colour), "linear RGB, 0 to 1e6"));
        }
    }
    Ok(())
}
