//! Ken Perlin's improved noise (Perlin: Improving Noise, SIGGRAPH 2002) in f64.

/// His permutation.
#[rustfmt::skip]
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240,
    21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88,
    237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83,
    111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216,
    80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186,
    3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58,
    17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9,
    129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193,
    238, 210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157,
    184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128,
    195, 78, 66, 215, 61, 156, 180,
];

/// Improved noise, -1 to 1, period 256 along each axis, 0 at whole coordinates.
pub fn perlin(point: [f64; 3]) -> f64 {
    let cell = point.map(|c| c.floor() as i64);
    let at: [f64; 3] = std::array::from_fn(|axis| point[axis] - point[axis].floor());
    let fade = at.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let permute = |i: i64| i64::from(PERMUTATION[(i & 255) as usize]);
    let corner = |x: i64, y: i64, z: i64| {
        let h = permute(permute(permute(cell[0] + x) + cell[1] + y) + cell[2] + z);
        gradient(h & 15, [at[0] - x as f64, at[1] - y as f64, at[2] - z as f64])
    };
    let between = |t: f64, a: f64, b: f64| a + t * (b - a);
    let edge = |y, z| between(fade[0], corner(0, y, z), corner(1, y, z));
    let face = |z| between(fade[1], edge(0, z), edge(1, z));
    between(fade[2], face(0), face(1))
}

/// Dot product with one of the 12 directions to the edges of a cube; four of the 16 are there twice.
fn gradient(h: i64, p: [f64; 3]) -> f64 {
    let u = if h < 8 { p[0] } else { p[1] };
    let v = match h {
        0..4 => p[1],
        12 | 14 => p[0],
        _ => p[2],
    };
    (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};

    fn point(i: u32) -> [f64; 3] {
        std::array::from_fn(|axis| f64::from(unit(hash(1, i, 0, axis as u32))) * 256.0)
    }

    #[test]
    fn the_permutation_is_one() {
        let mut seen = PERMUTATION;
        seen.sort();
        assert!((0..=255).eq(seen));
    }

    #[test]
    fn has_its_known_values_and_period() {
        // By hand: in the middle of a cell, all weights are 1/2 and distances +-1/2.
        let corners = (0..8).map(|i: i64| {
            let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2];
            let permute = |i: i64| i64::from(PERMUTATION[(i & 255) as usize]);
            let h = permute(permute(permute(3 + x) + 4 + y) + 5 + z) & 15;
            gradient(h, [x, y, z].map(|c| 0.5 - c as f64)) / 8.0
        });
        assert!((perlin([3.5, 4.5, 5.5]) - corners.sum::<f64>()).abs() < 1e-15);
        assert_eq!(perlin([17.0, 250.0, 3.0]), 0.0);
        for i in 0..100 {
            let p = point(i);
            assert!((perlin(p) - perlin([p[0] - 256.0, p[1] + 512.0, p[2] + 256.0])).abs() < 1e-12);
        }
    }

    #[test]
    fn has_the_published_spread() {
        let values: Vec<f64> = (0..40_000).map(|i| perlin(point(i))).collect();
        let mean = values.iter().sum::<f64>() / 40_000.0;
        let deviation = (values.iter().map(|v| v * v).sum::<f64>() / 40_000.0).sqrt();
        assert!(mean.abs() < 0.01 && (deviation - 0.27).abs() < 0.005, "{mean} {deviation}");
        assert!(values.iter().all(|v| v.abs() <= 1.0));
    }

    #[test]
    fn is_smooth_across_cells() {
        for i in 0..200 {
            let mut p = point(i);
            p[i as usize % 3] = p[i as usize % 3].round();
            let step = |by: f64| perlin(std::array::from_fn(|a| p[a] + if a == i as usize % 3 { by } else { 0.0 }));
            let (left, right) = ((step(0.0) - step(-1e-6)) / 1e-6, (step(1e-6) - step(0.0)) / 1e-6);
            assert!((left - right).abs() < 1e-4, "{left} {right}");
        }
    }
}
