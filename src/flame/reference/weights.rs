//! How likely a sprite is to pass, over its square: the mean over the variants of the mask.

use super::mask::{Mask, SIDE};

/// Strips that a cell of which a part passes is cut into.
const STRIPS: usize = 16;

/// Chance to pass in each of side x side cells of the sprite's square, averaged over the cell; row 0 is the top.
#[derive(Clone, Debug)]
pub struct Weights {
    side: usize,
    values: Vec<f64>,
    /// Middle and chance of the cells where it is not 0, in half sides of the square, down where the mask's rows go.
    passing: Vec<([f64; 2], f64)>,
}

impl Weights {
    /// Chances at a level of the mask for particles of an alpha. `side`: 64, or a multiple of 128; level 0 is exact for
    /// the bilinear look-up up to the strips of cells of which a part passes.
    pub fn new(mask: &Mask, level: u32, alpha: f64, threshold: f64, side: usize) -> Weights {
        assert!(side == SIDE || side.is_multiple_of(2 * SIDE), "64 cells, or a multiple of 128");
        let fine = side.max(2 * SIDE);
        // Passing is A > 0 and A at least this.
        let needed = match threshold {
            _ if threshold > 1.0 => f64::INFINITY,
            _ if threshold <= 0.0 => f64::MIN_POSITIVE,
            _ => threshold / alpha,
        };
        let values = if level == 0 { magnified(mask, needed, fine) } else { minified(mask, level, needed, fine) };
        Weights::from_values(if side == fine { values } else { halved(&values, fine) }, side)
    }

    /// Given chances, rows from the top.
    pub fn from_values(values: Vec<f64>, side: usize) -> Weights {
        let middle = |i: usize| (2.0 * i as f64 + 1.0) / side as f64 - 1.0;
        let cells = values.iter().enumerate().filter(|(_, w)| **w > 0.0);
        let passing = cells.map(|(i, w)| ([middle(i % side), middle(i / side)], *w)).collect();
        Weights { side, values, passing }
    }

    /// Middle (in half sides of the square, v down) and chance of the cells where it is not 0.
    pub fn passing(&self) -> &[([f64; 2], f64)] {
        &self.passing
    }

    /// Chance of the cell at (u, v), each -1 to 1; 0 outside.
    pub fn at(&self, u: f64, v: f64) -> f64 {
        let [x, y] = [u, v].map(|c| (c + 1.0) / 2.0 * self.side as f64);
        let inside = [x, y].iter().all(|c| (0.0..self.side as f64).contains(c));
        if inside { self.values[y as usize * self.side + x as usize] } else { 0.0 }
    }

    /// Area of a cell in squares of half sides.
    pub fn cell(&self) -> f64 {
        4.0 / (self.side * self.side) as f64
    }

    /// Mean chance over the square.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }
}

