//! Sizes in pixels of a picture: settings give them at 1080 lines, so that pictures of any size are drawn alike.

/// Lines of the picture that settings mean.
pub const LINES: u32 = 1080;
/// Least half width of a soft border, in pixels: that of an antialiased one.
const SOFTEST: f32 = 0.5;

/// Pixels of a picture to a pixel at 1080 lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale(f32);

impl Scale {
    /// Of a picture of so many lines.
    pub(crate) fn of(lines: u32) -> Scale {
        Scale(lines as f32 / LINES as f32)
    }

    /// A size.
    pub(crate) fn size(self, pixels: f32) -> f32 {
        pixels * self.0
    }

    /// Half the width of a border, which is antialiased at least unless it is hard.
    pub(crate) fn softness(self, pixels: f32) -> f32 {
        if pixels > 0.0 { self.size(pixels).max(SOFTEST) } else { 0.0 }
    }

    /// The width of a line, a pixel at least.
    pub(crate) fn line(self, pixels: f32) -> f32 {
        self.size(pixels).max(1.0)
    }
}
