//! Look-ups in the mask, and the prefiltered levels in which nothing is averaged.

pub use crate::flame::mask::{Mask, SIDE};
use crate::flame::params::MASK_LEVELS;

/// A bilinear look-up.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Alpha.
    pub alpha: f64,
    /// Sum of the magnitudes of its slopes along both axes, a texel.
    pub slope: f64,
    /// Whether it is exactly 0 all around.
    pub empty: bool,
}

impl Mask {
    /// A mask of given alphas: 64 x 64 a variant, rows from the top, as the layer `flame.mask` has them.
    pub fn from_texels(texels: Vec<f64>) -> Mask {
        assert!(!texels.is_empty() && texels.len().is_multiple_of(SIDE * SIDE), "64 x 64 texels a variant");
        Mask { texels }
    }

    /// How many there are.
    pub fn variants(&self) -> usize {
        self.texels.len() / (SIDE * SIDE)
    }

    /// Alphas: variant, row, column.
    pub fn texels(&self) -> &[f64] {
        &self.texels
    }

    /// Alpha at (x, y) in texels from the corner of the first texel: bilinear, constant outside of the texels' centres.
    pub fn bilinear(&self, variant: usize, x: f64, y: f64) -> Look {
        let last = (SIDE - 1) as f64;
        let (x, y) = ((x - 0.5).clamp(0.0, last), (y - 0.5).clamp(0.0, last));
        let (column, row) = ((x as usize).min(SIDE - 2), (y as usize).min(SIDE - 2));
        let (s, t) = (x - column as f64, y - row as f64);
        let first = (variant * SIDE + row) * SIDE + column;
        let [a, b, c, d] = [0, 1, SIDE, SIDE + 1].map(|i| self.texels[first + i]);
        let (upper, lower) = (a + (b - a) * s, c + (d - c) * s);
        let across = (b - a) * (1.0 - t) + (d - c) * t;
        Look {
            alpha: upper + (lower - upper) * t,
            slope: across.abs() + (lower - upper).abs(),
            empty: a.max(b).max(c).max(d) == 0.0,
        }
    }

    /// A texel's contribution to the levels above it: the mask within it, between its texels as look-ups are, away from
    /// its centre by a pattern of 2 x 2, so that shares of values are shares of area.
    fn sample(&self, variant: usize, column: usize, row: usize) -> f64 {
        let (odd_column, odd_row) = ((column & 1) as f64, (row & 1) as f64);
        let x = column as f64 + 0.5 + 0.25 * (2.0 * odd_column + odd_row) - 0.375;
        let y = row as f64 + 0.5 + 0.25 * (2.0 * odd_row + 1.0 - odd_column) - 0.375;
        let [u, v] = [x, y].map(|c| 2.0 * c / SIDE as f64 - 1.0);
        if u * u + v * v < 1.0 { self.bilinear(variant, x, y).alpha } else { 0.0 }
    }

    /// A level above the first: variant, row and column of its texels, and in each the alphas below it in descending
    /// order. Level 0 is the mask itself.
    pub fn sorted(&self, level: u32) -> Vec<f64> {
        let (side, width) = (SIDE >> level, 1_usize << level);
        let mut values = Vec::with_capacity(self.texels.len());
        for block in 0..self.variants() * side * side {
            let (variant, row, column) = (block / (side * side), block / side % side, block % side);
            let start = values.len();
            for (y, x) in (row * width..).take(width).flat_map(|y| (column * width..).take(width).map(move |x| (y, x)))
            {
                let texel = self.texels[(variant * SIDE + y) * SIDE + x];
                values.push(if level == 0 { texel } else { self.sample(variant, x, y) });
            }
            values[start..].sort_by(|a, b| b.total_cmp(a));
        }
        values
    }
}

