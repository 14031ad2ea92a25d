//! Random draws of a render particle: a pure function of seed, particle, sample, repetition and flicker.

use crate::flame::params::{PHASE_KEY, RENEWAL, SOBOL_KEY, sobol_bits};
use crate::flame::settings::{Sampling, Settings, Shape};
use crate::random::{hash, pcg, unit};

/// The values that all draws of a frame depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draws {
    seed: u32,
    shape: Shape,
    sampling: Sampling,
    /// Bits of the index into the Sobol sequence.
    bits: u32,
    /// Frames times the share of draws that a frame renews, in 65536ths.
    flickered: u64,
}

/// The random draws of a render particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Offset along the world's axes in spreads, each from -1 to 1; in the unit ball unless the shape is a cube.
    pub offset: [f64; 3],
    /// Upper half: variant of the mask; lower half: quantile of alphas.
    pub mask: u32,
}

impl Draws {
    /// Draws of frame `number`.
    pub fn new(settings: &Settings, seed: u32, number: u32) -> Draws {
        Draws {
            seed,
            shape: settings.shape,
            sampling: settings.sampling,
            bits: sobol_bits(settings.repetitions),
            flickered: u64::from(number) * (f64::from(settings.flicker) * 65536.0).round() as u64,
        }
    }

    /// How often render particle `k` of particle `id` has been drawn anew. Each has its own phase.
    pub fn generation(&self, id: u32, k: u32) -> u32 {
        if self.flickered == 0 {
            return 0;
        }
        let phase = u64::from(hash(self.seed, id, k, PHASE_KEY) >> 16);
        ((self.flickered >> 16) + (((self.flickered & 0xFFFF) + phase) >> 16)) as u32
    }

    /// The draw of render particle `k` of particle `id` in a repetition.
    pub fn draw(&self, id: u32, k: u32, repetition: u32) -> Draw {
        let renewed = self.generation(id, k).wrapping_mul(RENEWAL);
        let word = hash(self.seed, id, k, repetition).wrapping_add(renewed);
        let u = match self.sampling {
            Sampling::Independent => [0, 1, 2].map(|dimension: u32| unit(pcg(dimension.wrapping_add(word)))),
            Sampling::ShuffledSobol => {
                let seed = hash(self.seed, id, k, SOBOL_KEY).wrapping_add(renewed);
                sobol_point(seed, self.bits, repetition)
            }
        };
        Draw { offset: offset(self.shape, u.map(f64::from)), mask: pcg(word.wrapping_add(3)) }
    }
}

/// Three uniform numbers in (0, 1) as an offset: uniform in the unit ball, or in the cube from -1 to 1.
fn offset(shape: Shape, u: [f64; 3]) -> [f64; 3] {
    match shape {
        Shape::Cube => u.map(|u| 2.0 * u - 1.0),
        Shape::Ball => {
            let z = 1.0 - 2.0 * u[0];
            let across = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
            let (sin, cos) = (std::f64::consts::TAU * u[1]).sin_cos();
            let rho = u[2].cbrt();
            [rho * across * cos, rho * across * sin, rho * z]
        }
    }
}

/// Number `index` of the three-dimensional Sobol sequence in 32 bits: van der Corput; x + 1; x^2 + x + 1 with m = 1, 3
/// (the first dimensions of Joe and Kuo 2008).
pub fn sobol(index: u32) -> [u32; 3] {
    let mut direction = [1 << 31; 3];
    let mut before = 0;
    let mut point = [0; 3];
    for bit in 0..32 {
        if index >> bit & 1 == 1 {
            (0..3).for_each(|d| point[d] ^= direction[d]);
        }
        let third = if bit == 0 { 3 << 30 } else { direction[2] ^ before ^ (before >> 2) };
        before = direction[2];
        direction = [direction[0] >> 1, direction[1] ^ (direction[1] >> 1), third];
    }
    point
}

/// Owen scrambling: each bit is flipped depending on all bits above it (Laine, Karras 2011; the constants are Vegdahl's).
pub fn scrambled(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3D20_ADEA);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6C56);
    x ^= x.wrapping_mul(0x53A2_2864);
    x.reverse_bits()
}

