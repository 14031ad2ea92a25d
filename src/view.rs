//! What an effect is seen through and lit by: [`View`], or a [`Camera`] that makes one, and [`Light`].

mod camera;
mod light;
mod motion;
mod projection;

use glam::{DMat4, DVec3};

use crate::error::Result;
pub use crate::shaders::common::constants::FARTHEST;

pub use camera::{Camera, MOST_SHIFT};
#[cfg(feature = "cli")]
pub(crate) use camera::{near, orthographic, pixel_aspect, shift_allowed, vertical_fov};
pub use light::{FireLight, Light, LightSource, SecondLight};
#[cfg(feature = "cli")]
pub(crate) use light::{ambient, fill, rim, strength};
pub use projection::Projection;

/// Largest component of a linear colour that is taken, of settings as of pixels and vertices: far beyond what half floats
/// hold, and so far below what single floats hold that products of several are finite.
pub const BRIGHTEST: f32 = 1e6;

/// Narrowest field of view that is taken, in degrees: a metre is some 6e10 m away where it fills the picture, and a picture's
/// pixels times [`FARTHEST`] are finite as single floats.
pub const NARROWEST: f64 = 1e-9;

/// The widest, as far below half a turn.
pub const WIDEST: f64 = 180.0 - 1e-9;

/// Most pixels that [`View::jitter`] moves a picture.
pub const MOST_JITTER: f64 = 16.0;

/// What a picture is seen through: `clip = view_to_clip * world_to_view * position`, with columns as vectors and Vulkan's
/// clip coordinates: x to the right, y down, depth 0 to 1.
///
/// Perspective or orthographic; off-centre, mirrored, turned about the way it looks; left- or right-handed, any axis up; depth
/// reversed or not, the far plane at any distance. Pixels need not be square. [`Camera::view`] makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// World to view space, in metres: a rotation, mirrored or not, and a translation. What single floats lose of a rotation
    /// does not matter.
    pub world_to_view: DMat4,
    /// View space to clip space. Depth depends on the distance along the view axis alone: no oblique near plane.
    pub view_to_clip: DMat4,
    /// Where all of the picture is moved to, in pixels to the right and down, at most [`MOST_JITTER`]: the jitter of temporal
    /// anti-aliasing, if `view_to_clip` is without. Effects take it out of motion.
    pub jitter: [f64; 2],
    /// Whether depth is 1 at the near plane and 0 at the far one.
    pub reversed: bool,
}

impl View {
    /// Checks both matrices and the jitter; the error names the one and says what is allowed.
    pub fn validate(&self) -> Result<()> {
        Projection::new(self, [1, 1]).map(|_| ())
    }

    /// The same with depth that is 1 at the near plane, or at the far one.
    pub fn with_reversed(mut self, reversed: bool) -> View {
        if reversed != self.reversed {
            // 1 less depth, after the division.
            let rows = self.view_to_clip.transpose();
            self.view_to_clip = DMat4 { z_axis: rows.w_axis - rows.z_axis, ..rows }.transpose();
            self.reversed = reversed;
        }
        self
    }

    /// The same of a picture that is not moved.
    pub(crate) fn without_jitter(&self) -> View {
        View { jitter: [0.0; 2], ..*self }
    }
}

/// Whether no coordinate is beyond [`FARTHEST`].
fn is_near(point: DVec3) -> bool {
    point.to_array().iter().all(|x| x.abs() <= f64::from(FARTHEST))
}

#[cfg(test)]
mod tests;
