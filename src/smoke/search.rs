//! How radii are searched: the pyramids, which ways serve a volume, and which of them is taken.

use bytemuck::Zeroable;

use crate::effect::DeviceTraits;
use crate::error::{Error, Result};
use crate::layout::{LOOP_BUDGET, MOST_GROUPS};
use crate::shaders::smoke as glsl;
use crate::shaders::smoke::blocks::PyramidLevel;
use crate::shaders::smoke::constants::{
    CROSSING_LEVELS, CROSSING_ROWS, FIELD_VOXELS, MAX_LEVELS, MOST_DETAIL_WINDOW, WORD_VOXELS,
};
use crate::smoke::frame::Shape;
use crate::smoke::settings::{Grow, Radius, Settings};

/// Standard deviations in the width of the Gaussian of the density.
const DETAIL_DEVIATIONS: f64 = 2.0;
/// Standard deviations after which it ends: what is cut off is 0.3 % of its weight along an axis.
const DETAIL_CUTOFF: f64 = 3.0;
/// Heights of the volume in a width of that Gaussian, unless it is said.
const DETAILS_OF_HEIGHT: f64 = 40.0;

/// A pyramid over the bits of a volume: level 0 is a bit a voxel, each further level joins 2 x 2 rows along y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid {
    /// From the finest.
    pub levels: [PyramidLevel; MAX_LEVELS as usize],
    /// Number of levels; more than there is room for if the volume is too high or too deep.
    pub count: u32,
    /// Words of a row.
    pub row_words: u32,
    /// Words of all levels.
    pub words: u64,
}

impl Pyramid {
    /// For a volume of so many voxels.
    pub fn new(dimensions: [u32; 3]) -> Pyramid {
        let row_words = dimensions[0].div_ceil(WORD_VOXELS);
        let mut pyramid =
            Pyramid { levels: [PyramidLevel::zeroed(); MAX_LEVELS as usize], count: 0, row_words, words: 0 };
        let (mut y, mut z) = (dimensions[1], dimensions[2]);
        loop {
            if let Some(level) = pyramid.levels.get_mut(pyramid.count as usize) {
                *level = PyramidLevel { first_word: pyramid.words as u32, rows_y: y, rows_z: z, unused: 0 };
            }
            pyramid.count += 1;
            pyramid.words += u64::from(row_words) * u64::from(y) * u64::from(z);
            if y <= 1 && z <= 1 {
                return pyramid;
            }
            (y, z) = (y.div_ceil(2), z.div_ceil(2));
        }
    }

    /// The pyramid over the cells between voxel centres that the threshold crosses, in a volume of so many voxels: one more
    /// along each axis. Of more levels than there is room for, the upper ones are left out.
    pub fn of_cells(dimensions: [u32; 3]) -> Pyramid {
        let all = Pyramid::new(dimensions.map(|n| n + 1));
        let words = |level: &PyramidLevel| u64::from(all.row_words) * u64::from(level.rows_y) * u64::from(level.rows_z);
        Pyramid { words: all.levels.iter().map(words).sum(), ..all }
    }

    /// The dispatches that make the pyramid over cells: the level that each begins with, and its workgroups.
    pub fn cell_dispatches(&self) -> impl Iterator<Item = (u32, [u32; 3])> + '_ {
        let made = self.count.min(MAX_LEVELS);
        (0..made).step_by(CROSSING_LEVELS as usize).filter(move |level| *level == 0 || level + 1 < made).map(|level| {
            let PyramidLevel { rows_y, rows_z, .. } = self.levels[level as usize];
            (level, [self.row_words, rows_y.div_ceil(CROSSING_ROWS), rows_z.div_ceil(CROSSING_ROWS)])
        })
    }

    /// The level that a search for the surface begins at: two rows an invocation, or fewer.
    pub fn surface_top(&self) -> u32 {
        let made = self.count.min(MAX_LEVELS);
        let most = 2 * glsl::grow_surface::SHADER.local_size.iter().product::<u32>();
        let top = self.levels[..made as usize].iter().position(|level| level.rows_y * level.rows_z <= most);
        top.map_or(made - 1, |level| level as u32)
    }

    /// Rows of level 0 in the square that the walk in Morton order covers.
    pub fn leaves(&self) -> u32 {
        1 << (2 * (self.count - 1))
    }

    /// Iterations of the outer loop of a search that keep an invocation within the loop budget: each may look at all words
    /// of a row, to both sides.
    pub fn iterations(&self, traits: &DeviceTraits) -> u32 {
        if traits.ends_loops { (LOOP_BUDGET / (2 * self.row_words + 6)).max(1) } else { u32::MAX }
    }
}

