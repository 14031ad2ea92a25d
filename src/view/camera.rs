//! A camera that looks from one point to another.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::{FARTHEST, NARROWEST, View, WIDEST, is_near};
use crate::error::{Error, Result};
use crate::settings::Rule;

/// Most that a lens is shifted, in picture heights.
pub const MOST_SHIFT: f64 = 100.0;

/// A camera without distortion: right-handed, y up. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: DVec3,
    /// The point looked at; must differ from `eye`.
    pub target: DVec3,
    /// Any direction that is up in the picture; must not be parallel to the view direction.
    pub up: DVec3,
    /// Vertical field of view in degrees, [`NARROWEST`] to [`WIDEST`]; not looked at if the view is `orthographic`.
    pub vertical_fov: f64,
    /// Height of what is seen in metres, without perspective, 1e-9 to 1e12; none: there is perspective.
    pub orthographic: Option<f64>,
    /// Where the picture's middle is, beside what lies ahead, in picture heights to the right and up, at most [`MOST_SHIFT`]: a
    /// lens that is shifted.
    pub shift: DVec2,
    /// Width of a pixel by its height, 0.1 to 10.
    pub pixel_aspect: f64,
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
            orthographic: None,
            shift: DVec2::ZERO,
            pixel_aspect: 1.0,
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
        if let Some(height) = self.orthographic {
            orthographic().check("camera.orthographic", height)?;
        }
        if !self.shift.to_array().iter().all(|shift| shift.abs() <= MOST_SHIFT) {
            return Err(Error::setting("camera.shift", self.shift, shift_allowed()));
        }
        pixel_aspect().check("camera.pixel_aspect", self.pixel_aspect)?;
        near().check("camera.near", self.near)?;
        if self.far.is_nan() || self.far <= self.near {
            return Err(Error::setting("camera.far", self.far, "metres, above camera.near; may be inf"));
        }
        if self.orthographic.is_some() && self.far.is_infinite() {
            let allowed = "metres, above camera.near; not inf where camera.orthographic is";
            return Err(Error::setting("camera.far", self.far, allowed));
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

    /// Half of what is seen at depth 1 of the view across a picture of `size` pixels, and of what is seen up it; orthographic: at
    /// any depth.
    pub fn half_extent(&self, size: [u32; 2]) -> DVec2 {
        let y = match self.orthographic {
            Some(height) => height / 2.0,
            None => (self.vertical_fov.to_radians() / 2.0).tan(),
        };
        DVec2::new(self.pixel_aspect * y * f64::from(size[0]) / f64::from(size[1]), y)
    }

    /// What it sees in a picture of `size` pixels; depth is reversed.
    pub fn view(&self, size: [u32; 2]) -> View {
        let rotation = self.rotation();
        let row = |axis: usize| rotation.row(axis).extend(-rotation.row(axis).dot(self.eye));
        let half = self.half_extent(size);
        let scale = half.recip();
        let share = if self.far.is_finite() { self.near / (self.far - self.near) } else { 0.0 };
        let (divisor, depth) = match self.orthographic {
            Some(_) => (DVec4::W, DVec4::new(0.0, 0.0, -1.0 / (self.far - self.near), 1.0 + share)),
            None => (DVec4::Z, DVec4::new(0.0, 0.0, -share, self.near * (1.0 + share))),
        };
        let shift = 2.0 * self.shift * DVec2::new(half.y / half.x, 1.0);
        let across = DVec4::X * scale.x - divisor * shift.x;
        let down = DVec4::Y * -scale.y + divisor * shift.y;
        View {
            world_to_view: DMat4::from_cols(row(0), row(1), row(2), DVec4::W).transpose(),
            view_to_clip: DMat4::from_cols(across, down, depth, divisor).transpose(),
            jitter: [0.0; 2],
            reversed: true,
        }
    }
}

/// Allowed fields of view.
pub(crate) fn vertical_fov() -> Rule<f64> {
    Rule::new("degrees", NARROWEST..=WIDEST)
}

/// Allowed heights of what is seen without perspective.
pub(crate) fn orthographic() -> Rule<f64> {
    Rule::new("metres", 1e-9..=f64::from(FARTHEST))
}

/// Allowed shifts.
pub(crate) fn shift_allowed() -> String {
    format!("[right, up], in picture heights, none beyond {MOST_SHIFT}")
}

/// Allowed shapes of pixels.
pub(crate) fn pixel_aspect() -> Rule<f64> {
    Rule::new("width of a pixel by its height", 0.1..=10.0)
}

/// Allowed nearest depths.
pub(crate) fn near() -> Rule<f64> {
    Rule::new("metres", 1e-9..=f64::from(FARTHEST))
}
