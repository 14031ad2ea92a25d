//! The volume as the references read it: occupancy, cells, velocity.

use glam::DVec3;

/// A volume of voxel-centred density and, if there is one, velocity.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// Number of voxels along x, y and z.
    pub dimensions: [u32; 3],
    /// Sides of a voxel in metres, > 0.
    pub voxel_size: [f32; 3],
    /// Lower corner of the volume in metres.
    pub origin: [f32; 3],
    /// Density, x fastest; as many as there are voxels.
    pub density: &'a [f32],
    /// Velocity in metres per second, x fastest; as many as there are voxels.
    pub velocity: Option<&'a [[f32; 3]]>,
}

impl Grid<'_> {
    /// No voxel.
    pub const EMPTY: Grid<'static> =
        Grid { dimensions: [0; 3], voxel_size: [0.0; 3], origin: [0.0; 3], density: &[], velocity: None };

    /// Is the density of voxel (x, y, z) above `threshold`? NaN and everything outside of the volume is empty.
    pub fn occupied(&self, x: i64, y: i64, z: i64, threshold: f32) -> bool {
        self.density_of([x, y, z]).is_some_and(|density| density > threshold)
    }

    /// Density of a voxel; none outside of the volume.
    pub fn density_of(&self, voxel: [i64; 3]) -> Option<f32> {
        self.index(voxel).and_then(|i| self.density.get(i)).copied()
    }

    /// The voxel that holds `p`: `floor((p - origin) / voxel_size)` as in exact arithmetic on the f32 values;
    /// none outside of the volume.
    pub fn cell(&self, p: [f32; 3]) -> Option<[i64; 3]> {
        let mut cell = [0; 3];
        for axis in 0..3 {
            let [p, origin, h] = [p[axis], self.origin[axis], self.voxel_size[axis]].map(f64::from);
            if !p.is_finite() {
                return None;
            }
            let count = i64::from(self.dimensions[axis]);
            // The rounded quotient may be one cell off; the exact comparisons settle it.
            let mut q = ((p - origin) / h).floor().clamp(-1.0, count as f64) as i64;
            while q >= 0 && sum_is_negative(p, -origin, -(q as f64) * h) {
                q -= 1;
            }
            while q < count && !sum_is_negative(p, -origin, -((q + 1) as f64) * h) {
                q += 1;
            }
            if !(0..count).contains(&q) {
                return None;
            }
            cell[axis] = q;
        }
        Some(cell)
    }

    /// Smallest side of a voxel in metres.
    pub fn smallest_side(&self) -> f64 {
        self.voxel_size.iter().copied().fold(f32::INFINITY, f32::min).into()
    }

    /// Velocity at `p` in metres per second: trilinear between voxel centres, outside the outermost centres theirs;
    /// components that are not finite read as 0. Without a velocity grid 0.
    pub fn velocity_at(&self, p: DVec3) -> DVec3 {
        let Some(velocity) = self.velocity else { return DVec3::ZERO };
        let mut low = [0_i64; 3];
        let mut share = [0.0; 3];
        for axis in 0..3 {
            let last = f64::from(self.dimensions[axis].saturating_sub(1));
            let u = (p[axis] - f64::from(self.origin[axis])) / f64::from(self.voxel_size[axis]) - 0.5;
            let u = if u.is_nan() { 0.0 } else { u.clamp(0.0, last) };
            low[axis] = u.floor() as i64;
            share[axis] = u - u.floor();
        }
        let mut sum = DVec3::ZERO;
        for corner in 0..8 {
            let upper = [0, 1, 2].map(|axis| (corner >> axis) & 1 == 1);
            let weight: f64 = (0..3).map(|axis| if upper[axis] { share[axis] } else { 1.0 - share[axis] }).product();
            // A weight of 0 is also how the last voxel's missing upper neighbour drops out.
            if weight > 0.0 {
                let voxel = [0, 1, 2].map(|axis| low[axis] + i64::from(upper[axis]));
                let v = self.index(voxel).and_then(|i| velocity.get(i)).copied().unwrap_or_default();
                sum += weight * DVec3::from(v.map(|c| if c.is_finite() { f64::from(c) } else { 0.0 }));
            }
        }
        sum
    }

    /// Place of a voxel in `density`; none outside of the volume.
    fn index(&self, voxel: [i64; 3]) -> Option<usize> {
        let [nx, ny, nz] = self.dimensions.map(i64::from);
        let [x, y, z] = voxel;
        let inside = (0..nx).contains(&x) && (0..ny).contains(&y) && (0..nz).contains(&z);
        inside.then(|| ((z * ny + y) * nx + x) as usize)
    }
}

