//! Constant tables on the device.

use crate::shaders::smoke::blocks::Tone;
use crate::shaders::smoke::constants::BLOCK;
use crate::smoke::layout::Layout;
use crate::smoke::settings::Settings;
use crate::toon::weights;

/// The Gaussian's weights by distance, and the tones.
#[derive(Clone, Debug)]
pub struct Tables {
    pub(super) weights: Vec<f32>,
    pub(super) tones: Vec<Tone>,
}

impl Tables {
    /// From settings.
    pub fn new(settings: &Settings, layout: &Layout) -> Tables {
        let (pixels, count) = (&layout.pixels, (layout.window_blocks + 1) * BLOCK);
        let weights = weights(pixels.sigma, pixels.window(), if settings.is_filtered() { count } else { 1 });
        let tones = settings.all_tones().map(|tone| {
            let shadow = tone.shadow.unwrap_or(tone.colour);
            Tone { colour: tone.colour, from: tone.from, shadow, unused: 0.0 }
        });
        Tables { weights, tones: tones.collect() }
    }
}
