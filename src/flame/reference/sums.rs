//! Sums over repetitions.

use crate::flame::params::LIGHT_STEPS;

/// Sums over repetitions, a pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Repetitions that were rendered.
    pub repetitions: u32,
    /// Sum of the winners' `light`.
    pub light: Vec<[u64; 3]>,
    /// Sum of its squares.
    pub squares: Vec<[u64; 3]>,
    /// Repetitions with a winner.
    pub hits: Vec<u32>,
    /// Sum of the winners' view depths in metres.
    pub depth: Vec<f64>,
    /// Repetitions in which rounding could have made another particle win: a test of alpha, of a texel's border, of
    /// depth between two particles, or against near, far or the scene was that close, and mattered.
    pub near: Vec<u32>,
}

impl Sums {
    /// Of no repetition.
    pub(super) fn new(pixels: usize) -> Sums {
        Sums {
            repetitions: 0,
            light: vec![[0; 3]; pixels],
            squares: vec![[0; 3]; pixels],
            hits: vec![0; pixels],
            depth: vec![0.0; pixels],
            near: vec![0; pixels],
        }
    }

    /// Adds other repetitions of the same frame.
    pub(super) fn add(&mut self, other: &Sums) {
        self.repetitions += other.repetitions;
        for i in 0..self.hits.len() {
            for c in 0..3 {
                self.light[i][c] += other.light[i][c];
                self.squares[i][c] += other.squares[i][c];
            }
            self.hits[i] += other.hits[i];
            self.depth[i] += other.depth[i];
            self.near[i] += other.near[i];
        }
    }

    /// Mean linear RGB a pixel, of a frame whose largest component is `brightest`.
    pub fn mean(&self, brightest: f64) -> Vec<[f64; 3]> {
        let scale = brightest / f64::from(LIGHT_STEPS) / f64::from(self.repetitions);
        self.light.iter().map(|sum| sum.map(|s| s as f64 * scale)).collect()
    }

    /// Unbiased variance of one repetition's linear RGB a pixel; 0 of a single repetition.
    pub fn variance(&self, brightest: f64) -> Vec<[f64; 3]> {
        let n = u128::from(self.repetitions);
        let scale = (brightest / f64::from(LIGHT_STEPS)).powi(2) / (n * n.max(2).saturating_sub(1)) as f64;
        let of = |sum: u64, square: u64| (n * u128::from(square) - u128::from(sum).pow(2)) as f64 * scale;
        let pixels = self.light.iter().zip(&self.squares);
        pixels.map(|(sum, square)| std::array::from_fn(|c| of(sum[c], square[c]))).collect()
    }

    /// Share of the repetitions with a winner.
    pub fn coverage(&self) -> Vec<f64> {
        self.hits.iter().map(|hits| f64::from(*hits) / f64::from(self.repetitions)).collect()
    }

    /// Mean view depth of the winners in metres; infinite where there are none.
    pub fn mean_depth(&self) -> Vec<f64> {
        let pixels = self.depth.iter().zip(&self.hits);
        pixels.map(|(sum, hits)| if *hits > 0 { sum / f64::from(*hits) } else { f64::INFINITY }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_is_the_unbiased_one() {
        let mut sums = Sums::new(1);
        for light in [3_u64, 5, 13] {
            let squares = vec![[light * light; 3]];
            let single = Sums { repetitions: 1, light: vec![[light; 3]], squares, hits: vec![1], ..Sums::new(1) };
            assert_eq!(single.variance(65535.0), [[0.0; 3]]);
            sums.add(&single);
        }
        assert!((sums.variance(65535.0)[0][0] - 28.0).abs() < 1e-12 && sums.mean(65535.0)[0][1] == 7.0);
        // As large as they get: nothing overflows.
        let most = 1_u64 << 20;
        let light = vec![[most * 65535; 3]];
        let full = Sums { repetitions: 1 << 20, light, squares: vec![[most * 65535 * 65535; 3]], ..Sums::new(1) };
        assert_eq!(full.variance(1.0), [[0.0; 3]]);
    }
}
