//! Keyframes: linear between frames, constant outside.

use glam::{DVec2, DVec3};

/// A value that can be interpolated between two keyframes.
pub(super) trait Between: Copy {
    /// The value at share `t` of the way from `self` to `to`.
    fn between(self, to: Self, t: f64) -> Self;
}

impl Between for f64 {
    fn between(self, to: f64, t: f64) -> f64 {
        // Infinity (camera.far) stays infinity up to the next keyframe instead of becoming NaN.
        if self.is_infinite() || to.is_infinite() { f64::INFINITY } else { self + (to - self) * t }
    }
}

impl Between for DVec2 {
    fn between(self, to: DVec2, t: f64) -> DVec2 {
        self + (to - self) * t
    }
}

impl Between for DVec3 {
    fn between(self, to: DVec3, t: f64) -> DVec3 {
        self + (to - self) * t
    }
}

/// A value over time. Holds at least one keyframe; frames ascend.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Track<T> {
    first: (f64, T),
    rest: Vec<(f64, T)>,
}

impl<T: Between> Track<T> {
    /// The same value at every frame.
    pub(super) fn constant(value: T) -> Self {
        Track { first: (0.0, value), rest: Vec::new() }
    }

    /// Keyframes; `None` if there are none, or a frame is not finite or not above the one before.
    pub(super) fn new(keyframes: Vec<(f64, T)>) -> Option<Self> {
        let ascending = keyframes.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let finite = keyframes.iter().all(|(frame, _)| frame.is_finite());
        let mut keyframes = keyframes.into_iter();
        let first = keyframes.next().filter(|_| ascending && finite)?;
        Some(Track { first, rest: keyframes.collect() })
    }

    /// The value at `frame`, which may lie between two.
    pub(super) fn at(&self, frame: impl Into<f64>) -> T {
        let frame = frame.into();
        let after = self.rest.partition_point(|(to, _)| *to <= frame);
        let (from, value) = after.checked_sub(1).and_then(|i| self.rest.get(i)).copied().unwrap_or(self.first);
        match self.rest.get(after) {
            Some((to, next)) if frame > from => value.between(*next, (frame - from) / (to - from)),
            _ => value,
        }
    }

    /// Whether the value is the same at every frame.
    pub(super) fn is_constant(&self) -> bool {
        self.rest.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_and_constant_outside() {
        let track = Track::new(vec![(10.0, 1.0), (20.0, 3.0), (21.0, f64::INFINITY)]).expect("ascending");
        let values = [0, 10, 15, 20, 21, 99].map(|frame| track.at(frame));
        assert_eq!(values, [1.0, 1.0, 2.0, 3.0, f64::INFINITY, f64::INFINITY]);
        let infinite = Track::new(vec![(0.0, f64::INFINITY), (4.0, 8.0)]).expect("ascending");
        assert_eq!([0, 2, 4].map(|frame| infinite.at(frame)), [f64::INFINITY, f64::INFINITY, 8.0]);
    }

    #[test]
    fn keyframes_must_ascend_and_be_finite() {
        for frames in [&[][..], &[(1.0, 0.0), (1.0, 1.0)], &[(2.0, 0.0), (1.0, 1.0)], &[(f64::NAN, 0.0)]] {
            assert_eq!(Track::new(frames.to_vec()), None, "{frames:?}");
        }
    }
}
