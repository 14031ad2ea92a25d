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
    /// Share of the light that is soft, 0 to 1: half of it wraps around, half comes from the hemisphere above. 0: the papers'
    /// light.
    pub fill: f64,
    /// Up, where the hemisphere is; any length above 0.
    pub up: DVec3,
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
        Light { source: LightSource::Direction(DVec3::new(-1.0, -1.5, -1.0)), ambient: 0.25, fill: 0.35, up: DVec3::Y }
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
        if !(self.up.length() > 0.0 && self.up.length().is_finite()) {
            return Err(Error::setting("light.up", self.up, "three finite numbers, not all 0, of a finite length"));
        }
        ambient().check("light.ambient", self.ambient)?;
        fill().check("light.fill", self.fill)
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

    /// Unit axis of the hemisphere, and the share of the light that is soft.
    pub(crate) fn fill_axis(&self) -> [f32; 4] {
        self.up.normalize().extend(self.fill).as_vec4().to_array()
    }
}

/// Allowed soft shares.
pub(crate) fn fill() -> Rule<f64> {
    Rule::new("share of the light", 0.0..=1.0)
}

/// Allowed ambient shares.
pub(crate) fn ambient() -> Rule<f64> {
    Rule::new("", 0.0..=1.0)
}
