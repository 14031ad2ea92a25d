//! The settings of tones and ink.

use crate::error::{Error, Result};
use crate::settings::{Number, Rule, Setting, settings, three, words};
use crate::shaders::toon::constants::MOST_TONES;
use crate::view::BRIGHTEST;

/// What a step may count at most.
pub(crate) const STRONGEST: f32 = 1e6;
/// The broadest line, in pixels.
pub(crate) const BROADEST: f32 = 16.0;

words! {
    /// The operator that finds lines in the depth image.
    pub enum Operator {
        /// Diagonal differences (the paper's way, section 3.5).
        #[default]
        Roberts = "roberts",
        /// Second differences: no false lines on slopes.
        Second = "second",
    }
}

impl Operator {
    /// Whether differences are second ones.
    pub(crate) fn is_second(self) -> bool {
        self == Operator::Second
    }
}

settings! {
    /// The ink line.
    #[derive(Copy)]
    pub struct Outline {
        /// How dark a step in depth is, per its square.
        strength: f32 = 1.0, "", 0.0..=STRONGEST, "off";
        /// How broad the line is; 1 is the thinnest.
        width: f32 = 1.5, "pixels", 1.0..=BROADEST;
        /// What it is drawn with.
        colour: [f32; 3] = [0.0; 3], "linear [red, green, blue]", 0.0..=BRIGHTEST;
        /// Which differences of depth make a line; "second" ones make no false lines on slopes.
        operator: Operator = Operator::default();
    }
}

impl Outline {
    /// Whether there is a line.
    pub fn is_on(&self) -> bool {
        self.strength > 0.0
    }
}

settings! {
    /// A line along a silhouette.
    #[derive(Copy)]
    pub struct Line {
        /// Its opacity.
        strength: f32 = 1.0, "", 0.0..=1.0, "off";
        /// How broad it is; 1 is the thinnest.
        width: f32 = 1.5, "pixels", 1.0..=BROADEST;
        /// What it is drawn with.
        colour: [f32; 3] = [0.045, 0.002, 0.004], "linear [red, green, blue]", 0.0..=BRIGHTEST;
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

impl Setting for Vec<Tone> {
    type Rule = ();

    fn check(&self, key: &str, (): &()) -> Result<()> {
        let refuse = |value: String, allowed: &str| Err(Error::setting(key.to_owned(), value, allowed));
        if self.is_empty() || self.len() > MOST_TONES as usize {
            return refuse(format!("{} tones", self.len()), &format!("1 to {MOST_TONES} tones"));
        }
        for (i, tone) in self.iter().enumerate() {
            if !(0.0..=1.0).contains(&tone.from) || (i > 0 && tone.from <= self[i - 1].from) {
                return refuse(tone.from.to_string(), "luminances in 0 to 1, ascending");
            }
            tone.colour.check(key, &Rule::new("linear RGB", 0.0..=BRIGHTEST))?;
        }
        Ok(())
    }

    fn allowed((): &()) -> String {
        format!(
            "[[from, [red, green, blue]], ...], 1 to {MOST_TONES} tones, from 0 to 1 ascending (the first reads as 0), linear \
             colours 0 to {}, or an image file (.png, .exr), whose first row they are",
            Number::shown(BRIGHTEST)
        )
    }

    fn shown(&self) -> Option<String> {
        let one = |tone: &Tone| format!("[{}, {}]", Number::shown(tone.from), three(tone.colour));
        Some(format!("[{}]", self.iter().map(one).collect::<Vec<_>>().join(", ")))
    }
}
