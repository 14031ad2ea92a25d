//! Constant tables on the device.

use crate::flame::colour::Table;
use crate::flame::desc::Desc;
use crate::flame::settings::{Colour, Pixels, Settings};
use crate::shaders::flame::blocks::Tone;
use crate::toon;

/// Results that a thread of the Gaussian makes: `TAPS` of its kernels.
const TAPS: u32 = 4;

/// Colours of temperatures; the Gaussian's weights by distance, and their sums from 1 on; tones.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    pub(super) colours: Table,
    /// Sizes of the look in pixels of the picture.
    pub(super) pixels: Pixels,
    pub(super) weights: Vec<f32>,
    /// Place of their sums behind them.
    pub(super) half_sums: u32,
    pub(super) glow_weights: Vec<f32>,
    /// 1 / the sum of all of the glow's weights.
    pub(super) glow_scale: f32,
    pub(super) tones: Vec<Tone>,
}

impl Tables {
    /// From what the effect is made for.
    pub fn new(desc: &Desc) -> Tables {
        let settings = &desc.settings;
        let pixels = desc.pixels();
        let window = pixels.window();
        let mut weights = weights(pixels.sigma, window);
        let half_sums = weights.len() as u32;
        let glow_weights = self::weights(pixels.glow.sigma, pixels.glow.window());
        let along: f64 = glow_weights.iter().skip(1).map(|weight| 2.0 * f64::from(*weight)).sum::<f64>() + 1.0;
        let mut sum = 0.0;
        for distance in 0..=window as usize {
            sum += if distance > 0 { f64::from(weights[distance]) } else { 0.0 };
            weights.push(sum as f32);
        }
        let tones = settings.tones.shares(settings.hottest).map(|tone| Tone { colour: tone.colour, from: tone.from });
        let glow_scale = along.powi(-2) as f32;
        Tables {
            pixels,
            glow_weights,
            glow_scale,
            colours: if settings.is_cel() {
                Table::heat(settings.hottest.into())
            } else {
                colours(settings, desc.hottest)
            },
            half_sums,
            weights,
            tones: tones.collect(),
        }
    }
}

/// Of blocks of taps that reach over the window, and the one in its middle.
fn weights(sigma: f32, window: u32) -> Vec<f32> {
    let blocks = (window + 2 * (TAPS - 1)) / TAPS + 1;
    toon::weights(sigma, window, blocks * TAPS)
}

/// Colours of temperatures as they glow, of which those above `upper` count as that hot.
pub(super) fn colours(settings: &Settings, upper: f32) -> Table {
    let [hottest, falloff, adaptation] = [settings.hottest, settings.falloff, settings.adaptation].map(f64::from);
    match &settings.colour {
        Colour::Physical => Table::physical(hottest, adaptation, hottest.max(upper.into())),
        Colour::Displayable => Table::displayable(hottest, falloff, adaptation),
        Colour::Ramp(colours) => Table::ramp(hottest, colours),
    }
}
