//! Constant tables on the device.

use crate::shaders::smoke::blocks::Tone;
use crate::shaders::smoke::constants::BLOCK;
use crate::smoke::layout::Layout;
use crate::smoke::settings::Settings;

/// The Gaussian's weights by distance, and the tones.
#[derive(Clone, Debug)]
pub struct Tables {
    pub(super) weights: Vec<f32>,
    pub(super) tones: Vec<Tone>,
}

impl Tables {
    /// From settings.
    pub fn new(settings: &Settings, layout: &Layout) -> Tables {
        let sigma = f64::from(layout.pixels.sigma);
        let weight = |distance: u32| match distance <= layout.pixels.window() {
            true => (-f64::from(distance).powi(2) / (2.0 * sigma * sigma)).exp() as f32,
            false => 0.0,
        };
        let weights = match settings.is_filtered() {
            true => (0..(layout.window_blocks + 1) * BLOCK).map(weight).collect(),
            false => vec![1.0],
        };
        let tones = settings.all_tones().map(|tone| {
            let shadow = tone.shadow.unwrap_or(tone.colour);
            Tone { colour: tone.colour, from: tone.from, shadow, unused: 0.0 }
        });
        Tables { weights, tones: tones.collect() }
    }
}