/// Is `a + b + c` below 0, without rounding? The expansion of the sum (Shewchuk 1997, grow-expansion) has the sign of
/// its largest term; a sum that rounds to 0 is 0, which leaves the smallest. The products that [`Grid::cell`] passes are
/// exact: 24 bits times an index below 2^29.
fn sum_is_negative(a: f64, b: f64, c: f64) -> bool {
    let (high, low) = two_sum(a, b);
    let (carry, smallest) = two_sum(c, low);
    let largest = carry + high;
    if largest != 0.0 { largest < 0.0 } else { smallest < 0.0 }
}

/// The rounded sum and what rounding took off (Knuth's two-sum).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(origin: f32, h: f32, n: u32) -> Grid<'static> {
        Grid {
            dimensions: [n, 1, 1],
            voxel_size: [h, 1.0, 1.0],
            origin: [origin, 0.0, 0.0],
            density: &[],
            velocity: None,
        }
    }

    fn cell_x(origin: f32, h: f32, n: u32, x: f32) -> Option<i64> {
        line(origin, h, n).cell([x, 0.5, 0.5]).map(|cell| cell[0])
    }

    #[test]
    fn cell_is_exact_where_rounding_would_be_wrong() {
        // 1 - 1e-30 lies in cell 0, though it rounds to 1 even in f64; 1 + 1e-30 lies in cell 1.
        assert_eq!(cell_x(1e-30, 1.0, 4, 1.0), Some(0));
        assert_eq!(cell_x(-1e-30, 1.0, 4, 1.0), Some(1));
        assert_eq!(cell_x(0.0, 1.0, 4, 1.0), Some(1));
        // Outside by the smallest amount.
        assert_eq!(cell_x(1e-30, 1.0, 4, 0.0), None);
        assert_eq!(cell_x(0.0, 1.0, 4, 4.0), None);
        assert_eq!(cell_x(1e-30, 1.0, 4, 4.0), Some(3));
        assert_eq!(cell_x(0.0, 1.0, 4, f32::NAN), None);
        assert_eq!(cell_x(0.0, 1.0, 4, f32::INFINITY), None);
    }

    #[test]
    fn cell_agrees_with_integer_arithmetic() {
        // All three are multiples of 2^-40, so that i128 holds everything exactly.
        let fixed = |v: f32| (f64::from(v) * (1_u64 << 40) as f64) as i128;
        for i in 0..20_000_u32 {
            let random = |d| crate::random::unit(crate::random::hash(1, i, 0, d));
            let (origin, h) = (random(0) * 8.0 - 4.0, 0.01 + random(1) * 0.1);
            // On the face as f32 arithmetic has it: the hard case.
            let x = origin + (random(2) * 200.0).floor() * h;
            let expected = (fixed(x) - fixed(origin)).div_euclid(fixed(h)) as i64;
            let expected = (0..200).contains(&expected).then_some(expected);
            assert_eq!(cell_x(origin, h, 200, x), expected, "origin {origin}, h {h}, x {x}");
        }
    }

    #[test]
    fn empty_is_what_is_not_above_the_threshold() {
        let density = [f32::NAN, 0.1, 0.2, f32::INFINITY, f32::NEG_INFINITY];
        let grid = Grid { density: &density, ..line(0.0, 1.0, 5) };
        let occupied: Vec<bool> = (-1..6).map(|x| grid.occupied(x, 0, 0, 0.1)).collect();
        assert_eq!(occupied, [false, false, false, true, true, false, false]);
    }

    #[test]
    fn velocity_is_linear_between_centres_constant_outside_and_finite() {
        let velocity = [[1.0, f32::NAN, 0.0], [3.0, 4.0, f32::INFINITY]];
        let grid = Grid { velocity: Some(&velocity), ..line(10.0, 2.0, 2) };
        let at = |x| grid.velocity_at(DVec3::new(x, 0.3, 0.9));
        assert_eq!(at(11.0), DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(at(12.0), DVec3::new(2.0, 2.0, 0.0));
        assert_eq!(at(12.5), DVec3::new(2.5, 3.0, 0.0));
        assert_eq!(at(-100.0), at(11.0));
        assert_eq!(at(100.0), at(13.0));
    }
}
