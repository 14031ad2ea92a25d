//! The settings of the flame effect: one field per key of `[flame]`, with unit, range and default.

use crate::error::{Error, Result, within};
use crate::shaders::flame::constants::{COLDEST, MOST_COUNT};
use crate::view::BRIGHTEST;

/// What a pixel's colour is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Mode {
    /// Repetitions of random render particles, alpha test and depth test, averaged (the paper's way). Has grain.
    #[default]
    Stochastic,
    /// The image that the repetitions converge to, integrated: no grain.
    Expected,
}

/// How repetitions are rendered. Both make the same picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Method {
    /// Compute, tile by tile, all repetitions in one pass.
    #[default]
    Tiles,
    /// A render pass a repetition (the paper's way); slow, for comparison.
    Raster,
}

/// Where a physical particle puts its render particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Shape {
    /// Uniformly in a ball of radius `spread`.
    #[default]
    Ball,
    /// Uniformly in a cube of half side `spread`.
    Cube,
}

/// What temperature looks like.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Colour {
    /// Black-body radiance, relative to `hottest`: 1200 K is 1e-5 of white.
    Physical,
    /// The black body's chromaticity, as bright as (T / `hottest`)^`falloff` (the paper's figure 2).
    #[default]
    Displayable,
    /// Linear RGB over T / `hottest`, 0 to 1, linear between its entries.
    Ramp(Vec<[f32; 3]>),
}

/// How the offsets of a render particle are drawn over the repetitions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Sampling {
    /// Each for itself.
    #[default]
    Independent,
    /// An Owen-scrambled Sobol sequence, shuffled for each render particle: 1 to 2 times less variance.
    ShuffledSobol,
}

/// Settings of the flame effect. Everything here is fixed at creation; what changes per frame is in `Frame`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Settings {
    /// Repetitions, or the image that they converge to.
    pub mode: Mode,
    /// How repetitions are rendered.
    pub method: Method,
    /// Repetitions R that are averaged, 1 to 1,048,576; default 20. The paper's first dial: 1 is grain, at 20 none is seen.
    pub repetitions: u32,
    /// Render particles that a particle of temperature `hottest` has on average in a repetition, 0 to 32768; default 20.
    pub count: f32,
    /// Radius of the space that a particle's render particles fill, in metres, >= 0. Without one the effect cannot be
    /// made: [`crate::flame::mean_spacing`] finds the usual one, the mean distance to the 8th neighbour.
    pub spread: Option<f32>,
    /// What space that is.
    pub shape: Shape,
    /// Side of a render particle's sprite in metres, >= 0; default: `spread`.
    pub size: Option<f32>,
    /// Side of a sprite in pixels, >= 0, instead of `size`: it stays the same however near the camera is.
    pub size_pixels: Option<f32>,
    /// Alpha of the hottest particle's sprite at its brightest spot, >= 0; default 4. The paper's second dial.
    pub alpha_scale: f32,
    /// What alpha, at most 1, must reach for a pixel to be drawn; any finite number; default 0.4. Low: round blobs, high: sparks.
    pub threshold: f32,
    /// Different noise textures for sprites, 1 to 64; default 16.
    pub variants: u32,
    /// The temperature that is white, in kelvin, 700 to 1e6; default 3000.
    pub hottest: f32,
    /// What temperature looks like.
    #[cfg_attr(feature = "cli", serde(skip))]
    pub colour: Colour,
    /// How fast cooler fire darkens with `displayable` colour, 0 to 16; default 2.
    pub falloff: f32,
    /// How far the eye has adapted to the hottest fire, 0 to 1; default 1: it is white.
    pub adaptation: f32,
    /// Multiplies the light of the fire, >= 0; default 1.
    pub intensity: f32,
    /// How offsets are drawn over the repetitions.
    pub sampling: Sampling,
    /// Depth bins of the expected image, 1 to 1024; default 32.
    pub bins: u32,
    /// Stop repeating in a tile once the 95 % interval of each of its pixels is below this; 0 (off) to 1; default 0.
    pub adaptive: f32,
    /// Share of the render particles that are drawn anew each frame, 0 to 1; default 0.
    pub flicker: f32,
    /// How strongly the fire tints what is in the scene, >= 0; default 0 (off).
    pub light: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            mode: Mode::default(),
            method: Method::default(),
            repetitions: 20,
            count: 20.0,
            spread: None,
            shape: Shape::default(),
            size: None,
            size_pixels: None,
            alpha_scale: 4.0,
            threshold: 0.4,
            variants: 16,
            hottest: 3000.0,
            colour: Colour::default(),
            falloff: 2.0,
            adaptation: 1.0,
            intensity: 1.0,
            sampling: Sampling::default(),
            bins: 32,
            adaptive: 0.0,
            flicker: 0.0,
            light: 0.0,
        }
    }
}

