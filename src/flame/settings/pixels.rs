//! Sizes of the look in pixels of a picture.

use crate::flame::settings::{Embers, Glow, Settings};
use crate::toon::{Line, Scale};

/// What settings give at 1080 lines, in pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixels {
    /// Standard deviation of the Gaussian that heat is smoothed by; 0: off.
    pub sigma: f32,
    /// Half the width of the border between tones; 0: hard.
    pub tone_softness: f32,
    /// The ink line.
    pub outline: Line,
    /// Light around what is brighter than 1.
    pub glow: Glow,
    /// Sparks.
    pub embers: Embers,
}

impl Pixels {
    /// Window of the Gaussian to each side in pixels, three times `sigma`; 0 if it is off.
    pub fn window(&self) -> u32 {
        (3.0 * self.sigma).ceil() as u32
    }
}

impl Settings {
    /// Sizes in a picture of so many lines.
    pub fn pixels(&self, lines: u32) -> Pixels {
        let scale = Scale::of(lines);
        Pixels {
            sigma: scale.size(self.sigma),
            tone_softness: scale.softness(self.tone_softness),
            outline: Line { width: scale.line(self.outline.width), ..self.outline },
            glow: Glow { sigma: scale.size(self.glow.sigma), ..self.glow },
            embers: Embers { size: scale.size(self.embers.size), ..self.embers },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_scale_with_the_picture() {
        let glow = Glow { strength: 1.0, sigma: 30.0 };
        let line = Line { width: 3.0, ..Line::default() };
        let embers = Embers { size: 8.0, ..Embers::default() };
        let settings = Settings { sigma: 6.0, tone_softness: 1.0, outline: line, glow, embers, ..Settings::default() };
        let Pixels { sigma, tone_softness, outline, glow, embers } = settings.pixels(2160);
        assert_eq!((sigma, tone_softness, outline.width, glow.sigma, embers.size), (12.0, 2.0, 6.0, 60.0, 16.0));
        let Pixels { sigma, tone_softness, outline, glow, embers } = settings.pixels(270);
        assert_eq!((sigma, tone_softness, outline.width, glow.sigma, embers.size), (1.5, 0.5, 1.0, 7.5, 2.0));
    }
}