/// Cells of half as many a side, from all the cells in each.
fn halved(values: &[f64], side: usize) -> Vec<f64> {
    let at = |x: usize, y: usize| values[y * side + x];
    let cell = |i: usize| {
        let (x, y) = (2 * (i % (side / 2)), 2 * (i / (side / 2)));
        (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0
    };
    (0..side * side / 4).map(cell).collect()
}

fn minified(mask: &Mask, level: u32, needed: f64, side: usize) -> Vec<f64> {
    let (sorted, below, texels) = (mask.sorted(level), 1 << (2 * level), SIDE >> level);
    let share = |values: &[f64]| values.partition_point(|a| *a > 0.0 && *a >= needed) as f64 / below as f64;
    let shares: Vec<f64> = sorted.chunks(below).map(share).collect();
    let cell = |i: usize| {
        let texel = (i / side) * texels / side * texels + (i % side) * texels / side;
        let sum: f64 = (0..mask.variants()).map(|variant| shares[variant * texels * texels + texel]).sum();
        sum / mask.variants() as f64
    };
    (0..side * side).map(cell).collect()
}

fn magnified(mask: &Mask, needed: f64, side: usize) -> Vec<f64> {
    let mut values = vec![0.0; side * side];
    let edge = |i: usize| 2.0 * i as f64 / side as f64 - 1.0;
    let texel = |i: usize| i as f64 / side as f64 * SIDE as f64;
    for variant in 0..mask.variants() {
        let corner = |i: usize| mask.bilinear(variant, texel(i % (side + 1)), texel(i / (side + 1))).alpha;
        let corners: Vec<f64> = (0..(side + 1) * (side + 1)).map(corner).collect();
        for (i, value) in values.iter_mut().enumerate() {
            let (x, y) = (i % side, i / side);
            let first = y * (side + 1) + x;
            let alphas = [0, 1, side + 1, side + 2].map(|j| corners[first + j]);
            *value += passing_part([edge(x), edge(x + 1)], [edge(y), edge(y + 1)], alphas, needed);
        }
    }
    values.iter_mut().for_each(|value| *value /= mask.variants() as f64);
    values
}

/// Part of a cell in which a bilinear alpha, given at its corners (row by row), is enough and which lies in the unit disc.
fn passing_part(u: [f64; 2], v: [f64; 2], alphas: [f64; 4], needed: f64) -> f64 {
    if alphas.iter().all(|a| *a < needed) {
        return 0.0;
    }
    let farthest = u[0].abs().max(u[1].abs()).hypot(v[0].abs().max(v[1].abs()));
    if farthest <= 1.0 && alphas.iter().all(|a| *a >= needed) {
        return 1.0;
    }
    let [a, b, c, d] = alphas;
    let strip = |i: usize| {
        let s = (i as f64 + 0.5) / STRIPS as f64;
        let (upper, lower) = (a + (b - a) * s, c + (d - c) * s);
        let mut part = match (upper >= needed, lower >= needed) {
            (true, true) => [0.0, 1.0],
            (false, false) => return 0.0,
            (true, false) => [0.0, (upper - needed) / (upper - lower)],
            (false, true) => [(needed - upper) / (lower - upper), 1.0],
        };
        let across = u[0] + (u[1] - u[0]) * s;
        let half = (1.0 - across * across).max(0.0).sqrt();
        part[0] = part[0].max((-half - v[0]) / (v[1] - v[0]));
        part[1] = part[1].min((half - v[0]) / (v[1] - v[0]));
        (part[1] - part[0]).max(0.0)
    };
    (0..STRIPS).map(strip).sum::<f64>() / STRIPS as f64
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn a_full_mask_is_a_disc() {
        let mask = Mask::from_texels(vec![1.0; SIDE * SIDE]);
        for side in [64, 128, 384] {
            let weights = Weights::new(&mask, 0, 1.0, 0.0, side);
            assert!((weights.mean() - FRAC_PI_4).abs() < 5e-6, "{}", weights.mean());
            assert_eq!((weights.at(0.0, 0.0), weights.at(-0.99, 0.99), weights.at(1.0, 0.0)), (1.0, 0.0, 0.0));
        }
        // Levels count samples in a pattern: 4096 of them.
        assert!((Weights::new(&mask, 3, 1.0, 1.0, 128).mean() - FRAC_PI_4).abs() < 2e-3);
        assert_eq!(Weights::new(&mask, 0, 1.0, 1.1, 128).mean(), 0.0);
        assert_eq!(Weights::new(&mask, 0, 0.0, 0.1, 128).mean(), 0.0);
    }

    #[test]
    fn a_ramp_is_cut_where_it_is_high_enough() {
        // Alpha rises downwards, by 1 over the rows' middles; half of the disc and of the square passes 1/2.
        let mask = Mask::from_texels((0..SIDE * SIDE).map(|i| (i / SIDE) as f64 / 63.0).collect());
        let weights = Weights::new(&mask, 0, 2.0, 1.0, 128);
        assert!((weights.mean() - FRAC_PI_4 / 2.0).abs() < 2e-5);
        assert_eq!((weights.at(0.1, -0.1), weights.at(0.1, 0.1)), (0.0, 1.0));
        for level in 1..7 {
            let weights = Weights::new(&mask, level, 2.0, 1.0, 64);
            assert!((weights.mean() - FRAC_PI_4 / 2.0).abs() < 2e-3, "{level}: {}", weights.mean());
            // One texel at the last level: it passes as often anywhere.
            assert_eq!(weights.at(0.1, -0.9), if level == 6 { weights.mean() } else { 0.0 });
        }
    }

    #[test]
    fn agrees_with_looking_up_many_points() {
        let mask = Mask::new(5, 3);
        let weights = Weights::new(&mask, 0, 1.0, 0.21, 128);
        let n = 1500;
        let point = |i: usize| (2.0 * i as f64 + 1.0) / n as f64 - 1.0;
        let passes = |variant: usize, u: f64, v: f64| {
            u * u + v * v < 1.0 && mask.bilinear(variant, (u + 1.0) * 32.0, (v + 1.0) * 32.0).alpha >= 0.21
        };
        let counts = (0..n * n).map(|i| (0..3).filter(|v| passes(*v, point(i % n), point(i / n))).count());
        let share = counts.sum::<usize>() as f64 / (3 * n * n) as f64;
        assert!((weights.mean() - share).abs() < 1e-5, "{} {share}", weights.mean());
    }
}
