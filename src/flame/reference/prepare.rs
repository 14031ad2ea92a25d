//! Each particle's values in a frame: number of render particles, alpha, colour; and what all have in common.

use glam::DVec2;

use super::mask;
use crate::flame::colour;
use crate::flame::params::{COUNT_KEY, LIGHT_STEPS, MOST_COUNT};
use crate::flame::settings::{Colour, Settings, Shape};
use crate::random::{hash, unit};
use crate::view::{FARTHEST, Projection, View};

/// A particle in a frame. Tests may put a device's numbers into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Place in the input.
    pub row: u32,
    /// The id that its draws depend on.
    pub id: u32,
    /// World position in metres.
    pub centre: [f32; 3],
    /// Alpha where the mask is 1.
    pub alpha: f64,
    /// Mean number of render particles in a repetition.
    pub mean_count: f64,
    /// Number of render particles in a repetition.
    pub count: u32,
    /// Linear RGB.
    pub colour: [f64; 3],
    /// The same in [`LIGHT_STEPS`] of the frame's largest component.
    pub light: [u32; 3],
    /// How what it draws is drawn out: as [`stretch`] has it. That is asked for beside the rest, where there are velocities.
    pub stretch: [f64; 2],
}

/// A frame's particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The valid ones: finite, none beyond [`FARTHEST`], and above 0 K.
    pub particles: Vec<Particle>,
    /// Largest component of any of their colours.
    pub brightest: f64,
    /// Smallest view depth of a centre that is not before the near plane; infinite without one.
    pub nearest: f64,
}

/// Prepares particles: position in metres and temperature in kelvin, of which those above `hottest` count as that hot.
/// `ids` are rows if they are not given.
pub fn prepare(
    settings: &Settings,
    hottest: f32,
    seed: u32,
    view: &View,
    positions: &[[f32; 4]],
    ids: Option<&[u32]>,
) -> Prepared {
    let mut particles = Vec::new();
    for (row, &[x, y, z, kelvin]) in positions.iter().enumerate() {
        let valid = [x, y, z].iter().all(|c| c.abs() <= FARTHEST) && kelvin.is_finite() && kelvin > 0.0;
        if valid {
            let id = ids.map_or(row as u32, |ids| ids[row]);
            let kelvin = f64::from(kelvin.min(hottest));
            let mean_count = mean_count(settings, kelvin);
            particles.push(Particle {
                row: row as u32,
                id,
                centre: [x, y, z],
                alpha: f64::from(settings.alpha_scale) * kelvin / f64::from(settings.hottest),
                mean_count,
                count: count(mean_count, seed, id),
                colour: colour(settings, kelvin),
                light: [0; 3],
                stretch: [0.0; 2],
            });
        }
    }
    let brightest = particles.iter().flat_map(|p| p.colour).fold(0.0, f64::max);
    particles.iter_mut().for_each(|p| p.light = p.colour.map(|c| light(c, brightest)));
    // Depth is the same whatever the picture's size.
    let projection = Projection::of_valid(view, [1, 1]);
    let depths = particles.iter().map(|p| projection.to_view(super::world(p.centre)).z);
    let nearest = depths.filter(|z| *z >= projection.near).fold(f64::INFINITY, f64::min);
    Prepared { particles, brightest, nearest }
}

/// Mean number of render particles in a repetition at a temperature.
pub fn mean_count(settings: &Settings, kelvin: f64) -> f64 {
    (f64::from(settings.count) * kelvin / f64::from(settings.hottest)).min(MOST_COUNT.into())
}

/// The whole part, and one more if the fraction is above the particle's own threshold: no number pops from frame to
/// frame.
pub fn count(mean_count: f64, seed: u32, id: u32) -> u32 {
    let one_more = mean_count.fract() > f64::from(unit(hash(seed, id, COUNT_KEY, 0)));
    mean_count.floor() as u32 + u32::from(one_more)
}

/// Linear RGB at a temperature; of the look "cel", heat.
pub fn colour(settings: &Settings, kelvin: f64) -> [f64; 3] {
    let [hottest, falloff, adaptation] = [settings.hottest, settings.falloff, settings.adaptation].map(f64::from);
    if settings.is_cel() {
        return colour::heat(kelvin, hottest);
    }
    match &settings.colour {
        Colour::Physical => colour::physical(kelvin, hottest, adaptation),
        Colour::Displayable => colour::displayable(kelvin, hottest, falloff, adaptation),
        Colour::Ramp(colours) => colour::ramp(kelvin, hottest, colours),
    }
}

/// How a particle's sprites are drawn out, by the matrix 1 + w w^T in the plane of the picture (x right, y up): along its
/// motion on screen (velocity in m/s), by as many of their sides as it moves in `settings.stretch` seconds, at most 7. None
/// of a particle whose space comes before the near plane.
pub fn stretch(settings: &Settings, view: &View, size: [u32; 2], position: [f32; 3], velocity: [f32; 3]) -> [f64; 2] {
    let projection = Projection::of_valid(view, size);
    let centre = projection.to_view(super::world(position));
    let spread = f64::from(settings.spread.unwrap_or_default());
    let radius = if settings.shape == Shape::Cube { spread * 3.0_f64.sqrt() } else { spread };
    let is_near = !projection.is_orthographic && centre.z <= 1.001 * (radius + projection.near);
    if is_near || !velocity.iter().all(|v| v.abs() <= FARTHEST) {
        return [0.0; 2];
    }
    let moved = projection.axes * super::world(velocity);
    let slope = if projection.is_orthographic { DVec2::ZERO } else { centre.truncate() / centre.z };
    let way = f64::from(settings.stretch) * (moved.truncate() - slope * moved.z);
    let half = super::half_sides(settings, &projection, centre.z);
    let side = 2.0 * half.x * super::enlarged(half).max(1.0) / projection.focal.x * projection.widening(centre.z);
    let longer = (way.length() / side).min(7.0);
    (way.normalize_or_zero() * longer.sqrt()).to_array()
}

