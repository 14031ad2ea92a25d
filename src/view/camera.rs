//! A camera that looks from one point to another.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::{FARTHEST, NARROWEST, View, WIDEST, is_near};
use crate::error::{Error, Result};
use crate::settings::Rule;

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

    /// What it sees in a picture of `size` pixels; depth is reversed.
    pub fn view(&self, size: [u32; 2]) -> View {
        let rotation = self.rotation();
        let row = |axis: usize| rotation.row(axis).extend(-rotation.row(axis).dot(self.eye));
        let scale = self.half_extent(size).recip();
        let share = if self.far.is_finite() { self.near / (self.far - self.near) } else { 0.0 };
        let depth = DVec4::new(0.0, 0.0, -share, self.near * (1.0 + share));
        View {
            world_to_view: DMat4::from_cols(row(0), row(1), row(2), DVec4::W).transpose(),
            view_to_clip: DMat4::from_cols(DVec4::X * scale.x, DVec4::Y * -scale.y, depth, DVec4::Z).transpose(),
            jitter: [0.0; 2],
            reversed: true,
        }
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