/// The level for sprites that are `pixels` wide where they are largest: the coarsest whose texels are not larger than a
/// pixel. 0 for NaN.
pub fn level(pixels: f64) -> u32 {
    (0..MASK_LEVELS - 1).take_while(|level| pixels <= (SIDE >> (level + 1)) as f64).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alphas_are_those_of_the_definition() {
        let mask = Mask::new(3, 4);
        assert_eq!((mask.variants(), mask.texels().len()), (4, 4 * 64 * 64));
        for variant in 0..4 {
            let at = |x: usize, y: usize| mask.texels()[(variant * 64 + y) * 64 + x];
            // Corners lie outside of the disc; the cone bounds what is inside.
            assert_eq!((at(0, 0), at(63, 0), at(0, 63), at(63, 63)), (0.0, 0.0, 0.0, 0.0));
            for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
                let [u, v] = [x, y].map(|c| (f64::from(c as u32) + 0.5) / 32.0 - 1.0);
                assert!((0.0..=(1.0 - u.hypot(v)).max(0.0)).contains(&at(x, y)));
            }
        }
        assert_ne!(mask.texels()[..4096], mask.texels()[4096..8192]);
        assert!((0.5..0.9).contains(&mask.largest()), "{}", mask.largest());
    }

    #[test]
    fn as_much_of_it_passes_as_of_a_cone_of_half_the_height() {
        // Noise is as often above 0 as below: (1 - |u|) / 2 passes a threshold t inside of a disc of radius 1 - 2 t.
        let mask = Mask::new(0, 64);
        for threshold in [0.1, 0.2, 0.3] {
            let passing = mask.texels().iter().filter(|a| **a >= threshold).count() as f64;
            let (found, cone) = (passing / mask.texels().len() as f64, (1.0 - 2.0 * threshold).powi(2));
            assert!((found - std::f64::consts::FRAC_PI_4 * cone).abs() < 0.04, "{threshold}: {found}");
        }
    }

    #[test]
    fn levels_are_sorted_and_complete() {
        let mask = Mask::new(1, 2);
        for level in 0..MASK_LEVELS {
            let (sorted, below) = (mask.sorted(level), 4_usize.pow(level));
            assert!(sorted.chunks(below).all(|block| block.is_sorted_by(|a, b| a >= b)));
            let all = |values: &[f64]| {
                let mut values = values.to_vec();
                values.sort_by(f64::total_cmp);
                values
            };
            let sample = |i: usize| mask.sample(i / (SIDE * SIDE), i % SIDE, i / SIDE % SIDE);
            let samples: Vec<f64> = (0..2 * SIDE * SIDE).map(sample).collect();
            assert_eq!(all(&sorted), if level == 0 { all(mask.texels()) } else { all(&samples) });
        }
        // The last block of the second variant is its last 8 x 8 texels.
        let last = mask.sorted(3);
        let side = 8;
        let mut expected: Vec<f64> = (0..64).map(|i| mask.sample(1, 56 + i % side, 56 + i / side)).collect();
        expected.sort_by(|a, b| b.total_cmp(a));
        assert_eq!(last[last.len() - 64..], expected);
    }

    /// Levels stand for the mask between its texels, too: at any threshold as much of it passes, up to a lattice's error.
    #[test]
    fn levels_have_the_area_of_the_mask() {
        let mask = Mask::new(9, 16);
        let fine = 512;
        let point = |i: usize| (i as f64 + 0.5) * 64.0 / fine as f64;
        let inside = |x: f64, y: f64| (x / 32.0 - 1.0).powi(2) + (y / 32.0 - 1.0).powi(2) < 1.0;
        let points = (0..16 * fine * fine).map(|i| (i / fine / fine, point(i % fine), point(i / fine % fine)));
        let alphas: Vec<f64> =
            points.map(|(v, x, y)| if inside(x, y) { mask.bilinear(v, x, y).alpha } else { 0.0 }).collect();
        let sorted = mask.sorted(6);
        let share = |values: &[f64], t: f64| values.iter().filter(|a| **a >= t).count() as f64 / values.len() as f64;
        for t in [0.05, 0.1, 0.2, 0.3, 0.4, 0.5] {
            let (level, area) = (share(&sorted, t), share(&alphas, t));
            // 65536 points of a pattern, of which 1300 pass 0.5; texels' centres would be off by more, as peaks are theirs.
            assert!((level / area - 1.0).abs() < 0.01, "{t}: {level} {area}");
        }
    }

    #[test]
    fn look_ups_are_bilinear() {
        let mask = Mask::from_texels((0..4096).map(|i| f64::from(i % 64) + 100.0 * f64::from(i / 64)).collect());
        let at = |x, y| mask.bilinear(0, x, y).alpha;
        assert_eq!((at(0.5, 0.5), at(10.5, 3.5), at(10.75, 3.5)), (0.0, 310.0, 310.25));
        assert_eq!((at(0.0, 0.0), at(64.0, 64.0), at(63.5, 62.0)), (0.0, 6363.0, 6213.0));
        assert!((mask.bilinear(0, 20.3, 8.1).slope - 101.0).abs() < 1e-9);
        assert!(!mask.bilinear(0, 1.0, 0.0).empty);
    }

    #[test]
    fn levels_follow_the_size() {
        let sizes = [f64::INFINITY, 1e9, 64.0, 32.1, 32.0, 16.0, 15.9, 8.0, 4.0, 2.0, 1.0, 0.5, 0.0];
        assert_eq!(sizes.map(level), [0, 0, 0, 0, 1, 2, 2, 3, 4, 5, 6, 6, 6]);
        assert_eq!(level(f64::NAN), 0);
    }
}
