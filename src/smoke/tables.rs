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
        let count = if settings.is_filtered() { (layout.window_blocks + 1) * BLOCK } else { 1 };
        let weights = weights(settings.sigma, settings.window(), count);
        let tones = settings.tones.iter().map(|tone| Tone { colour: tone.colour, from: tone.from });
        Tables { weights, tones: tones.collect() }
    }
}
