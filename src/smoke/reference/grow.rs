//! Radius of a particle: the paper's growing box (section 3.1, figure 2c) in closed form.

use super::grid::Grid;
use crate::smoke::settings::Radius;

/// Radius in metres of the sphere of a particle at `p`, before `scale` and fade: the distance to the nearest centre of
/// an empty voxel, in the chessboard norm (`Box`) or the Euclidean one (`Ball`); 0 in an empty voxel and outside.
///
/// Brute force: every voxel is looked at, the infinitely many empty ones outside of the volume included. Of those the
/// layer around the volume is enough: move an outside voxel q to the nearest place of the box that the layer bounds,
/// that is clamp each index to -1..=n. An axis on which q is outside stays outside, so the new voxel is empty too.
/// And on no axis has its centre gone farther from p: p lies between the layer's two centres, and q was beyond one
/// of them or has not moved. Both norms grow with each axis' distance, so the layer's voxel is at least as near.
pub fn radius(grid: &Grid, threshold: f32, p: [f32; 3], kind: Radius) -> f64 {
    let Some([x, y, z]) = grid.cell(p) else { return 0.0 };
    if !grid.occupied(x, y, z, threshold) {
        return 0.0;
    }
    let norm = |d: [f64; 3]| match kind {
        Radius::Box => d[0].max(d[1]).max(d[2]),
        Radius::Ball => (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt(),
    };
    let distance = |axis: usize, q: i64| {
        let centre = (q as f64 + 0.5) * f64::from(grid.voxel_size[axis]);
        (f64::from(p[axis]) - f64::from(grid.origin[axis]) - centre).abs()
    };
    let [nx, ny, nz] = grid.dimensions.map(i64::from);
    let mut nearest = f64::INFINITY;
    for z in -1..=nz {
        for y in -1..=ny {
            let (dy, dz) = (distance(1, y), distance(2, z));
            // No voxel of this row can be nearer than the row itself.
            if norm([0.0, dy, dz]) >= nearest {
                continue;
            }
            for x in -1..=nx {
                if !grid.occupied(x, y, z, threshold) {
                    nearest = nearest.min(norm([distance(0, x), dy, dz]));
                }
            }
        }
    }
    nearest
}

/// Chessboard distance of every voxel to the nearest empty one (outside included) in voxels, x fastest; 0 where empty.
/// Looks at whole cubes, larger and larger, as the paper's loop does.
pub fn chessboard_field(grid: &Grid, threshold: f32) -> Vec<u32> {
    let [nx, ny, nz] = grid.dimensions.map(i64::from);
    let mut field = Vec::with_capacity(grid.density.len());
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let full = |d: i64| {
                    (z - d..=z + d)
                        .all(|c| (y - d..=y + d).all(|b| (x - d..=x + d).all(|a| grid.occupied(a, b, c, threshold))))
                };
                // Ends: a cube larger than the volume sticks out of it.
                field.push((0..).take_while(|d| full(*d)).count() as u32);
            }
        }
    }
    field
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};

    fn grid(dimensions: [u32; 3], voxel_size: [f32; 3], density: &[f32]) -> Grid<'_> {
        Grid { dimensions, voxel_size, origin: [-1.0, 2.0, 0.5], density, velocity: None }
    }

    fn random_density(count: usize, share: f32, seed: u32) -> Vec<f32> {
        (0..count).map(|i| if unit(hash(seed, i as u32, 0, 0)) < share { 1.0 } else { 0.0 }).collect()
    }

    #[test]
    fn at_voxel_centres_the_radius_is_the_chessboard_distance() {
        // Sides and origin are powers of two: everything is exact.
        let density = random_density(9 * 8 * 7, 0.995, 1);
        let grid = grid([9, 8, 7], [0.25; 3], &density);
        let field = chessboard_field(&grid, 0.5);
        assert!(field.iter().any(|d| *d >= 3), "the volume has no depth");
        for (i, distance) in field.iter().enumerate() {
            let voxel = [i % 9, i / 9 % 8, i / 72];
            let p = [0, 1, 2].map(|a| grid.origin[a] + (voxel[a] as f32 + 0.5) * 0.25);
            assert_eq!(radius(&grid, 0.5, p, Radius::Box), f64::from(*distance) * 0.25, "voxel {voxel:?}");
        }
    }

    #[test]
    fn a_full_cube_gives_the_distance_to_the_layer_around_it() {
        let density = [1.0; 27];
        let grid = grid([3; 3], [1.0; 3], &density);
        // Centre of the cube: two voxels to the layer's centres, along one axis in either norm.
        assert_eq!(radius(&grid, 0.5, [0.5, 3.5, 2.0], Radius::Box), 2.0);
        assert_eq!(radius(&grid, 0.5, [0.5, 3.5, 2.0], Radius::Ball), 2.0);
        assert_eq!(radius(&grid, 0.5, [0.75, 3.5, 2.0], Radius::Box), 1.75);
        assert_eq!(radius(&grid, 0.5, [-1.5, 3.5, 2.0], Radius::Box), 0.0);
        assert_eq!(chessboard_field(&grid, 0.5)[13], 2);
    }

    #[test]
    fn the_nearest_empty_voxel_depends_on_the_norm_and_the_sides() {
        // 5 x 5 x 5, only voxel (3, 3, 2) is empty; the particle sits at the centre of (2, 2, 2).
        let mut density = [1.0; 125];
        density[2 * 25 + 3 * 5 + 3] = f32::NAN;
        let cubic = grid([5; 3], [1.0; 3], &density);
        assert_eq!(radius(&cubic, 0.5, [1.5, 4.5, 3.0], Radius::Box), 1.0);
        assert_eq!(radius(&cubic, 0.5, [1.5, 4.5, 3.0], Radius::Ball), 2.0_f64.sqrt());
        // With voxels of 1 : 4 : 1 the layers at +-3 along x and z are nearer than that voxel.
        let flat = grid([5; 3], [1.0, 4.0, 1.0], &density);
        assert_eq!(radius(&flat, 0.5, [1.5, 12.0, 3.0], Radius::Box), 3.0);
    }

    #[test]
    fn passing_over_rows_and_the_far_outside_changes_nothing() {
        let density = random_density(6 * 5 * 4, 0.9, 2);
        let grid = grid([6, 5, 4], [0.3, 0.7, 0.4], &density);
        for i in 0..300 {
            let random = |d| unit(hash(5, i, 0, d));
            let p = [-1.0 + random(0) * 1.8, 2.0 + random(1) * 3.5, 0.5 + random(2) * 1.6];
            for kind in [Radius::Box, Radius::Ball] {
                let mut expected = f64::INFINITY;
                let Some(cell) = grid.cell(p) else { continue };
                for (z, y, x) in (-4..9).flat_map(|z| (-4..9).flat_map(move |y| (-4..10).map(move |x| (z, y, x)))) {
                    let d: [f64; 3] = std::array::from_fn(|a| {
                        let h = f64::from(grid.voxel_size[a]);
                        (f64::from(p[a]) - f64::from(grid.origin[a]) - ([x, y, z][a] as f64 + 0.5) * h).abs()
                    });
                    if !grid.occupied(x, y, z, 0.5) {
                        expected = expected.min(match kind {
                            Radius::Box => d[0].max(d[1]).max(d[2]),
                            Radius::Ball => d.iter().map(|d| d * d).sum::<f64>().sqrt(),
                        });
                    }
                }
                let expected = if grid.occupied(cell[0], cell[1], cell[2], 0.5) { expected } else { 0.0 };
                assert_eq!(radius(&grid, 0.5, p, kind), expected, "{kind:?} at {p:?}");
            }
        }
    }
}
