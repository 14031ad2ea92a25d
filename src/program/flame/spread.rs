//! The spread of a shot's flame that has none: how far apart particles are, frame by frame, smoothed in time.

use std::collections::BTreeMap;

use crate::flame::mean_spacing;
use crate::io::ReadError;
use crate::io::particles::ParticleSequence;

/// Spread where no frame around has two particles, in metres.
const DEFAULT: f32 = 0.1;
/// Weights of a frame and of those before and behind it: binomial.
const WEIGHTS: [f64; 3] = [6.0, 4.0, 1.0];

/// Finds spreads. That of a frame is a mean over five frames and follows from those alone, so that a frame by itself looks as it
/// does in its sequence.
#[derive(Debug)]
pub(super) struct Spreads {
    particles: ParticleSequence,
    /// First and last frame of the shot.
    frames: [u32; 2],
    /// Mean distance to the 8th neighbour of the frames looked at so far; none where there are no two particles.
    spacings: BTreeMap<u32, Option<f32>>,
}

impl Spreads {
    pub(super) fn new(particles: ParticleSequence, frames: [u32; 2]) -> Spreads {
        Spreads { particles, frames, spacings: BTreeMap::new() }
    }

    /// The frames that a frame's spread follows from, and their weights: beyond the shot's ends, the ends. One whose input is not
    /// there is left out.
    pub(super) fn window(&self, frame: u32) -> impl Iterator<Item = (u32, f64)> {
        let [first, last] = self.frames;
        let at = move |offset: i64| (i64::from(frame) + offset).clamp(first.into(), last.into()) as u32;
        let window = (-2..=2_i64).map(move |offset| (at(offset), WEIGHTS[offset.unsigned_abs() as usize]));
        window.filter(move |(other, _)| *other == frame || self.particles.file(*other).is_ok())
    }

    /// The spread of a frame, in metres.
    pub(super) fn of(&mut self, frame: u32) -> Result<f32, ReadError> {
        let window: Vec<(u32, f64)> = self.window(frame).collect();
        let (mut sum, mut weights) = (0.0, 0.0);
        for (frame, weight) in window {
            if let Some(spacing) = self.spacing(frame)? {
                (sum, weights) = (sum + weight * f64::from(spacing), weights + weight);
            }
        }
        // No frame before is asked for again.
        self.spacings.retain(|known, _| *known + 4 > frame);
        Ok(if weights > 0.0 { (sum / weights) as f32 } else { DEFAULT })
    }

    fn spacing(&mut self, frame: u32) -> Result<Option<f32>, ReadError> {
        if let Some(spacing) = self.spacings.get(&frame) {
            return Ok(*spacing);
        }
        // One file may be many frames'.
        let last = self.spacings.last_key_value().map(|(frame, spacing)| (*frame, *spacing));
        let spacing = match last {
            Some((other, spacing)) if self.particles.is_same(other, frame)? => spacing,
            _ => mean_spacing(&self.particles.frame(frame)?.position),
        };
        self.spacings.insert(frame, spacing);
        Ok(spacing)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn spreads(frames: [u32; 2]) -> Spreads {
        Spreads::new(ParticleSequence::new("builtin:random", Path::new(""), (), false, 24.0).unwrap(), frames)
    }

    #[test]
    fn a_frame_alone_has_the_spread_that_it_has_in_the_sequence() {
        let mut sequence = spreads([1, 9]);
        let all: Vec<f32> = (1..=9).map(|frame| sequence.of(frame).unwrap()).collect();
        let alone: Vec<f32> = (1..=9).map(|frame| spreads([1, 9]).of(frame).unwrap()).collect();
        assert_eq!(all, alone);
        assert_eq!(sequence.of(2).unwrap(), all[1], "frames may come in any order");
        assert!(all.windows(2).all(|pair| (pair[1] / pair[0] - 1.0).abs() < 0.05), "{all:?}");
    }

    #[test]
    fn it_is_the_binomial_mean_and_ends_count_for_what_is_beyond_them() {
        let spacing =
            |frame| f64::from(mean_spacing(&spreads([1, 9]).particles.frame(frame).unwrap().position).unwrap());
        let expected = |frames: [u32; 5]| {
            let weights = [1.0, 4.0, 6.0, 4.0, 1.0];
            (frames.iter().zip(weights).map(|(frame, weight)| spacing(*frame) * weight).sum::<f64>() / 16.0) as f32
        };
        assert_eq!(spreads([1, 9]).of(5).unwrap(), expected([3, 4, 5, 6, 7]));
        assert_eq!(spreads([4, 9]).of(5).unwrap(), expected([4, 4, 5, 6, 7]));
        assert_eq!(spreads([5, 5]).of(5).unwrap(), expected([5; 5]));
    }
}
