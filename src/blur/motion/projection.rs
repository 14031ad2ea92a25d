//! From the world to pixel clip coordinates.

use glam::{DMat3, DVec3};

use crate::view::Camera;

/// Turns a world position p into (X, Y, W) = `linear` p + `offset`: X / W and Y / W are pixels, y down, W is the view
/// depth in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The part that multiplies positions.
    pub linear: DMat3,
    /// The part that is added.
    pub offset: DVec3,
    /// The nearest depth seen.
    pub near: f64,
}

impl Projection {
    /// That of a camera for a picture of `size` pixels.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Projection {
        let [width, height] = size.map(f64::from);
        let focal = 0.5 * height / camera.half_extent(size).y;
        let view = camera.rotation();
        let forward = view.row(2);
        let x = view.row(0) * focal + forward * (0.5 * width);
        let y = view.row(1) * -focal + forward * (0.5 * height);
        let linear = DMat3::from_cols(x, y, forward).transpose();
        Projection { linear, offset: -(linear * camera.eye), near: camera.near }
    }

    /// Pixel clip coordinates of a position.
    pub fn clip(&self, position: [f32; 3]) -> DVec3 {
        self.linear * DVec3::from_array(position.map(f64::from)) + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_is_where_the_camera_sees_it() {
        let camera = Camera { eye: DVec3::new(0.0, 1.0, 4.0), target: DVec3::new(0.0, 1.0, 0.0), ..Camera::default() };
        let projection = Projection::new(&camera, [640, 480]);
        let ahead = projection.clip([0.0, 1.0, 2.0]);
        assert!((ahead - DVec3::new(640.0, 480.0, 2.0)).length() < 1e-12, "{ahead}");
        // At depth 2, half the field of view up: the upper border of the picture.
        let up = projection.clip([0.0, 1.0 + 2.0 * (20.0_f32).to_radians().tan(), 2.0]);
        assert!((up.y / up.z).abs() < 1e-4 && (up.x / up.z - 320.0).abs() < 1e-9, "{up}");
        let right = projection.clip([0.5, 1.0, 2.0]);
        assert!(right.x / right.z > 320.0);
    }
}
