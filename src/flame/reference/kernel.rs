//! How likely it is that one render particle passes along a ray nearer than a depth, in closed form for each cell of its
//! sprite.

use glam::{DMat3, DVec2, DVec3};

use super::weights::Weights;
use crate::flame::params::LEAST_LOGARITHM;
use crate::flame::settings::Shape;

/// The logarithm of what is left is not below this.
pub const FLOOR: f64 = LEAST_LOGARITHM as f64;

/// The common values of a particle's render particles.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    /// Chance to pass, over the sprite's square.
    pub weights: &'a Weights,
    /// Factor of all chances.
    pub fill: f64,
    /// Half a sprite in metres.
    pub half: f64,
    /// Radius of the ball, or half side of the cube, that they fill, in metres.
    pub spread: f64,
    /// Which of the two.
    pub shape: Shape,
    /// Turns world into view space: a cube's sides are along the world's axes. Does not matter for a ball.
    pub rotation: DMat3,
}

impl Body<'_> {
    /// How far in depth render particles may be from the centre, in metres.
    pub fn reach(&self) -> f64 {
        match self.shape {
            Shape::Ball => self.spread,
            Shape::Cube => self.rotation.row(2).abs().element_sum() * self.spread,
        }
    }

    /// Whether a ray can meet any sprite. `beside` and `slope` as in [`Body::shares`].
    pub fn touches(&self, beside: DVec2, slope: DVec2) -> bool {
        let radius = if self.shape == Shape::Ball { self.spread } else { 3.0_f64.sqrt() * self.spread };
        // The ray is at its nearest to the axis at some depth within the body.
        let squared = slope.length_squared();
        let nearest = if squared > 0.0 { (-beside.dot(slope) / squared).clamp(-radius, radius) } else { 0.0 };
        (beside + nearest * slope).length() <= radius + 2.0_f64.sqrt() * self.half
    }

    /// Depths from the centre between which a ray, `beside` the centre at its depth, is inside of the body.
    fn chord(&self, beside: DVec2, slope: DVec2) -> Option<[f64; 2]> {
        match self.shape {
            Shape::Ball => {
                let (a, b) = (1.0 + slope.length_squared(), beside.dot(slope));
                let root = b * b - a * (beside.length_squared() - self.spread * self.spread);
                (root > 0.0).then(|| [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a])
            }
            Shape::Cube => {
                let back = self.rotation.transpose();
                let (from, along) = (back * beside.extend(0.0), back * DVec3::new(slope.x, slope.y, 1.0));
                let mut chord = [f64::NEG_INFINITY, f64::INFINITY];
                for axis in 0..3 {
                    if along[axis] == 0.0 {
                        if from[axis].abs() > self.spread {
                            return None;
                        }
                        continue;
                    }
                    let ends = [-1.0, 1.0].map(|side| (side * self.spread - from[axis]) / along[axis]);
                    chord[0] = chord[0].max(ends[0].min(ends[1]));
                    chord[1] = chord[1].min(ends[0].max(ends[1]));
                }
                (chord[0] < chord[1]).then_some(chord)
            }
        }
    }

    /// G: the chance that one render particle passes nearer than each of `depths`, ascending and counted from the
    /// centre's. The ray is `beside` (x right, y up, metres) the centre at its depth and goes on by `slope` a metre.
    /// Render particles exist only at depths within `range`. False if there is nothing to meet; `shares` are then 0.
    ///
    /// Exact for a point of the sprite; the square is summed over the middles of the weights' cells. Without a spread
    /// all are at the centre. A spread that is not 0 must not be much smaller than a cell.
    pub fn shares(&self, beside: DVec2, slope: DVec2, range: [f64; 2], depths: &[f64], shares: &mut [f64]) -> bool {
        shares.fill(0.0);
        if !self.touches(beside, slope) {
            return false;
        }
        if self.spread == 0.0 {
            let chance = self.fill * self.weights.at(beside.x / self.half, -beside.y / self.half);
            let exists = range[0] <= 0.0 && range[1] >= 0.0;
            depths.iter().zip(shares).filter(|(z, _)| exists && **z > 0.0).for_each(|(_, g)| *g = chance);
            return true;
        }
        // Between its ends, a chord's share grows evenly: sums of its slope, of where it began, and of what is complete.
        let mut steps = vec![[0.0; 3]; depths.len() + 1];
        for &([u, v], weight) in self.weights.passing() {
            let from = beside - self.half * DVec2::new(u, -v);
            let Some([start, end]) = self.chord(from, slope) else { continue };
            let (start, end) = (start.max(range[0]), end.min(range[1]));
            if start < end {
                let [first, last] = [start, end].map(|z| depths.partition_point(|depth| *depth <= z));
                steps[first][0] += weight;
                steps[first][1] += weight * start;
                steps[last][0] -= weight;
                steps[last][1] -= weight * start;
                steps[last][2] += weight * (end - start);
            }
        }
        let volume = match self.shape {
            Shape::Ball => 4.0 / 3.0 * std::f64::consts::PI * self.spread.powi(3),
            Shape::Cube => 8.0 * self.spread.powi(3),
        };
        let scale = self.fill * self.weights.cell() * self.half * self.half / volume;
        let mut sum = [0.0; 3];
        for ((share, depth), step) in shares.iter_mut().zip(depths).zip(steps) {
            (0..3).for_each(|i| sum[i] += step[i]);
            *share = scale * (sum[0] * depth - sum[1] + sum[2]);
        }
        true
    }
}