/// A component in [`LIGHT_STEPS`] of the brightest.
pub fn light(component: f64, brightest: f64) -> u32 {
    if brightest > 0.0 { (component / brightest * f64::from(LIGHT_STEPS) + 0.5).floor() as u32 } else { 0 }
}

/// The mask's level in a frame whose nearest particle is at view depth `nearest`; 0 without one.
pub fn mask_level(settings: &Settings, view: &View, size: [u32; 2], nearest: f64) -> u32 {
    match settings.size_pixels {
        Some(pixels) => mask::level(f64::from(pixels)),
        None if nearest.is_finite() => {
            let projection = Projection::of_valid(view, size);
            mask::level(f64::from(settings.sprite()) * projection.focal.max_element() / projection.widening(nearest))
        }
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::view::Camera;

    fn camera() -> Camera {
        Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, ..Camera::default() }
    }

    #[test]
    fn what_is_not_valid_is_dropped() {
        let nan = f32::NAN;
        let given = [
            [0.0, 0.0, -2.0, 3000.0],
            [nan, 0.0, -1.0, 3000.0],
            [0.0, 0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0, -1.0],
            [0.0, 0.0, -1.0, nan],
            [0.0, f32::INFINITY, -1.0, 3000.0],
            [0.0, 0.0, -1.0, f32::INFINITY],
            [0.0, 0.0, 1.0, 199.0],
            [0.0, 0.0, -3.0, 9000.0],
        ];
        let prepared = prepare(&Settings::light(), 6000.0, 1, &camera().view([1, 1]), &given, None);
        let rows: Vec<u32> = prepared.particles.iter().map(|p| p.row).collect();
        assert_eq!((rows, prepared.nearest), (vec![0, 7, 8], 2.0));
        let [first, cold, hot] = &prepared.particles[..] else { panic!() };
        assert_eq!((first.alpha, first.count, first.light), (4.0, 20, [65535; 3]));
        assert_eq!((cold.colour, cold.light), ([0.0; 3], [0; 3]));
        // Clamped to the host's 6000 K: twice the count and alpha of 3000 K, its displayable colour.
        assert_eq!((hot.alpha, hot.mean_count, hot.count), (8.0, 40.0, 40));
        let largest = hot.colour.into_iter().fold(0.0, f64::max);
        assert!((largest - 1.0).abs() < 1e-12 && (prepared.brightest - 1.0).abs() < 1e-12);
    }

    #[test]
    fn colours_are_shares_of_the_brightest() {
        let settings = Settings { colour: Colour::Ramp(vec![[0.0, 2.0, 8.0], [4.0, 2.0, 0.0]]), ..Settings::light() };
        let given = [[0.0, 0.0, 9.0, 750.0], [0.0, 0.0, 9.0, 3000.0], [0.0, 0.0, 9.0, 1500.0]];
        let prepared = prepare(&settings, 1e6, 1, &camera().view([1, 1]), &given, Some(&[7, 8, 9]));
        let lights: Vec<[u32; 3]> = prepared.particles.iter().map(|p| p.light).collect();
        // 65535 times 0, 1/4, 1; 1/2, 1/4, 0; 1/4, 1/4, 1/2.
        assert_eq!(lights, [[0, 16384, 65535], [32768, 16384, 0], [16384, 16384, 32768]]);
        assert_eq!((prepared.brightest, prepared.nearest), (8.0, f64::INFINITY));
        assert_eq!(prepared.particles[2].id, 9);
        let nothing = prepare(&settings, 3000.0, 1, &camera().view([1, 1]), &[[0.0, 0.0, 0.0, 500.0]], None);
        assert_eq!((nothing.brightest, nothing.particles[0].light), (0.0, [0; 3]));
    }

    #[test]
    fn counts_have_their_mean_and_do_not_pop() {
        let settings = Settings { count: 10.0, ..Settings::light() };
        let mean = mean_count(&settings, 750.0);
        assert_eq!(mean, 2.5);
        let total: u32 = (0..10_000).map(|id| count(mean, 4, id)).sum();
        assert!((24_800..25_200).contains(&total), "{total}");
        for id in 0..100 {
            let counts: Vec<u32> = (0..300).map(|i| count(f64::from(i) / 100.0, 4, id)).collect();
            assert!(counts.is_sorted() && counts[0] == 0 && counts[299] >= 2);
        }
        assert_eq!(mean_count(&Settings { count: 32_768.0, ..settings }, 6000.0), 32_768.0);
    }

    #[test]
    fn the_level_follows_the_nearest_particle() {
        // 90 degrees over 128 rows: 64 pixels at depth 1.
        let settings = Settings { size: Some(0.5), ..Settings::light() };
        let level =
            |settings: &Settings, nearest| mask_level(settings, &camera().view([200, 128]), [200, 128], nearest);
        let given = [0.1, 0.99, 1.01, 2.01, 50.0, f64::INFINITY];
        assert_eq!(given.map(|nearest| level(&settings, nearest)), [0, 0, 1, 2, 6, 0]);
        let settings = Settings { size: None, size_pixels: Some(13.0), ..settings };
        assert_eq!(level(&settings, f64::INFINITY), 2);
    }
}
