//! From the world to pixel clip coordinates.

use glam::{DMat3, DVec2, DVec3};

use crate::view::{Projection, View};

/// Turns a world position p into (X, Y, Z) = `linear` p + `offset`. Z is the view depth in metres; X / Z and Y / Z are pixels, y
/// down, or, if the view is orthographic, X and Y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelClip {
    /// The part that multiplies positions.
    pub linear: DMat3,
    /// The part that is added.
    pub offset: DVec3,
    /// The nearest depth seen.
    pub near: f64,
    /// Whether X and Y are pixels.
    pub is_orthographic: bool,
}

impl PixelClip {
    /// That of a view of a picture of `size` pixels, with another jitter. Through one that is not valid nothing is at a finite
    /// place.
    pub fn new(view: &View, jitter: [f64; 2], size: [u32; 2]) -> PixelClip {
        PixelClip::of(&Projection::of_valid(&View { jitter, ..*view }, size))
    }

    /// That of a projection.
    pub fn of(projection: &Projection) -> PixelClip {
        let (rows, constant) = clip_rows(projection);
        let linear = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        let offset = constant.extend(0.0) - linear * projection.eye;
        PixelClip { linear, offset, near: projection.near, is_orthographic: projection.is_orthographic }
    }

    /// Pixel clip coordinates of a position.
    pub fn clip(&self, position: [f32; 3]) -> DVec3 {
        self.linear * DVec3::from_array(position.map(f64::from)) + self.offset
    }

    /// The pixel of such coordinates.
    pub fn pixel_of(&self, clip: DVec3) -> DVec2 {
        if self.is_orthographic { clip.truncate() } else { clip.truncate() / clip.z }
    }
}

/// Rows that make pixel clip coordinates of a position less the eye, and what is added to the first two.
pub(crate) fn clip_rows(projection: &Projection) -> ([DVec3; 3], DVec2) {
    let Projection { axes, focal, centre, is_orthographic, .. } = projection;
    let (right, up, ahead) = (axes.row(0), axes.row(1), axes.row(2));
    match is_orthographic {
        true => ([right * focal.x, up * -focal.y, ahead], *centre),
        false => ([right * focal.x + ahead * centre.x, up * -focal.y + ahead * centre.y, ahead], DVec2::ZERO),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    #[test]
    fn a_position_is_where_the_view_sees_it() {
        let camera = Camera { eye: DVec3::new(0.0, 1.0, 4.0), target: DVec3::new(0.0, 1.0, 0.0), ..Camera::default() };
        let clip = PixelClip::new(&camera.view([640, 480]), [0.0; 2], [640, 480]);
        let ahead = clip.clip([0.0, 1.0, 2.0]);
        assert!((ahead - DVec3::new(640.0, 480.0, 2.0)).length() < 1e-12, "{ahead}");
        // At depth 2, half the field of view up: the upper border of the picture.
        let up = clip.pixel_of(clip.clip([0.0, 1.0 + 2.0 * (20.0_f32).to_radians().tan(), 2.0]));
        assert!(up.y.abs() < 1e-4 && (up.x - 320.0).abs() < 1e-9, "{up}");
        assert!(clip.pixel_of(clip.clip([0.5, 1.0, 2.0])).x > 320.0);
    }
}
