//! What lights a scene.

use glam::DVec3;

use super::is_near;
use crate::error::{Error, Result};
use crate::settings::Rule;

/// One light, without falloff, and the ambient share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where the light is or comes from.
    pub source: LightSource,
    /// Luminance of what the light does not reach, 0 to 1.
    pub ambient: f64,
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
        Light { source: LightSource::Direction(DVec3::new(-1.0, -1.5, -1.0)), ambient: 0.25 }
    }
}

impl Light {
    /// Checks every value; the error names the key.
    pub fn validate(&self) -> Result<()> {
        match self.source {
            LightSource::Direction(d) if !(d.length() > 0.0 && d.length().is_finite()) => {
                return Err(Error::setting(
                    "light.direction",
                    d,
                    "three finite numbers, not all 0, of a finite length",
                ));
            }
            LightSource::Position(p) if !is_near(p) => {
                return Err(Error::setting("light.position", p, "three finite numbers, in metres, none beyond 1e12"));
            }
            _ => {}
        }
        ambient().check("light.ambient", self.ambient)
    }
}

/// Allowed ambient shares.
pub(crate) fn ambient() -> Rule<f64> {
    Rule::new("", 0.0..=1.0)
}
