//! The limit of repetitions: the integral in f64, without a table and without noise, at some pixels.
//!
//! It shares neither table nor classes nor bins with the `expected` mode, and has no noise in common with repetitions:
//! it favours neither. That repetitions converge to it is what tests show; here each curve of repetitions shows it again,
//! down to the noise of its longest run.

use super::scene::{SEED, Scene};
use crate::bench::measure::Deviation;
use crate::bench::report::Accuracy;
use crate::flame::reference::expected::{Bins, render_at};
use crate::flame::reference::mask::Mask;
use crate::flame::reference::prepare::{Prepared, mask_level, prepare};
use crate::flame::reference::stochastic::Frame;
use crate::random::hash;

/// Depth bins; their error is a fourth of that of half as many.
const BINS: usize = 512;
/// Cells of a sprite's side.
const CELLS: usize = 64;
/// Pixels that are integrated, and with `--quick`.
const PIXELS: [usize; 2] = [6000, 600];
/// Of so many pixels, one is integrated once more, with half as many bins.
const CHECKED: usize = 16;
/// Where repetitions show fire less often than this, there is none.
const LEAST: f64 = 1e-3;

pub(super) struct Truth {
    /// Pixels, row by row from the top, and their linear RGB.
    pixels: Vec<(usize, [f64; 3])>,
    /// Root mean square of its own error.
    own: f64,
    /// Render particles of a repetition.
    pub(super) sprites: u64,
}

impl Truth {
    pub(super) fn new(scene: &Scene, quick: bool) -> Truth {
        let settings = &scene.settings;
        let positions = scene.particles.position.iter().zip(&scene.particles.temperature);
        let positions: Vec<[f32; 4]> = positions.map(|([x, y, z], kelvin)| [*x, *y, *z, *kelvin]).collect();
        let view = scene.camera.view(scene.size);
        let ids = scene.particles.id.as_deref();
        let Prepared { particles, nearest, .. } = prepare(settings, settings.hottest, SEED, &view, &positions, ids);
        let mask = Mask::new(SEED, settings.variants);
        let level = mask_level(settings, &view, scene.size, nearest);
        let size = scene.size;
        let frame = Frame { settings, seed: SEED, number: 0, view, size, scene: None, mask: &mask, level, base: 0.0 };
        let places = scene.places(PIXELS[usize::from(quick)]);
        let at = |bins, places: &[usize]| {
            render_at(&frame, &particles, Bins::around(&frame, &particles, bins), CELLS, places)
        };
        let truth = at(BINS, &places);
        let checked = &places[..places.len().div_ceil(CHECKED)];
        let half = at(BINS / 2, checked);
        let differences = half.mean.as_flattened().iter().zip(truth.mean.as_flattened());
        let difference = Deviation::of(differences.map(|(a, b)| a - b).collect());
        let own = difference.map_or(0.0, |difference| difference.rms / 3.0);
        let fire = places.into_iter().zip(truth.mean).zip(truth.coverage);
        let pixels = fire.filter(|(_, coverage)| *coverage >= LEAST).map(|(pixel, _)| pixel).collect();
        Truth { pixels, own, sprites: particles.iter().map(|p| u64::from(p.count)).sum() }
    }

    /// Of the channels of the mean colour, 0 to 1.
    pub(super) fn accuracy(&self, mean: &[[f32; 4]]) -> Accuracy {
        let difference = |(place, truth): &(usize, [f64; 3])| {
            let found = mean.get(*place).copied().unwrap_or([f32::NAN; 4]);
            [0, 1, 2].map(|channel| (f64::from(found[channel]) - truth[channel]).abs())
        };
        let differences = self.pixels.iter().flat_map(difference).collect();
        let of = format!(
            "f64 limit of repetitions, linear channels 0 to 1, at {} pixels with fire, own error {:.0e}",
            self.pixels.len(),
            self.own
        );
        Deviation::of(differences).map(|deviation| (deviation, of))
    }
}

impl Scene {
    /// So many pixels at random among those that a sprite may touch.
    fn places(&self, count: usize) -> Vec<usize> {
        let [width, height] = self.size.map(f64::from);
        let focal = height / 2.0 / self.camera.half_extent(self.size).y;
        let rotation = self.camera.rotation();
        let reach = f64::from(self.settings.spread.unwrap_or_default() + self.settings.sprite());
        let mut touched = vec![false; self.size[0] as usize * self.size[1] as usize];
        for position in &self.particles.position {
            let view = rotation * (glam::DVec3::from(position.map(f64::from)) - self.camera.eye);
            let radius = focal * reach / view.z;
            let middle = [width / 2.0 + focal * view.x / view.z, height / 2.0 - focal * view.y / view.z];
            let range = |axis: usize, side: f64| {
                let low = (middle[axis] - radius).clamp(0.0, side) as usize;
                low..(middle[axis] + radius).clamp(0.0, side) as usize
            };
            for y in range(1, height) {
                for x in range(0, width) {
                    let away = [x as f64 + 0.5 - middle[0], y as f64 + 0.5 - middle[1]];
                    touched[y * width as usize + x] |= away[0].hypot(away[1]) <= radius;
                }
            }
        }
        let touched = touched.into_iter().enumerate().filter(|(_, touched)| *touched);
        let mut places: Vec<usize> = touched.map(|(place, _)| place).collect();
        places.sort_by_key(|place| hash(3, *place as u32, 0, 0));
        places.truncate(count);
        places
    }
}
