//! The settings of the flame effect: one field per key of `[flame]`, with unit, range and default.

use crate::error::{Error, Result};
use crate::settings::{Dial, Rule, Setting, settings, words};
use crate::shaders::flame::constants::{COLDEST, MOST_COUNT, MOST_OCTAVES};
use crate::toon::Line;
use crate::view::{BRIGHTEST, FARTHEST};

mod pixels;
mod tones;

pub use pixels::Pixels;
pub use tones::Tones;

words! {
    /// What fire looks like.
    pub enum Look {
        /// Drawn: flat tones by heat, closed shapes with a line around them.
        #[default]
        Cel = "cel",
        /// As a black body glows (the paper's way).
        Light = "light",
    }
}

words! {
    /// What a pixel's colour is made of.
    pub enum Mode {
        /// Repetitions of random render particles, alpha test and depth test, averaged (the paper's way). Has grain.
        #[default]
        Stochastic = "stochastic",
        /// The image that the repetitions converge to, integrated: no grain.
        Expected = "expected",
    }
}

words! {
    /// How repetitions are rendered. Both make the same picture.
    pub enum Method {
        /// Compute, tile by tile, all repetitions in one pass.
        #[default]
        Tiles = "tiles",
        /// A render pass a repetition (the paper's way); slow, for comparison.
        Raster = "raster",
    }
}

words! {
    /// Where a physical particle puts its render particles.
    pub enum Shape {
        /// Uniformly in a ball of radius `spread`.
        #[default]
        Ball = "ball",
        /// Uniformly in a cube of half side `spread`.
        Cube = "cube",
    }
}

/// Colours of temperatures.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Colour {
    /// Black-body radiance, relative to `hottest`: 1200 K is 1e-5 of white.
    Physical,
    /// The black body's chromaticity, as bright as (T / `hottest`)^`falloff` (the paper's figure 2).
    #[default]
    Displayable,
    /// Linear RGB over T / `hottest`, 0 to 1, linear between its entries.
    #[cfg_attr(feature = "cli", serde(skip))]
    Ramp(Vec<[f32; 3]>),
}

words! {
    /// How the offsets of a render particle are drawn over the repetitions.
    pub enum Sampling {
        /// Each for itself.
        #[default]
        Independent = "independent",
        /// An Owen-scrambled Sobol sequence, shuffled for each render particle: 1 to 2 times less variance.
        ShuffledSobol = "shuffled_sobol",
    }
}

