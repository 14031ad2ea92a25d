//! How long drawings last.

/// How many frames each drawing of an effect lasts: what moves stays as it is until the next one, while the camera goes on.
/// Animators draw "on ones", "on twos" or "on threes".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exposure {
    /// The shot's first frame, which has the first drawing.
    first: u32,
    on: u32,
}

impl Exposure {
    /// The most frames of a drawing.
    pub(crate) const MOST: u32 = 3;

    /// Of a shot that begins at a frame.
    pub(crate) fn new(first: u32, on: u32) -> Exposure {
        Exposure { first, on: on.max(1) }
    }

    /// Frames that a drawing lasts.
    pub fn on(self) -> u32 {
        self.on
    }

    /// The frame whose drawing a frame of the shot has: that or one before.
    pub fn drawing(self, frame: u32) -> u32 {
        frame - frame.saturating_sub(self.first) % self.on
    }

    /// Whether a frame has the drawing of the one before.
    pub fn is_held(self, frame: u32) -> bool {
        self.drawing(frame) != frame
    }

    /// So many frames in drawings: a part of one counts as one.
    pub fn drawings(self, frames: u32) -> u32 {
        frames.div_ceil(self.on)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawings_begin_with_the_shot() {
        let twos = Exposure::new(7, 2);
        assert_eq!([7, 8, 9, 10].map(|frame| twos.drawing(frame)), [7, 7, 9, 9]);
        assert_eq!([7, 8, 9, 10].map(|frame| twos.is_held(frame)), [false, true, false, true]);
        assert_eq!([0, 1, 2, 3].map(|frames| twos.drawings(frames)), [0, 1, 1, 2]);
        let ones = Exposure::new(0, 1);
        assert!((0..5).all(|frame| ones.drawing(frame) == frame && ones.drawings(frame) == frame));
    }
}