/// Point `repetition` of the sequence that belongs to `seed`: its order shuffled, so that sequences of different seeds
/// are independent, its coordinates scrambled. Every aligned power of two of repetitions up to 2^bits is a net.
pub fn sobol_point(seed: u32, bits: u32, repetition: u32) -> [f32; 3] {
    let index = scrambled(repetition, pcg(seed)) & ((1 << bits) - 1);
    let point = sobol(index);
    [0, 1, 2].map(|d: u32| unit(scrambled(point[d as usize], pcg(seed.wrapping_add(1 + d)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws(shape: Shape, sampling: Sampling, flicker: f32, number: u32) -> Draws {
        let settings = Settings { shape, sampling, flicker, repetitions: 64, ..Settings::light() };
        Draws::new(&settings, 9, number)
    }

    #[test]
    fn the_sequence_begins_as_published() {
        let share = |x: u32| f64::from(x) / 4_294_967_296.0;
        let expected =
            [[0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.25, 0.75, 0.75], [0.75, 0.25, 0.25], [0.125, 0.625, 0.375]];
        for (index, point) in expected.into_iter().enumerate() {
            assert_eq!(sobol(index as u32).map(share), point, "{index}");
        }
        assert_eq!(sobol(5).map(share), [0.625, 0.125, 0.875]);
        assert_eq!(sobol(6).map(share), [0.375, 0.375, 0.625]);
        assert_eq!(sobol(7).map(share), [0.875, 0.875, 0.125]);
    }

    #[test]
    fn scrambling_is_nested() {
        for seed in [0, 1, 0x8000_0001, 0xDEAD_BEEF, u32::MAX] {
            for i in 0..200 {
                let x = pcg(i);
                for bit in 0..32 {
                    // Numbers that agree above a bit and differ in it still do so, there.
                    let differ = scrambled(x, seed) ^ scrambled(x ^ (1 << bit), seed);
                    assert_eq!(differ.leading_zeros(), 31 - bit);
                }
            }
        }
    }

    /// How many points lie in each of the boxes of 2^-a x 2^-b x 2^-c.
    fn boxes(points: &[[f32; 3]], sides: [u32; 3]) -> Vec<u32> {
        let mut boxes = vec![0; 1 << sides.iter().sum::<u32>()];
        for point in points {
            let place = (0..3).fold(0, |place, d| (place << sides[d]) | (point[d] * (1 << sides[d]) as f32) as usize);
            boxes[place] += 1;
        }
        boxes
    }

    #[test]
    fn aligned_powers_of_two_are_nets() {
        for seed in 0..20 {
            let points: Vec<[f32; 3]> = (0..64).map(|j| sobol_point(pcg(seed), 6, j)).collect();
            for (start, length, m) in [(0, 64, 6), (0, 32, 5), (32, 32, 5), (16, 16, 4), (40, 8, 3)] {
                let part = &points[start..start + length];
                for axis in 0..3 {
                    let mut sides = [0; 3];
                    sides[axis] = m;
                    assert!(boxes(part, sides).iter().all(|n| *n == 1), "{seed} {start} {length} {axis}");
                }
                // The first two dimensions are a (0, m, 2)-net.
                assert!((0..=m).all(|a| boxes(part, [a, m - a, 0]).iter().all(|n| *n == 1)));
            }
            // All three: t = 1 for the polynomials x, x + 1, x^2 + x + 1.
            for (a, b) in (0..=5).flat_map(|a| (0..=5 - a).map(move |b| (a, b))) {
                assert!(boxes(&points, [a, b, 5 - a - b]).iter().all(|n| *n == 2), "{a} {b}");
            }
        }
    }

    #[test]
    fn sequences_are_shuffled() {
        // Products of the first coordinates of two sequences in the same repetition: as of independent numbers.
        let mean_product = |bits: u32, n: u32| {
            let products = (0..400_u32).flat_map(|pair| {
                (0..n).map(move |j| {
                    let [a, b] = [0, 1].map(|i| sobol_point(pcg(2 * pair + i), bits, j)[0] - 0.5);
                    f64::from(a * b)
                })
            });
            products.sum::<f64>() / f64::from(400 * n)
        };
        let deviation = 1.0 / 12.0 / (400.0 * 64.0_f64).sqrt();
        // Exactly balanced numbers are correlated by 1 / n at most: the bound is generous.
        assert!(mean_product(6, 64).abs() < 8.0 * deviation);
    }

    #[test]
    fn offsets_fill_their_shape_evenly() {
        for sampling in [Sampling::Independent, Sampling::ShuffledSobol] {
            for shape in [Shape::Ball, Shape::Cube] {
                let draws = draws(shape, sampling, 0.0, 0);
                let offsets: Vec<[f64; 3]> =
                    (0..500).flat_map(|id| (0..64).map(move |j| draws.draw(id, id % 7, j).offset)).collect();
                let inner = offsets.iter().filter(|o| match shape {
                    Shape::Ball => o.iter().map(|c| c * c).sum::<f64>() < 0.25,
                    Shape::Cube => o.iter().all(|c| c.abs() < 0.5),
                });
                // An eighth of the volume. Binomial: deviation 59 of 4000.
                let inner = inner.count();
                assert!((3700..4300).contains(&inner), "{inner}");
                let octants = offsets.iter().fold([0; 8], |mut n: [u32; 8], o| {
                    n[(0..3).map(|a| usize::from(o[a] > 0.0) << a).sum::<usize>()] += 1;
                    n
                });
                assert!(octants.iter().all(|n| (3700..4300).contains(n)), "{octants:?}");
                let second = offsets.iter().map(|o| o[2] * o[2]).sum::<f64>() / offsets.len() as f64;
                let expected = if shape == Shape::Ball { 0.2 } else { 1.0 / 3.0 };
                assert!((second - expected).abs() < 0.01);
            }
        }
    }

    #[test]
    fn draws_have_their_definition() {
        let draw = draws(Shape::Cube, Sampling::Independent, 0.0, 77).draw(5, 3, 2);
        let word = hash(9, 5, 3, 2);
        assert_eq!(draw.mask, pcg(word.wrapping_add(3)));
        assert_eq!(draw.offset[1], 2.0 * f64::from(unit(pcg(word.wrapping_add(1)))) - 1.0);
    }

    #[test]
    fn flicker_renews_its_share_of_draws() {
        for sampling in [Sampling::Independent, Sampling::ShuffledSobol] {
            let draw = |flicker, number, id| draws(Shape::Ball, sampling, flicker, number).draw(id, 1, 4);
            for number in 0..8 {
                let renewed = |flicker| {
                    let differs = |id: &u32| draw(flicker, number, *id) != draw(flicker, number + 1, *id);
                    (0..4000).filter(differs).count()
                };
                assert_eq!(renewed(0.0), 0);
                assert_eq!(renewed(1.0), 4000);
                assert!((850..1150).contains(&renewed(0.25)));
            }
        }
        // Frames far apart do not overflow.
        let late = draws(Shape::Ball, Sampling::Independent, 1.0, u32::MAX);
        assert!([u32::MAX, u32::MAX - 1].contains(&late.generation(3, 3)));
    }
}
