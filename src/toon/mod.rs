//! Common parts of cel-shaded effects: flat tones and the ink line.

mod pixels;
pub mod settings;

pub use pixels::LINES;
pub(crate) use pixels::Scale;
pub use settings::{Line, Operator, Outline, Tone};

/// Weights of a Gaussian by distance, `count` of them; 0 beyond the window.
pub(crate) fn weights(sigma: f32, window: u32, count: u32) -> Vec<f32> {
    let sigma = f64::from(sigma);
    let weight = |distance: u32| match distance {
        0 => 1.0,
        distance if distance <= window => (-f64::from(distance).powi(2) / (2.0 * sigma * sigma)).exp() as f32,
        _ => 0.0,
    };
    (0..count).map(weight).collect()
}

/// How far a line of a width reaches from its middle, in whole pixels or samples as the width is.
pub(crate) fn ink_reach(width: f32) -> u32 {
    width.ceil() as u32 - 1
}
