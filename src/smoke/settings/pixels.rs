//! Sizes of the look in pixels of a picture.

use crate::smoke::settings::{Outline, Settings};
use crate::toon::Scale;

/// What settings give at 1080 lines, in pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixels {
    /// Standard deviation of the Gaussian; 0: off.
    pub sigma: f32,
    /// Multiples of it where its window ends.
    cutoff: f32,
    /// Half the width of the border between tones; 0: hard.
    pub tone_softness: f32,
    /// Diameter of the smallest spheres that are drawn at their size; 0: all are.
    pub smallest: f32,
    /// The ink line.
    pub outline: Outline,
}

impl Pixels {
    /// Window of the Gaussian to each side in pixels: `ceil(cutoff * sigma)`; 0 if it is off.
    pub fn window(&self) -> u32 {
        (self.cutoff * self.sigma).ceil() as u32
    }
}

impl Settings {
    /// Sizes in a picture of so many lines. What is on stays on: a soft border is half a pixel broad to each side at least, a
    /// line a pixel.
    pub fn pixels(&self, lines: u32) -> Pixels {
        let scale = Scale::of(lines);
        let (sigma, smallest) = (scale.size(self.sigma), scale.size(self.smallest));
        let (tone_softness, outline) = (scale.softness(self.tone_softness), self.outline.scaled(scale));
        Pixels { sigma, cutoff: self.cutoff, tone_softness, smallest, outline }
    }

    /// The same with sizes in pixels of a picture of so many lines, as references take them.
    pub fn in_pixels(&self, lines: u32) -> Settings {
        let Pixels { sigma, tone_softness, smallest, outline, .. } = self.pixels(lines);
        Settings { sigma, tone_softness, smallest, outline, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoke::settings::Line;

    #[test]
    fn sizes_scale_with_the_picture_and_what_is_on_stays_on() {
        let line = Line { width: Some(4.0), ..Line::default() };
        let outline = Outline { width: 3.0, shortest: 12.0, inner: line, ..Outline::default() };
        let settings = Settings { sigma: 8.0, cutoff: 3.0, tone_softness: 0.75, outline, ..Settings::default() };
        assert_eq!(settings.in_pixels(1080), settings);
        let large = settings.pixels(2160);
        assert_eq!((large.sigma, large.window(), large.tone_softness), (16.0, 48, 1.5));
        assert_eq!((large.outline.width, large.outline.inner.width), (6.0, Some(8.0)));
        assert_eq!((large.outline.follow, large.outline.shortest), (16.0, 13.0), "no more is looked at");
        let small = settings.pixels(270);
        assert_eq!((small.sigma, small.window(), small.tone_softness), (2.0, 6, 0.5));
        assert_eq!((small.outline.width, small.outline.inner.width, small.outline.shortest), (1.0, Some(1.0), 3.0));
        assert_eq!((small.outline.follow, small.outline.trace_reach()), (4.0, 4));
        let off = Settings { sigma: 0.0, tone_softness: 0.0, ..settings }.pixels(4320);
        assert_eq!((off.sigma, off.window(), off.tone_softness), (0.0, 0, 0.0));
        assert_eq!((large.smallest, small.smallest), (8.0, 1.0));
    }
}
