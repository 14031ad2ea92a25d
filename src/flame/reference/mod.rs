//! The flame effect in f64 on the CPU, written from its definition and not from the shaders: what tests and the
//! benchmark compare the GPU with. Clear before fast.

pub mod cel;
pub mod draws;
pub mod embers;
pub mod expected;
pub mod kernel;
pub mod mask;
pub mod octaves;
pub mod prepare;
pub mod stochastic;
pub mod sums;
pub mod weights;

use glam::{DVec2, DVec3};

use super::settings::Settings;
use crate::view::Projection;

/// A position as the input holds it.
fn world(position: [f32; 3]) -> DVec3 {
    DVec3::from_array(position.map(f64::from))
}

/// Half a sprite in pixels at view depth `z`, across and down.
fn half_sides(settings: &Settings, projection: &Projection, z: f64) -> DVec2 {
    match settings.size_pixels {
        Some(pixels) => DVec2::splat(0.5 * f64::from(pixels)),
        None => 0.5 * f64::from(settings.sprite()) * projection.focal / projection.widening(z),
    }
}

/// A place in the plane of the picture, from a particle's centre, as it is drawn out: by the matrix 1 + w w^T.
fn drawn_out(place: DVec2, w: DVec2) -> DVec2 {
    place + w * w.dot(place)
}

/// Where a place has been drawn out from.
fn drawn_back(place: DVec2, w: DVec2) -> DVec2 {
    place - w * (w.dot(place) / (1.0 + w.length_squared()))
}

/// By what a sprite is enlarged that has less than a pixel across or down.
fn enlarged(half_sides: DVec2) -> f64 {
    (0.5 / half_sides.min_element()).max(1.0)
}