/// Whether the passes that make the chessboard distance field can be dispatched: a slice of the volume is a row of
/// workgroups.
pub fn field_fits(shape: &Shape) -> bool {
    let [nx, ny, _] = shape.dimensions.map(u64::from);
    (nx.div_ceil(FIELD_VOXELS.into()) * ny).div_ceil(glsl::field_rows::SHADER.local_size[0].into()) <= MOST_GROUPS
}

/// Rows that the paper's loop may have to look at in a volume of this shape: the shells up to where the outside is
/// certain to be nearest.
pub fn growth_rows(shape: &Shape) -> u32 {
    let side = |a: usize| f64::from(shape.voxel_size[a]);
    let (smallest, largest) = (side(0).min(side(1)).min(side(2)), side(0).max(side(1)).max(side(2)));
    let reach = (0..3).map(|a| (f64::from(shape.dimensions[a]) + 1.0) / 2.0 * side(a)).fold(f64::MAX, f64::min);
    // The nearest outside voxel is at most this far (its other axes add at most a voxel each, also as Euclid counts).
    let shells = ((reach + 2.0 * largest) / smallest).ceil() + 1.0;
    ((shells + 1.0) * (4.0 * (shells + 1.0).powi(2) - 1.0) / 3.0).min(f64::from(u32::MAX)) as u32
}

/// The standard deviation of the Gaussian of the density along each axis, in voxels; none if there is none. Fails if it is
/// wider than the window.
pub fn detail(settings: &Settings, shape: &Shape) -> Result<Option<[f32; 3]>> {
    let side = |a: usize| f64::from(shape.voxel_size[a]);
    let (smallest, largest) = (side(0).min(side(1)).min(side(2)), side(0).max(side(1)).max(side(2)));
    let most = smallest * f64::from(MOST_DETAIL_WINDOW) * DETAIL_DEVIATIONS / DETAIL_CUTOFF;
    let width = match settings.detail {
        Some(0.0) => return Ok(None),
        Some(width) if f64::from(width) > most * (1.0 + 1e-6) => {
            let allowed = format!("at most 16 voxels along each axis, {most} m in this volume");
            return Err(Error::setting("smoke.detail", width, allowed));
        }
        Some(width) => f64::from(width),
        None => largest.max(side(1) * f64::from(shape.dimensions[1]) / DETAILS_OF_HEIGHT),
    };
    Ok(Some([0, 1, 2].map(|a| (width.min(most) / DETAIL_DEVIATIONS / side(a)) as f32)))
}

/// Where the window of that Gaussian ends, in voxels.
pub fn detail_window(deviation: f32) -> u32 {
    ((DETAIL_CUTOFF * f64::from(deviation)).ceil() as u32).min(MOST_DETAIL_WINDOW)
}

/// Its weights by distance along each axis; both sides together add up to 1.
pub fn detail_weights(deviations: [f32; 3]) -> [[f32; 4]; MOST_DETAIL_WINDOW as usize + 1] {
    let mut weights = [[0.0; 4]; MOST_DETAIL_WINDOW as usize + 1];
    for (axis, deviation) in deviations.into_iter().enumerate().filter(|(_, deviation)| *deviation > 0.0) {
        let weight = |d: u32| (-0.5 * (f64::from(d) / f64::from(deviation)).powi(2)).exp();
        let window = detail_window(deviation);
        let sum = 1.0 + 2.0 * (1..=window).map(weight).sum::<f64>();
        (0..=window).for_each(|d| weights[d as usize][axis] = (weight(d) / sum) as f32);
    }
    weights
}

/// The way a radius from voxels is searched in a volume of this shape.
pub fn chosen_grow(settings: &Settings, shape: &Shape, traits: &DeviceTraits) -> Grow {
    let field_works = shape.is_cubic()
        && settings.radius == Radius::Box
        && shape.dimensions.iter().min() <= Some(&500)
        && field_fits(shape);
    match settings.grow {
        Grow::Chosen if !field_works => Grow::Pyramid,
        Grow::Chosen => cheapest_grow(settings.particles, shape, traits),
        other => other,
    }
}

