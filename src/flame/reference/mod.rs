//! The flame effect in f64 on the CPU, written from its definition and not from the shaders: what tests and the
//! benchmark compare the GPU with. Clear before fast.

pub mod draws;
pub mod expected;
pub mod kernel;
pub mod mask;
pub mod prepare;
pub mod stochastic;
pub mod sums;
pub mod weights;

use glam::DVec3;

use super::settings::Settings;
use crate::view::Camera;

/// A position as the input holds it.
fn world(position: [f32; 3]) -> DVec3 {
    DVec3::from_array(position.map(f64::from))
}

/// How many pixels a slope of 1 is.
fn pixels_per_slope(camera: &Camera, size: [u32; 2]) -> f64 {
    f64::from(size[1]) / 2.0 / camera.half_extent(size).y
}

/// Half a sprite in pixels at view depth `z`.
fn half_side(settings: &Settings, pixels_per_slope: f64, z: f64) -> f64 {
    match settings.size_pixels {
        Some(pixels) => 0.5 * f64::from(pixels),
        None => 0.5 * f64::from(settings.sprite()) * pixels_per_slope / z,
    }
}