settings! {
    /// Settings of the flame effect. Fixed until `Effect::change`; what comes with each frame is in `Frame`.
    pub struct Settings {
        /// Repetitions of random render particles, "stochastic", or what ever more of them come to, without noise, at once.
        mode: Mode = Mode::default();
        /// Drawn in flat tones by heat, "cel", or glowing as a black body does, "light".
        look: Look = Look::default();
        /// How repetitions are rendered, with the same picture: "tiles" is fast, "raster" the original way.
        method: Method = Method::default();
        /// Pictures that are averaged. 1: hard-edged grains that dance; a few: a brush with bristles; from about 20: a soft
        /// glow without grain.
        repetitions: u32 = 20, "", 1..=MOST_REPETITIONS;
        /// Render particles, sprites, that a particle as hot as `hottest` has; cooler ones have fewer.
        count: f32 = 20.0, "sprites of a particle", 0.0..=MOST_COUNT;
        /// How far sprites are from their particle at most. Without it a shot takes the mean distance of particles to their
        /// 8th neighbour, in each frame anew, smoothed over five frames; and a host has to say it with each frame:
        /// `flame::mean_spacing` finds that.
        spread: Option<f32> = None, "metres", 0.0..=1e6;
        /// Where sprites are: uniform in a "ball" of radius `spread` or in a "cube" of that half side.
        shape: Shape = Shape::default();
        /// Side of a sprite; without it, `spread`. Small: sparks and fine threads; large: round, cloudy billows.
        size: Option<f32> = None, "metres", 0.0..=1e6;
        /// Sprites are drawn out along their motion on screen, by as far as they move in that time, where particles have
        /// velocities; eight times as long at most.
        stretch: f32 = 0.0, "seconds", 0.0..=10.0, "off";
        /// Side of a sprite however near the camera is, instead of `size`, and not with the mode "expected".
        size_pixels: Option<f32> = None, "pixels", 0.0..=16384.0;
        /// Alpha of the hottest sprites where they are densest. Low: little passes, thin wisps in the hot core only; high:
        /// full, closed bodies up to the cool tips.
        alpha_scale: f32 = 4.0, "", 0.0..=1e6;
        /// What alpha, at most 1, must reach to be drawn. Low: round, soft sprites; high: torn spots, so that the fire
        /// frays; above 1: no fire at all.
        threshold: f32 = 0.45, "", f32::MIN..=f32::MAX;
        /// Different patches of noise.
        variants: u32 = 16, "", 1..=64;
        /// Octaves of finer noise below the texels of a sprite's noise, which appear as the camera comes near; 0: near
        /// sprites are smooth. Only with the mode "stochastic".
        octaves: u32 = 6, "", 0..=MOST_OCTAVES;
        /// How far through the fire the hottest sprite shines, in sprites: of two sprites, one behind the other, the hotter
        /// one gives the colour, the less often the farther they are apart, and beyond so many sprites never. 0: the
        /// nearest does. Without it, 2 in the mode "stochastic" with the method "tiles"; others have none.
        emission: Option<f32> = None, "sprites", 0.0..=1e3;
        /// The temperature that is white.
        hottest: f32 = 3000.0, "kelvin", COLDEST..=HOTTEST;
        /// What temperature looks like: a black body's hue, darker as falloff says, "displayable"; its radiance, "physical",
        /// 1200 K has 1e-5 of white; or the first row of an image, the colours from 0 K to `hottest`.
        colour: Colour = Colour::default();
        /// With "displayable" colour, brightness is (temperature / hottest)^falloff.
        falloff: f32 = 2.2, "", 0.0..=16.0;
        /// The eye's to the hottest fire. 1: it is white; 0: all is seen as in daylight, orange.
        adaptation: f32 = 0.15, "", 0.0..=1.0;
        /// Multiplies the light of the fire.
        intensity: f32 = 1.0, "", 0.0..=1e6;
        /// How repetitions draw the offsets of sprites: "independent", or with less noise, "shuffled_sobol".
        sampling: Sampling = Sampling::default();
        /// Steps in depth of the mode "expected".
        bins: u32 = 32, "", 1..=1024;
        /// Repeats only until pixels are this exact (95 % interval).
        adaptive: f32 = 0.0, "", 0.0..=1.0, "off";
        /// Share of the offsets that are drawn anew each frame.
        flicker: f32 = 0.0, "", 0.0..=1.0, "they last";
        /// How bright the fire lights the smoke of the same shot; or, in a shot with a mesh, how strongly it tints both, as what
        /// is in a host's scene.
        light: f32 = 0.0, "", 0.0..=1e6, "off";
        /// Where half of that light arrives on smoke; without it, at four standard deviations from the middle of the fire.
        reach: Option<f32> = None, "metres", 1e-6..=FARTHEST;
        /// Of the look "cel": standard deviation of the Gaussian that heat is smoothed by. Heat is the temperature that a
        /// pixel sees, averaged over repetitions, 0 where there is no fire.
        sigma: f32 = 4.0, "pixels at 1080 lines", 0.1..=64.0, "off";
        /// Of the look "cel": what smoothed heat becomes. Below the first tone is no fire.
        tones: Tones = Tones::default();
        /// Of the look "cel": half the width of the border between tones, and around the fire; at least half a pixel of the
        /// picture, so that it is antialiased.
        tone_softness: f32 = 0.5, "pixels at 1080 lines", 0.0..=16.0, "hard";
        /// Of the look "cel": the ink line around the fire.
        outline: Line = Line::default();
        /// Light around what is brighter than 1.
        glow: Glow = Glow::default();
        /// Sparks that fly out of the fire.
        embers: Embers = Embers::default();
    }
}

settings! {
    /// Sparks that fly out of the fire: each leaves its particle as that cools, rises along y and circles, and shrinks to
    /// nothing at 700 K. They stay hotter than their particles and have the colours of the tones, or, in the look "light", of
    /// temperatures. They are seen where the fire is not, have no glow, and are in no layer.
    #[derive(Copy)]
    pub struct Embers {
        /// Share of the particles that have one.
        share: f32 = 0.0, "", 0.0..=1.0, "none";
        /// Diameter of the hottest.
        size: f32 = 8.0, "pixels at 1080 lines", 0.0..=64.0;
        /// How far one that has cooled is above its particle, give or take half of it; without it, 24 times `spread`.
        rise: Option<f32> = None, "metres", 0.0..=FARTHEST;
    }
}

impl Embers {
    /// How far they rise in metres, of particles with that spread.
    pub fn height(&self, spread: f32) -> f32 {
        self.rise.unwrap_or(RISE_IN_SPREADS * spread)
    }

    /// Whether there may be one.
    pub fn is_on(&self) -> bool {
        self.share > 0.0 && self.size > 0.0
    }
}

settings! {
    /// Light around what is brighter than 1: a wide Gaussian of as much as that is above 1, added in linear light.
    #[derive(Copy)]
    pub struct Glow {
        /// How strong it is; 1 gives back all of the light.
        strength: f32 = 0.0, "", 0.0..=100.0, "off";
        /// Standard deviation of the Gaussian.
        sigma: f32 = 48.0, "pixels at 1080 lines", 1.0..=64.0;
    }
}

impl Glow {
    /// Whether there is one.
    pub fn is_on(&self) -> bool {
        self.strength > 0.0
    }

