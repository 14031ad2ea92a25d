//! The density, smoothed before the threshold cuts it.

use std::borrow::Cow;

use super::grid::Grid;
use crate::smoke::settings::Settings;

/// Widest Gaussian, in sides of a voxel, its window, and its width, in standard deviations.
const MOST: f64 = 16.0;
const CUTOFF: f64 = 3.0;
const WIDTH: f64 = 2.0;

/// Width in metres, two standard deviations; 0 if nothing is smoothed.
pub fn width(grid: &Grid, settings: &Settings) -> f64 {
    let [x, y, z] = grid.voxel_size.map(f64::from);
    let automatic = || (y * f64::from(grid.dimensions[1]) / 40.0).max(x.max(y).max(z)).min(MOST * x.min(y).min(z));
    settings.detail.map_or_else(automatic, f64::from)
}

/// The density of each voxel: along each axis the mean of those within `ceil(3 s)` voxels, with weights exp(-d^2 / 2 s^2)
/// for d voxels and a standard deviation of s. Voxels outside of the volume and what is not finite count as 0.
pub fn smoothed<'a>(grid: &Grid<'a>, settings: &Settings) -> Cow<'a, [f32]> {
    let width = width(grid, settings);
    if width == 0.0 {
        return Cow::Borrowed(grid.density);
    }
    let finite = |density: &f32| if density.is_finite() { f64::from(*density) } else { 0.0 };
    let mut values: Vec<f64> = grid.density.iter().map(finite).collect();
    let [nx, ny, _] = grid.dimensions.map(|n| n as usize);
    for (axis, stride) in [1, nx, nx * ny].into_iter().enumerate() {
        values =
            along(&values, grid.dimensions[axis] as usize, stride, width / WIDTH / f64::from(grid.voxel_size[axis]));
    }
    values.into_iter().map(|value| value as f32).collect()
}

/// Along an axis of `count` voxels that are `stride` apart, by a deviation in voxels.
fn along(values: &[f64], count: usize, stride: usize, deviation: f64) -> Vec<f64> {
    // As f32 has it, so that both end their windows at the same voxel; of the widest, rounding may not add one.
    let window = (CUTOFF * f64::from(deviation as f32)).ceil().min(CUTOFF * MOST / WIDTH) as i64;
    let weight = |d: i64| (-0.5 * (d as f64 / deviation).powi(2)).exp();
    let all: f64 = (-window..=window).map(weight).sum();
    let mean = |(i, _): (usize, &f64)| {
        let at = (i / stride % count) as i64;
        let near = (-window..=window).filter(|d| (0..count as i64).contains(&(at + d)));
        near.map(|d| weight(d) * values[(i as i64 + d * stride as i64) as usize]).sum::<f64>() / all
    };
    values.iter().enumerate().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voxel_becomes_a_gaussian_and_what_is_not_finite_nothing() {
        let mut density = vec![0.0; 31 * 31 * 31];
        density[15 + 31 * (15 + 31 * 15)] = 1.0;
        density[0] = f32::NAN;
        density[1] = f32::INFINITY;
        let grid = Grid {
            dimensions: [31; 3],
            voxel_size: [1.0, 0.5, 2.0],
            origin: [0.0; 3],
            density: &density,
            velocity: None,
        };
        let settings = Settings { detail: Some(4.0), ..Settings::default() };
        let smooth = smoothed(&grid, &settings);
        let at = |x: usize, y: usize, z: usize| f64::from(smooth[x + 31 * (y + 31 * z)]);
        // The mass that the windows cut off along an axis is spread over the rest: 0.3 % at most, three times.
        assert!((smooth.iter().copied().map(f64::from).sum::<f64>() - 1.0).abs() < 0.01);
        for (x, y, z) in [(17, 15, 15), (15, 19, 15), (15, 15, 16)] {
            assert!((at(x, y, z) / at(15, 15, 15) - (-0.5_f64).exp()).abs() < 1e-6, "a deviation away: 2 m");
        }
        assert_eq!((at(0, 0, 0), at(15 + 7, 15, 15)), (0.0, 0.0));
        let none = Settings { detail: Some(0.0), ..Settings::default() };
        assert!(matches!(smoothed(&grid, &none), Cow::Borrowed(_)));
        assert_eq!(width(&grid, &Settings::default()), 2.0, "the largest side");
    }
}
