//! The settings of tones and ink.

use crate::error::{Error, Result};
use crate::settings::{Number, Rule, Setting, listed_in_brackets, settings, words};
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
        /// The nearer sides of steps, by second differences: a line is there or not.
        Step = "step",
    }
}

impl Operator {
    /// As specialisation constants: whether differences are second ones, whether lines are the nearer sides of steps.
    pub(crate) fn words(self) -> [u32; 2] {
        [Operator::Second, Operator::Step].map(|operator| u32::from(self == operator))
    }
}

settings! {
    /// The ink line.
    #[derive(Copy)]
    pub struct Outline {
        /// How dark a step in depth is, per its square.
        strength: f32 = 1.0, "", 0.0..=STRONGEST, "off";
        /// How broad the line is; half a pixel of the picture is the thinnest.
        width: f32 = 3.0, "pixels at 1080 lines", 0.1..=BROADEST;
        /// What it is drawn with.
        colour: [f32; 3] = [0.0; 3], "linear [red, green, blue]", 0.0..=BRIGHTEST;
        /// What makes a line: the nearer side of a "step" in depth; or fading with its square, "second" differences, without false
        /// lines on slopes, or those of "roberts" (the original way).
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
        /// How broad it is; at least a pixel of the picture.
        width: f32 = 3.0, "pixels at 1080 lines", 1.0..=BROADEST;
        /// What it is drawn with.
        colour: [f32; 3] = [0.045, 0.002, 0.004], "linear [red, green, blue]", 0.0..=BRIGHTEST;
    }
}

/// One tone: from luminance `from` upwards the colour is `colour`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(from = "Given"))]
pub struct Tone {
    /// Luminance where the tone begins, 0 to 1, ascending; the first reads as 0.
    pub from: f32,
    /// Linear RGB, 0 to [`BRIGHTEST`].
    pub colour: [f32; 3],
    /// Where a shadow falls, of effects that cast shadows: linear RGB, 0 to [`BRIGHTEST`]. None: `colour` there, too.
    pub shadow: Option<[f32; 3]>,
}

impl Tone {
    /// The same colour in shadow.
    pub fn new(from: f32, colour: [f32; 3]) -> Tone {
        Tone { from, colour, shadow: None }
    }
}

/// A tone as shots say it.
#[cfg(feature = "cli")]
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Given {
    Plain(f32, [f32; 3]),
    Shadowed(f32, [f32; 3], [f32; 3]),
}

#[cfg(feature = "cli")]
impl From<Given> for Tone {
    fn from(given: Given) -> Self {
        match given {
            Given::Plain(from, colour) => Tone::new(from, colour),
            Given::Shadowed(from, colour, shadow) => Tone { shadow: Some(shadow), ..Tone::new(from, colour) },
        }
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
            let colours = [Some(tone.colour), tone.shadow];
            colours.into_iter().flatten().try_for_each(|c| c.check(key, &Rule::new("linear RGB", 0.0..=BRIGHTEST)))?;
        }
        Ok(())
    }

    fn allowed((): &()) -> String {
        format!(
            "[[from, [red, green, blue]], ...], each with another colour behind it for what is in shadow or without, 1 to {MOST_TONES} tones, from 0 to 1 ascending (the first reads as 0), linear \
             colours 0 to {}, or an image file (.png, .exr), whose first row they are",
            Number::shown(BRIGHTEST)
        )
    }

    fn shown(&self) -> Option<String> {
        let one = |tone: &Tone| {
            let shadow = tone.shadow.map_or(String::new(), |colour| format!(", {}", listed_in_brackets(colour)));
            format!("[{}, {}{shadow}]", Number::shown(tone.from), listed_in_brackets(tone.colour))
        };
        Some(format!("[{}]", self.iter().map(one).collect::<Vec<_>>().join(", ")))
    }
}