/// ln(1 - G), at least [`FLOOR`].
pub fn logarithm(share: f64) -> f64 {
    if share < 1.0 - FLOOR.exp() { (-share).ln_1p().min(0.0) } else { FLOOR }
}

/// The table of ln(1 - G) over class, `up`, `right` (metres beside the centre) and `depths` (ascending), the last one
/// fastest, for rays along the view axis. A class is a body.
pub fn table(bodies: &[Body], right: &[f64], up: &[f64], depths: &[f64]) -> Vec<f64> {
    let mut values = vec![0.0; bodies.len() * up.len() * right.len() * depths.len()];
    let always = [f64::NEG_INFINITY, f64::INFINITY];
    for (i, row) in values.chunks_mut(depths.len()).enumerate() {
        let (x, y) = (right[i % right.len()], up[i / right.len() % up.len()]);
        bodies[i / right.len() / up.len()].shares(DVec2::new(x, y), DVec2::ZERO, always, depths, row);
        row.iter_mut().for_each(|share| *share = logarithm(*share));
    }
    values
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::flame::reference::mask::{Mask, SIDE};

    const ALWAYS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    fn disc(side: usize) -> Weights {
        Weights::new(&Mask::from_texels(vec![1.0; SIDE * SIDE]), 0, 1.0, 0.0, side)
    }

    fn body(weights: &Weights) -> Body<'_> {
        Body { weights, fill: 1.0, half: 0.7, spread: 1.0, shape: Shape::Ball, rotation: DMat3::IDENTITY }
    }

    /// Area common to circles of radius a and b whose centres are d apart.
    fn lens(a: f64, b: f64, d: f64) -> f64 {
        if d >= a + b {
            return 0.0;
        }
        if d <= (a - b).abs() {
            return PI * a.min(b).powi(2);
        }
        let angle = |a: f64, b: f64| ((d * d + a * a - b * b) / (2.0 * d * a)).acos();
        let (s, t) = (angle(a, b), angle(b, a));
        a * a * (s - s.sin() * s.cos()) + b * b * (t - t.sin() * t.cos())
    }

    /// G by integrating lenses over depth: the closed form for a disc and a ball, along a slanted ray.
    fn by_lenses(half: f64, beside: DVec2, slope: DVec2, depth: f64) -> f64 {
        let n = 20_000;
        let step = (depth + 1.0) / f64::from(n);
        let area = |i| {
            let z = -1.0 + (f64::from(i) + 0.5) * step;
            lens((1.0 - z * z).sqrt(), half, (beside + z * slope).length())
        };
        (0..n).map(area).sum::<f64>() * step / (4.0 / 3.0 * PI)
    }

    #[test]
    fn discs_and_balls_meet_in_lenses() {
        let weights = disc(256);
        let depths = [-1.0, -0.6, 0.0, 0.37, 1.0];
        for (beside, slope) in [(0.0, 0.0), (0.5, 0.0), (1.2, 0.0), (0.3, 0.5), (1.1, -0.8), (1.69, 0.0), (2.5, 0.0)] {
            let (beside, slope) = (DVec2::new(0.6, -0.8) * beside, DVec2::new(0.8, 0.6).lerp(DVec2::X, 0.3) * slope);
            let mut shares = [0.0; 5];
            body(&weights).shares(beside, slope, ALWAYS, &depths, &mut shares);
            for (depth, share) in depths.into_iter().zip(shares) {
                let exact = by_lenses(0.7, beside, slope, depth);
                assert!((share - exact).abs() < 1e-5, "{beside} {slope} {depth}: {share} {exact}");
            }
        }
    }

    #[test]
    fn a_cube_along_the_axes_fills_evenly() {
        let weights = Weights::from_values(vec![1.0; 128 * 128], 128);
        let cube = Body { shape: Shape::Cube, half: 0.5, ..body(&weights) };
        let mut shares = [0.0; 4];
        // Half of the sprite beside the cube: (1 x 1/2) of 2 x 2.
        cube.shares(DVec2::new(1.0, 0.2), DVec2::ZERO, ALWAYS, &[-2.0, -0.5, 0.0, 3.0], &mut shares);
        let expected = [0.0, 1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0];
        assert!((0..4).all(|i| (shares[i] - expected[i]).abs() < 1e-12), "{shares:?}");
        assert_eq!(cube.reach(), 1.0);
        // Turned by 45 degrees about the vertical: reaches farther, and holds as much.
        let turned = Body { rotation: DMat3::from_rotation_y(PI / 4.0), ..cube };
        assert!((turned.reach() - 2.0_f64.sqrt()).abs() < 1e-12);
        let chord = turned.chord(DVec2::ZERO, DVec2::ZERO).unwrap();
        assert!((chord[1] - 2.0_f64.sqrt()).abs() < 1e-12 && (chord[0] + chord[1]).abs() < 1e-12);
        // A ray along a face's diagonal has the chance of being met that its chords say.
        turned.shares(DVec2::ZERO, DVec2::ZERO, ALWAYS, &[-9.0, -0.1, 0.0, 9.0], &mut shares);
        let chords = 4.0 * (0.5 * 2.0_f64.sqrt() - 0.125);
        assert!((shares[3] - chords / 8.0).abs() < 1e-4, "{shares:?} {}", chords / 8.0);
    }

    #[test]
    fn planes_cut_and_points_step() {
        let weights = disc(128);
        let mut whole = [0.0; 3];
        let mut cut = [0.0; 3];
        let depths = [-0.5, 0.0, 2.0];
        body(&weights).shares(DVec2::ZERO, DVec2::ZERO, ALWAYS, &depths, &mut whole);
        body(&weights).shares(DVec2::ZERO, DVec2::ZERO, [-0.5, 0.5], &depths, &mut cut);
        assert!(cut[0] == 0.0 && (cut[1] - (whole[1] - whole[0])).abs() < 1e-12);
        assert!((cut[2] - 2.0 * cut[1]).abs() < 1e-12);
        let point = Body { spread: 0.0, fill: 0.25, ..body(&weights) };
        point.shares(DVec2::new(0.3, 0.3), DVec2::ONE, ALWAYS, &depths, &mut whole);
        assert_eq!(whole, [0.0, 0.0, 0.25]);
        assert!(!point.shares(DVec2::new(3.0, 0.3), DVec2::ZERO, ALWAYS, &depths, &mut whole));
    }

    #[test]
    fn logarithms_keep_their_digits() {
        assert_eq!([0.0, 1.0, 1.0 + 1e-9, 1.0 - 1e-12].map(logarithm), [0.0, FLOOR, FLOOR, FLOOR]);
        assert!((logarithm(1e-12) + 1e-12).abs() < 1e-23);
        assert!((logarithm(1.0 - 1e-9) + 20.723).abs() < 1e-3);
    }

    #[test]
    fn tables_hold_the_classes_in_order() {
        let weights = disc(64);
        let bodies = [body(&weights), Body { fill: 0.5, ..body(&weights) }];
        let (right, up, depths) = ([-0.4, 0.0, 0.6], [0.1, 0.2], [-1.0, -0.2, 0.5, 1.0]);
        let values = table(&bodies, &right, &up, &depths);
        assert_eq!(values.len(), 48);
        let mut shares = [0.0; 4];
        bodies[1].shares(DVec2::new(0.6, 0.1), DVec2::ZERO, ALWAYS, &depths, &mut shares);
        assert_eq!(values[24 + 8..24 + 12], shares.map(logarithm));
        assert!(values.chunks(4).all(|row| row.is_sorted_by(|a, b| a >= b)));
    }
}