    /// Window of the Gaussian to each side in pixels, three times `sigma`; 0 if it is off.
    pub fn window(&self) -> u32 {
        if self.is_on() { (3.0 * self.sigma).ceil() as u32 } else { 0 }
    }
}

/// The highest temperature that is taken, of particles as of settings, in kelvin.
pub const HOTTEST: f32 = 1e6;
/// How far embers rise where nothing is said.
const RISE_IN_SPREADS: f32 = 24.0;
/// How far the hottest sprite shines where nothing is said, in sprites.
const USUAL_EMISSION: f32 = 2.0;
/// The most repetitions.
pub const MOST_REPETITIONS: u32 = 1 << 20;

impl Settings {
    /// Whether the image is the one that repetitions converge to.
    pub fn is_expected(&self) -> bool {
        self.mode == Mode::Expected
    }

    /// Whether it is drawn in tones.
    pub fn is_cel(&self) -> bool {
        self.look == Look::Cel
    }

    /// Whether fire is seen in pixels that have none.
    pub(super) fn spreads(&self) -> bool {
        self.is_cel() || self.glow.is_on()
    }

    /// Whether sprites are drawn out along their motion.
    pub fn stretches(&self) -> bool {
        self.stretch > 0.0
    }

    /// Whether tiles end when their pixels are exact enough.
    pub fn is_adaptive(&self) -> bool {
        self.adaptive > 0.0
    }

    /// Whether sprites are drawn anew from frame to frame.
    pub fn flickers(&self) -> bool {
        self.flicker > 0.0
    }

    /// Whether the fire tints what is in the scene.
    pub fn lights(&self) -> bool {
        self.light > 0.0
    }

    /// The paper's own look: it glows, the nearest sprite gives the colour, near ones are smooth, the hottest fire is white.
    pub fn paper() -> Settings {
        Settings {
            look: Look::Light,
            threshold: 0.4,
            octaves: 0,
            emission: Some(0.0),
            falloff: 2.0,
            adaptation: 1.0,
            ..Settings::default()
        }
    }

    /// Side of a sprite in metres, unless it is given in pixels.
    pub fn sprite(&self) -> f32 {
        self.size.or(self.spread).unwrap_or_default()
    }

    /// How far the hottest shines, in sprites.
    pub fn shines(&self) -> f32 {
        let usual = if self.can_shine() && !self.is_cel() { USUAL_EMISSION } else { 0.0 };
        self.emission.unwrap_or(usual)
    }

    /// Whether the hottest sprite can give the colour of those before it: repetitions must be made tile by tile.
    fn can_shine(&self) -> bool {
        (self.mode, self.method) == (Mode::Stochastic, Method::Tiles)
    }

    /// Octaves that repetitions have: the expected image has none.
    pub fn detail(&self) -> u32 {
        if self.is_expected() { 0 } else { self.octaves }
    }

    /// The keys of `[flame]`, in order.
    pub fn dials() -> Vec<Dial> {
        Setting::dials(&Settings::default())
    }

    /// Checks every value; the error names the key and what is allowed.
    pub fn validate(&self) -> Result<()> {
        self.check("flame", &())?;
        self.tones.check_ascending(self.hottest)?;
        if let Some(emission) = self.emission.filter(|emission| *emission > 0.0 && !self.can_shine()) {
            let allowed = "0, or left out, with mode = \"expected\" and with method = \"raster\": only the tiles of repetitions \
                           find the hottest sprite";
            return Err(Error::setting("flame.emission", emission, allowed));
        }
        let Some(pixels) = self.size_pixels else { return Ok(()) };
        if self.size.is_some() {
            return Err(Error::setting("flame.size_pixels", pixels, "not together with flame.size"));
        }
        if self.is_expected() {
            let allowed = "not with mode = \"expected\", whose table is in metres; use flame.size";
            return Err(Error::setting("flame.size_pixels", pixels, allowed));
        }
        Ok(())
    }
}

impl Setting for Colour {
    type Rule = ();

    fn check(&self, key: &str, (): &()) -> Result<()> {
        let Colour::Ramp(colours) = self else { return Ok(()) };
        if colours.is_empty() || colours.len() > 4096 {
            let given = format!("{} colours", colours.len());
            return Err(Error::setting(key.to_owned(), given, "1 to 4096 colours"));
        }
        colours.iter().try_for_each(|colour| colour.check(key, &Rule::new("linear RGB", 0.0..=BRIGHTEST)))
    }

    fn allowed((): &()) -> String {
        "\"physical\", \"displayable\", or an image file (.png, .exr)".to_owned()
    }

    fn shown(&self) -> Option<String> {
        match self {
            Colour::Physical => Some("\"physical\"".to_owned()),
            Colour::Displayable => Some("\"displayable\"".to_owned()),
            Colour::Ramp(_) => None,
        }
    }
}