/// By what each way costs on the device, when the volume is new in every frame.
fn cheapest_grow(particles: u32, shape: &Shape, traits: &DeviceTraits) -> Grow {
    let pyramid = Pyramid::new(shape.dimensions);
    // The paper's loop costs the cube of the radius, so it is only for volumes where no radius is large.
    let is_small = shape.dimensions.iter().min() <= Some(&16) && growth_rows(shape) <= pyramid.iterations(traits);
    let costs = &traits.tuning.grow;
    let (particles, voxels) = (f64::from(particles), shape.voxels() as f64);
    let growth = if is_small { costs.growth(particles) } else { f64::INFINITY };
    let (field, pyramid) = (costs.field(particles, voxels), costs.pyramid(particles, voxels, pyramid.count));
    match () {
        _ if growth <= field.min(pyramid) => Grow::Growth,
        _ if field <= pyramid => Grow::Field,
        _ => Grow::Pyramid,
    }
}

/// A search that was asked for by name must be able to serve this volume, in at most so many dispatches.
pub fn check(settings: &Settings, shape: &Shape, traits: &DeviceTraits, parts: u32) -> Result<()> {
    detail(settings, shape)?;
    if settings.has_surface() {
        return Ok(());
    }
    match chosen_grow(settings, shape, traits) {
        Grow::Field if !shape.is_cubic() => {
            Err(Error::setting("smoke.grow", "field", "needs cubic voxels; \"chosen\" or \"pyramid\" serve all"))
        }
        Grow::Field if !field_fits(shape) => Err(Error::setting(
            "smoke.grow",
            "field",
            "needs smaller slices (x, y); \"chosen\" or \"pyramid\" serve all",
        )),
        Grow::Growth => {
            let iterations = Pyramid::new(shape.dimensions).iterations(traits);
            let needed = u64::from(growth_rows(shape).div_ceil(iterations));
            let limit = u64::from(parts);
            let advice = "its voxels are too flat for grow = \"growth\"; use \"chosen\"";
            match needed > limit {
                true => Err(Error::Limit { what: "the search of radii (dispatches)", needed, limit, advice }),
                false => Ok(()),
            }
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(dimensions: [u32; 3], voxel_size: [f32; 3], particles: u32) -> Grow {
        let settings = Settings { particles, ..Settings::default() };
        chosen_grow(&settings, &Shape { dimensions, voxel_size, origin: [0.0; 3] }, &DeviceTraits::LAVAPIPE)
    }

    /// The best of those measured on lavapipe (`Tuning::CPU`), or one at most 1.2 times as slow.
    #[test]
    fn the_cheapest_search_is_chosen() {
        for (side, particles, best) in [
            (16, 500, Grow::Growth),
            (16, 10_000, Grow::Field),
            (48, 2000, Grow::Field),
            (64, 1000, Grow::Pyramid),
            (64, 10_000, Grow::Field),
            (128, 2000, Grow::Pyramid),
            (128, 50_000, Grow::Field),
            (256, 10_000, Grow::Pyramid),
            (256, 1_000_000, Grow::Field),
        ] {
            assert_eq!(chosen([side; 3], [0.1; 3], particles), best, "{side}, {particles}");
        }
        assert_eq!(chosen([15, 20, 15], [0.12; 3], 500), Grow::Growth, "the paper's volume");
    }

    /// Counted work: three passes over all voxels are nothing to a GPU, and a walk of dependent reads is much.
    #[test]
    fn on_a_gpu_the_field_is_searched_unless_few_need_a_large_one() {
        let chosen = |side, particles| {
            let settings = Settings { particles, ..Settings::default() };
            let shape = Shape { dimensions: [side; 3], voxel_size: [0.1; 3], origin: [0.0; 3] };
            chosen_grow(&settings, &shape, &DeviceTraits::LEAST)
        };
        assert_eq!([16, 64, 128].map(|side| chosen(side, 10_000)), [Grow::Field; 3]);
        assert_eq!(chosen(400, 500), Grow::Pyramid);
        assert_eq!(chosen(400, 1_000_000), Grow::Field);
    }

    #[test]
    fn only_searches_that_work_are_chosen() {
        assert_eq!(chosen([15, 20, 15], [0.1, 0.1, 0.25], 500), Grow::Pyramid, "not cubic");
        assert_eq!(chosen([501; 3], [0.1; 3], 1_000_000), Grow::Pyramid, "a field of bytes ends at 255");
        // Rows so long that the loop budget cuts the search: the buffers are not made for so many parts.
        let long = Shape { dimensions: [4096, 16, 16], voxel_size: [0.1; 3], origin: [0.0; 3] };
        assert!(growth_rows(&long) > Pyramid::new(long.dimensions).iterations(&DeviceTraits::LAVAPIPE));
        assert_ne!(chosen(long.dimensions, long.voxel_size, 10), Grow::Growth);
    }
}
