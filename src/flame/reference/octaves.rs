//! Finer noise below the mask's texels: Perlin noise in two dimensions, an octave at a time.

use crate::flame::params::{FIRST_OCTAVE, OCTAVE, OCTAVE_KEY};
use crate::random::pcg;

/// What the octaves add, for a cone of height 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Octaves {
    /// Their sum.
    pub value: f64,
    /// A bound of the magnitudes of its slopes along both axes, a texel.
    pub slope: f64,
}

/// The bound of the slopes of one octave along both axes, from wave to wave: the fade's steepest, 15/8, times the
/// difference of two corners, at most 2.9, and the corners' own slopes, at most 2, along each.
const STEEPEST: f64 = 2.0 * (1.875 * 2.9 + 2.0);

impl Octaves {
    /// At (x, y) in texels from the corner of a variant's mask, where a pixel has so many texels. An octave is there in full
    /// where its waves are 8 to 16 pixels long, and not at all where they have 4 or 32.
    pub fn new(count: u32, seed: u32, variant: u32, [x, y]: [f64; 2], footprint: f64) -> Octaves {
        let variant = pcg(OCTAVE_KEY.wrapping_add(pcg(variant.wrapping_add(pcg(seed)))));
        (0..count).fold(Octaves::default(), |sum, octave| {
            let length = f64::from(FIRST_OCTAVE) / f64::from(1_u32 << octave);
            let pixels = length / footprint;
            let share = (2.0 - 8.0 / pixels).clamp(0.0, 1.0) * (32.0 / pixels - 1.0).clamp(0.0, 1.0);
            let height = share * f64::from(OCTAVE);
            Octaves {
                value: sum.value + height * noise(pcg(octave.wrapping_add(variant)), [x / length, y / length]),
                slope: sum.slope + height * STEEPEST / length,
            }
        })
    }
}

/// Noise of a seed, 0 at whole coordinates.
pub fn noise(seed: u32, point: [f64; 2]) -> f64 {
    let cell = point.map(|c| c.floor());
    let at = [point[0] - cell[0], point[1] - cell[1]];
    let fade = at.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |right: u32, down: u32| {
        let [x, y] = [cell[0] as i64 as u32, cell[1] as i64 as u32];
        let row = pcg(y.wrapping_add(down).wrapping_add(seed));
        let [dx, dy] = direction(pcg(x.wrapping_add(right).wrapping_add(row)));
        dx * (at[0] - f64::from(right)) + dy * (at[1] - f64::from(down))
    };
    let between = |t: f64, a: f64, b: f64| a + t * (b - a);
    between(fade[1], between(fade[0], corner(0, 0), corner(1, 0)), between(fade[0], corner(0, 1), corner(1, 1)))
}

/// One of the eight directions along the axes and between them, as long as the square's diagonal.
fn direction(h: u32) -> [f64; 2] {
    let sign = if h & 1 == 0 { 1.0 } else { -1.0 };
    match (h & 2, h & 4) {
        (0, 0) => [2.0_f64.sqrt() * sign, 0.0],
        (_, 0) => [0.0, 2.0_f64.sqrt() * sign],
        (0, _) => [sign, sign],
        _ => [sign, -sign],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> impl Iterator<Item = [f64; 2]> {
        (0..160 * 160).map(|i| [f64::from(i % 160) * 0.4 + 0.013, f64::from(i / 160) * 0.4 + 0.027])
    }

    #[test]
    fn noise_is_0_at_whole_places_and_in_the_mean() {
        assert_eq!([[0.0, 0.0], [17.0, 3.0], [63.0, 64.0]].map(|p| noise(5, p)), [0.0; 3]);
        let values: Vec<f64> = points().map(|p| noise(9, p)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let deviation = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        assert!(mean.abs() < 0.02 && (0.3..0.45).contains(&deviation), "{mean} {deviation}");
        assert!(values.iter().all(|v| v.abs() <= 2.0_f64.sqrt()));
    }

    #[test]
    fn octaves_appear_as_they_are_magnified() {
        let rms = |footprint: f64| {
            let values = points().map(|p| Octaves::new(4, 1, 2, p, footprint).value.powi(2));
            (values.sum::<f64>() / (160.0 * 160.0)).sqrt()
        };
        // None where a pixel has a texel, one from half a texel on, and as much with each halving until there are no more.
        assert_eq!([1.0, 1.5, f64::INFINITY, 1e-3].map(rms), [0.0; 4]);
        let one = rms(0.5);
        let others = [0.25, 0.125, 0.0625].map(|footprint| rms(footprint) / one);
        assert!(others.iter().all(|by| (by - 2.0_f64.sqrt()).abs() < 0.06), "{others:?}");
        assert!((rms(0.75) / one - 0.5).abs() < 1e-9);
    }

    #[test]
    fn slopes_are_within_their_bound() {
        for p in points() {
            let at = |x: f64, y: f64| Octaves::new(4, 3, 1, [p[0] + x, p[1] + y], 0.03);
            let slopes = [at(1e-5, 0.0), at(0.0, 1e-5)].map(|there| (there.value - at(0.0, 0.0).value).abs() / 1e-5);
            assert!(slopes[0] + slopes[1] <= at(0.0, 0.0).slope, "{slopes:?}");
        }
    }
}
