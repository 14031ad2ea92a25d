//! The camera and the light of an effect: [`Camera`] and [`Light`].

use glam::{DMat3, DVec2, DVec3};

use crate::error::{Error, Result};
use crate::settings::Rule;
pub use crate::shaders::common::constants::FARTHEST;
use crate::shaders::shared::blocks::CameraRows;

/// Largest component of a linear colour that is taken, of settings as of pixels and vertices: far beyond what half floats
/// hold, and so far below what single floats hold that products of several are finite.
pub const BRIGHTEST: f32 = 1e6;

/// Narrowest field of view that is taken, in degrees: a metre is some 6e10 m away where it fills the picture, and a picture's
/// pixels times [`FARTHEST`] are finite as single floats.
pub const NARROWEST: f64 = 1e-9;

/// The widest, as far below half a turn.
pub const WIDEST: f64 = 180.0 - 1e-9;

/// A pinhole camera: right-handed, y up, square pixels. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: DVec3,
    /// The point looked at; must differ from `eye`.
    pub target: DVec3,
    /// Any direction that is up in the picture; must not be parallel to the view direction.
    pub up: DVec3,
    /// Vertical field of view in degrees, [`NARROWEST`] to [`WIDEST`].
    pub vertical_fov: f64,
    /// Nearest depth seen, 1e-9 to 1e12.
    pub near: f64,
    /// Farthest depth seen, > `near`; may be infinite.
    pub far: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Camera {
            eye: DVec3::new(0.0, 1.0, 4.0),
            target: DVec3::new(0.0, 1.0, 0.0),
            up: DVec3::Y,
            vertical_fov: 40.0,
            near: 0.1,
            far: 100.0,
        }
    }
}

impl Camera {
    /// Checks every value; the error names the key.
    pub fn validate(&self) -> Result<()> {
        let finite = |name, v: DVec3| match is_near(v) {
            true => Ok(()),
            false => Err(Error::setting(name, v, "three finite numbers, in metres, none beyond 1e12")),
        };
        finite("camera.eye", self.eye)?;
        finite("camera.target", self.target)?;
        finite("camera.up", self.up)?;
        if (self.target - self.eye).length() == 0.0 {
            return Err(Error::setting("camera.target", self.target, "must differ from camera.eye"));
        }
        let across = (self.target - self.eye).normalize().cross(self.up.normalize_or_zero());
        if across.length() < 1e-9 {
            return Err(Error::setting("camera.up", self.up, "must not be parallel to the view direction"));
        }
        vertical_fov().check("camera.vertical_fov", self.vertical_fov)?;
        near().check("camera.near", self.near)?;
        if self.far.is_nan() || self.far <= self.near {
            return Err(Error::setting("camera.far", self.far, "metres, above camera.near; may be inf"));
        }
        Ok(())
    }

    /// Rows right, up and forward: turns `p - eye` into view space (x right, y up, z = view depth).
    pub fn rotation(&self) -> DMat3 {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        DMat3::from_cols(right, up, forward).transpose()
    }

    /// View-space extent at depth 1 from the centre to the right and to the top edge of a picture of `size` pixels.
    pub fn half_extent(&self, size: [u32; 2]) -> DVec2 {
        let y = (self.vertical_fov.to_radians() / 2.0).tan();
        DVec2::new(y * f64::from(size[0]) / f64::from(size[1]), y)
    }
}

/// Allowed fields of view.
pub(crate) fn vertical_fov() -> Rule<f64> {
    Rule::new("degrees", NARROWEST..=WIDEST)
}

/// Allowed nearest depths.
pub(crate) fn near() -> Rule<f64> {
    Rule::new("metres", 1e-9..=f64::from(FARTHEST))
}

/// Allowed ambient shares.
pub(crate) fn ambient() -> Rule<f64> {
    Rule::new("", 0.0..=1.0)
}

/// Whether no coordinate is beyond [`FARTHEST`].
fn is_near(point: DVec3) -> bool {
    point.to_array().iter().all(|x| x.abs() <= f64::from(FARTHEST))
}

impl CameraRows {
    pub(crate) fn new(camera: &Camera) -> CameraRows {
        let split = |v: DVec3| {
            let high = v.as_vec3();
            [high, (v - high.as_dvec3()).as_vec3()].map(|part| part.extend(0.0).to_array())
        };
        let rotation = camera.rotation();
        let [right, up, forward] = [0, 1, 2].map(|axis| split(rotation.row(axis)));
        let [eye, eye_low] = split(camera.eye);
        CameraRows {
            eye,
            eye_low,
            right: right[0],
            up: up[0],
            forward: forward[0],
            right_low: right[1],
            up_low: up[1],
            forward_low: forward[1],
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_and_lights_beyond_what_floats_hold_are_refused_by_name() {
        let usual = Camera::default();
        let refused = |camera: Camera| camera.validate().expect_err("it is refused").to_string();
        for fov in [1e-30, 1e-10, 0.0, -1.0, 180.0, 180.0 - 1e-10, f64::NAN] {
            assert!(refused(Camera { vertical_fov: fov, ..usual }).contains("camera.vertical_fov"));
        }
        for near in [0.0, 1e-30, 1e13, f64::INFINITY, f64::NAN] {
            assert!(refused(Camera { near, far: f64::INFINITY, ..usual }).contains("camera.near"));
        }
        assert!(refused(Camera { eye: DVec3::splat(1e300), ..usual }).contains("camera.eye"));
        let ends = [(NARROWEST, 1e-9), (WIDEST, f64::from(FARTHEST))];
        for (vertical_fov, near) in ends {
            assert!(Camera { vertical_fov, near, far: f64::INFINITY, ..usual }.validate().is_ok());
        }
        let light = |source| Light { source, ambient: 0.0 };
        for way in [DVec3::ZERO, DVec3::splat(1e200), DVec3::splat(1e-200), DVec3::NAN] {
            assert!(light(LightSource::Direction(way)).validate().is_err(), "{way}");
        }
        assert!(light(LightSource::Position(DVec3::splat(1e20))).validate().is_err());
    }
}