/// The highest temperature that is taken, of particles as of settings, in kelvin.
pub const HOTTEST: f32 = 1e6;
/// The most repetitions.
pub const MOST_REPETITIONS: u32 = 1 << 20;

impl Settings {
    /// Side of a sprite in metres, unless it is given in pixels.
    pub fn sprite(&self) -> f32 {
        self.size.or(self.spread).unwrap_or_default()
    }

    /// Checks every value; the error names the key and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let (number, whole) = (within::<f32>, within::<u32>);
        whole("flame.repetitions", self.repetitions, 1, MOST_REPETITIONS, "1 to 1048576")?;
        number("flame.count", self.count, 0.0, MOST_COUNT, "0 to 32768")?;
        if let Some(spread) = self.spread {
            number("flame.spread", spread, 0.0, 1e6, "metres, 0 to 1e6")?;
        }
        if let Some(size) = self.size {
            number("flame.size", size, 0.0, 1e6, "metres, 0 to 1e6")?;
        }
        if let Some(pixels) = self.size_pixels {
            number("flame.size_pixels", pixels, 0.0, 16384.0, "pixels, 0 to 16384")?;
            if self.size.is_some() {
                return Err(Error::setting("flame.size_pixels", pixels, "not together with flame.size"));
            }
            if self.mode == Mode::Expected {
                let allowed = "not with mode = \"expected\", whose table is in metres; use flame.size";
                return Err(Error::setting("flame.size_pixels", pixels, allowed));
            }
        }
        number("flame.alpha_scale", self.alpha_scale, 0.0, 1e6, "0 to 1e6")?;
        number("flame.threshold", self.threshold, f32::MIN, f32::MAX, "a finite number")?;
        whole("flame.variants", self.variants, 1, 64, "1 to 64")?;
        number("flame.hottest", self.hottest, COLDEST, HOTTEST, "kelvin, 700 to 1e6")?;
        self.validate_ramp()?;
        number("flame.falloff", self.falloff, 0.0, 16.0, "0 to 16")?;
        number("flame.adaptation", self.adaptation, 0.0, 1.0, "0 to 1")?;
        number("flame.intensity", self.intensity, 0.0, 1e6, "0 to 1e6")?;
        whole("flame.bins", self.bins, 1, 1024, "1 to 1024")?;
        number("flame.adaptive", self.adaptive, 0.0, 1.0, "0 (off) to 1")?;
        number("flame.flicker", self.flicker, 0.0, 1.0, "0 to 1")?;
        number("flame.light", self.light, 0.0, 1e6, "0 (off) to 1e6")?;
        Ok(())
    }

    fn validate_ramp(&self) -> Result<()> {
        let Colour::Ramp(colours) = &self.colour else { return Ok(()) };
        if colours.is_empty() || colours.len() > 4096 {
            return Err(Error::setting("flame.colour", format!("{} colours", colours.len()), "1 to 4096 colours"));
        }
        match colours.iter().flatten().find(|c| !(0.0..=BRIGHTEST).contains(*c)) {
            Some(colour) => Err(Error::setting("flame.colour", colour, "linear RGB, 0 to 1e6")),
            None => Ok(()),
        }
    }
}
