//! What lights a scene.

use glam::DVec3;

use super::{BRIGHTEST, FARTHEST, is_near};
use crate::error::{Error, Result};
use crate::settings::Rule;
#[cfg(feature = "reference")]
use crate::shaders::toon::constants::{RIM_FROM, RIM_TO};

/// One light, without falloff, and the ambient share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where the light is or comes from.
    pub source: LightSource,
    /// Luminance of what the light does not reach, 0 to 1.
    pub ambient: f64,
    /// Share of the light that is soft, 0 to 1: half of it wraps around, half comes from the hemisphere above. 0: the papers'
    /// light.
    pub fill: f64,
    /// Up, where the hemisphere is; any length above 0.
    pub up: DVec3,
    /// How bright the edges are that turn away from the light and from who looks, 0 to 1: as if light came from behind. No
    /// shadow falls on it.
    pub rim: f64,
    /// A second light, which casts no shadows.
    pub second: Option<SecondLight>,
}

/// A light beside the first: colourless, without falloff and without shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondLight {
    /// Where it is or comes from.
    pub source: LightSource,
    /// Share of what is missing to white that it gives to what faces it, 0 to 1.
    pub strength: f64,
}

/// A fire that lights smoke: a point light of a colour, with falloff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FireLight {
    /// Its middle in metres, none beyond 1e12.
    pub position: DVec3,
    /// Linear RGB, each 0 to 1e6: what the colour of the smoke is multiplied by where it is lit fully.
    pub colour: [f32; 3],
    /// Distance in metres at which half of the light arrives, 1e-6 to 1e12.
    pub reach: f64,
}

/// Directional or point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// The way light travels; any length above 0.
    Direction(DVec3),
    /// Position in metres.
    Position(DVec3),
}

impl Default for Light {
    fn default() -> Self {
        let source = LightSource::Direction(DVec3::new(-1.0, -1.5, -1.0));
        Light { source, ambient: 0.25, fill: 0.35, up: DVec3::Y, rim: 0.0, second: None }
    }
}

impl Light {
    /// Checks every value; the error names the key.
    pub fn validate(&self) -> Result<()> {
        self.source.check("light")?;
        if !(self.up.length() > 0.0 && self.up.length().is_finite()) {
            return Err(Error::setting("light.up", self.up, "three finite numbers, not all 0, of a finite length"));
        }
        ambient().check("light.ambient", self.ambient)?;
        fill().check("light.fill", self.fill)?;
        rim().check("light.rim", self.rim)?;
        let Some(SecondLight { source, strength: given }) = self.second else { return Ok(()) };
        source.check("light.second")?;
        strength().check("light.second.strength", given)
    }

    /// Luminance of a surface to which a share `arriving` of the light comes, by the cosines between its normal and the light,
    /// and up.
    #[cfg(feature = "reference")]
    pub fn luminance(&self, facing: f64, arriving: f64, up: f64) -> f64 {
        let direct = facing.max(0.0) * arriving;
        let wrapped = 0.5 + 0.5 * (direct + facing.min(0.0));
        let soft = 0.5 * (wrapped + 0.5 + 0.5 * up);
        self.ambient + (1.0 - self.ambient) * (direct * (1.0 - self.fill) + soft * self.fill)
    }

    /// A luminance with the second light over it, by the cosine between the normal and that.
    #[cfg(feature = "reference")]
    pub fn with_second(&self, luminance: f64, facing: f64) -> f64 {
        let strength = self.second.map_or(0.0, |light| light.strength);
        luminance + (1.0 - luminance) * strength * facing.max(0.0)
    }

    /// How far a surface turns away from the light and from the eye, 0 to 1, by the cosines between its normal and both.
    #[cfg(feature = "reference")]
    pub fn turned_away(facing: f64, eye: f64) -> f64 {
        (1.0 - eye.clamp(0.0, 1.0)).powi(3) * (0.5 - 0.5 * facing)
    }

    /// A luminance with the rim over it, of a surface that is turned away so far: none below [`RIM_FROM`], all above [`RIM_TO`].
    #[cfg(feature = "reference")]
    pub fn with_rim(&self, luminance: f64, turned_away: f64) -> f64 {
        let [from, to] = [RIM_FROM, RIM_TO].map(f64::from);
        let t = ((turned_away - from) / (to - from)).clamp(0.0, 1.0);
        luminance + (1.0 - luminance) * self.rim * t * t * (3.0 - 2.0 * t)
    }

    /// The second light, homogeneous, and its strength; 0 without one.
    pub(crate) fn second_terms(&self) -> ([f32; 4], f32) {
        self.second.map_or(([0.0; 4], 0.0), |light| (light.source.homogeneous(), light.strength as f32))
    }

    /// Unit axis of the hemisphere, and the share of the light that is soft.
    pub(crate) fn fill_axis(&self) -> [f32; 4] {
        self.up.normalize().extend(self.fill).as_vec4().to_array()
    }
}

impl LightSource {
    fn check(&self, key: &str) -> Result<()> {
        match self {
            LightSource::Direction(d) if !(d.length() > 0.0 && d.length().is_finite()) => {
                let allowed = "three finite numbers, not all 0, of a finite length";
                Err(Error::setting(format!("{key}.direction"), d, allowed))
            }
            LightSource::Position(p) if !is_near(*p) => {
                let allowed = "three finite numbers, in metres, none beyond 1e12";
                Err(Error::setting(format!("{key}.position"), p, allowed))
            }
            _ => Ok(()),
        }
    }

    /// The unit vector towards it and 0, or where it is and 1.
    pub(crate) fn homogeneous(&self) -> [f32; 4] {
        let (way, w) = match self {
            LightSource::Direction(way) => (-way.normalize(), 0.0),
            LightSource::Position(place) => (*place, 1.0),
        };
        way.as_vec3().extend(w).to_array()
    }
}

impl FireLight {
    /// Checks every value; the error names the one.
    pub fn validate(&self) -> Result<()> {
        if !is_near(self.position) {
            let allowed = "three finite numbers, in metres, none beyond 1e12";
            return Err(Error::setting("fire.position", self.position, allowed));
        }
        let colour = Rule::new("linear RGB", 0.0..=BRIGHTEST);
        self.colour.iter().try_for_each(|component| colour.check("fire.colour", *component))?;
        Rule::new("metres", 1e-6..=f64::from(FARTHEST)).check("fire.reach", self.reach)
    }

    /// Share of the light at a distance.
    #[cfg(feature = "reference")]
    pub fn falloff(&self, distance: f64) -> f64 {
        1.0 / (1.0 + (distance / self.reach).powi(2))
    }
}

/// Allowed rims.
pub(crate) fn rim() -> Rule<f64> {
    Rule::new("", 0.0..=1.0)
}

/// Allowed strengths of second lights.
pub(crate) fn strength() -> Rule<f64> {
    Rule::new("share of what is missing to white", 0.0..=1.0)
}

/// Allowed soft shares.
pub(crate) fn fill() -> Rule<f64> {
    Rule::new("share of the light", 0.0..=1.0)
}

/// Allowed ambient shares.
pub(crate) fn ambient() -> Rule<f64> {
    Rule::new("", 0.0..=1.0)
}
