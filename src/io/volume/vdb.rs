//! Volumes from OpenVDB files: grids of any place and orientation, as density and velocity of one box of voxels.

use std::path::Path;

use glam::{DMat3, DVec3};

use super::{Contents, FASTEST, Grids, MAX_VOXELS, Up};
use crate::data::Volume;
use crate::io::ReadError;
use crate::io::vdb::{Entry, Grid, Map, Tree, Vdb};

/// What a grid says that holds distances to a surface, and one whose components stand on the faces of voxels.
const LEVEL_SET: &str = "level set";
const STAGGERED: &str = "staggered";
/// Names of velocities that are looked for.
const VELOCITIES: [&str; 3] = ["velocity", "vel", "v"];
/// What stands behind these if each component is a grid.
const COMPONENTS: [[&str; 3]; 4] = [[".x", ".y", ".z"], ["X", "Y", "Z"], ["_x", "_y", "_z"], ["x", "y", "z"]];

/// A box of voxels in the world.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    dimensions: [u32; 3],
    voxel_size: DVec3,
    /// World position of the corner of the first voxel.
    corner: DVec3,
}

/// Where a grid's voxels go in memory.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// The voxels that go there: first and last.
    bounds: [[i32; 3]; 2],
    /// Where the first goes, and how far the next along each axis of the grid is from it.
    begin: isize,
    steps: [isize; 3],
}

/// Where the values of a voxel go among those that one has there.
#[derive(Clone, Copy, Debug)]
struct Slot {
    width: usize,
    first: usize,
}

/// The volume of a file, or one without smoke if it has no such grid, or an empty one.
pub(super) fn read(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
    let mut file = Vdb::open(path)?;
    let velocity = velocity(&file, grids);
    let Some(entry) = density(&file, grids).cloned() else { return Ok(Volume::without_smoke(velocity.is_some())) };
    let block = file.load(&entry, true)?;
    let grid = block.grid()?;
    check_density(path, &entry, &grid)?;
    let map = turned(grid.place.map, grids.up);
    let Some(bounds) = grid.tree.bounds() else { return Ok(Volume::without_smoke(velocity.is_some())) };
    let (lattice, way) = lattice(path, &entry, &map, bounds)?;
    let count = lattice.dimensions.iter().map(|n| *n as usize).product();
    let slot = Slot { width: 1, first: 0 };
    let density = match way {
        Some(way) => {
            let mut values = vec![grid.tree.background()[0]; count];
            fill(&grid.tree, way, slot, &mut values)?;
            values
        }
        None => {
            let field = Field::new(path, &entry, map, &grid.tree)?;
            lattice.centres().map(|place| field.at(place, 0, DVec3::ZERO)).collect()
        }
    };
    drop(grid);
    drop(block);
    if let Some(at) = density.iter().position(|d| d.is_infinite()) {
        let place = format!("grid `{}`, voxel {:?} of {:?}", entry.title(), lattice.voxel(at), lattice.dimensions);
        return Err(ReadError::at(path, place, format!("is {} as f32", density[at]), "a finite density"));
    }
    let velocity = match velocity {
        Some(found) => {
            let values = velocities(&mut file, path, &found, grids, (&map, &lattice, way))?;
            let is_too_fast = |v: &[f32; 3]| v.iter().any(|c| c.abs() > FASTEST);
            if let Some(at) = values.iter().position(is_too_fast) {
                let place = format!("the velocity, voxel {:?} of {:?}", lattice.voxel(at), lattice.dimensions);
                let expected = format!("m/s, none beyond {FASTEST}");
                return Err(ReadError::at(path, place, format!("is {:?} as f32", values[at]), expected));
            }
            Some(values)
        }
        None => None,
    };
    let Lattice { dimensions, voxel_size, corner } = lattice;
    let (voxel_size, origin) = (voxel_size.as_vec3().to_array(), corner.as_vec3().to_array());
    Ok(Volume { dimensions, voxel_size, origin, density, velocity })
}

/// What a file has of a volume, without the values of voxels.
pub(super) fn contents(path: &Path, grids: &Grids) -> Result<Contents, ReadError> {
    let mut file = Vdb::open(path)?;
    let velocity = velocity(&file, grids).is_some();
    let nothing = Contents { dimensions: None, velocity };
    let Some(entry) = density(&file, grids).cloned() else { return Ok(nothing) };
    let block = file.load(&entry, false)?;
    let grid = block.grid()?;
    check_density(path, &entry, &grid)?;
    let map = turned(grid.place.map, grids.up);
    let Some(bounds) = grid.tree.bounds() else { return Ok(nothing) };
    Ok(Contents { dimensions: Some(lattice(path, &entry, &map, bounds)?.0.dimensions), velocity })
}

/// What is wrong with a file that has no density, where one is needed.
pub(super) fn missing(path: &Path, grids: &Grids) -> ReadError {
    let names = Vdb::open(path).map(|file| file.grids().iter().map(Entry::title).collect::<Vec<_>>());
    let (name, names) = (grids.density_name(), names.unwrap_or_default());
    let why = format!("no frame has smoke in a grid `{name}`; this file has the grids {names:?}");
    ReadError::file(path, why, "a fog volume in some frame; smoke.density_grid names it")
}

fn density<'v>(file: &'v Vdb, grids: &Grids) -> Option<&'v Entry> {
    file.find(grids.density_name())
}

fn check_density(path: &Path, entry: &Entry, grid: &Grid) -> Result<(), ReadError> {
    let place = || format!("grid `{}`", entry.title());
    if grid.tree.element().components != 1 {
        return Err(ReadError::at(path, place(), "is of vectors", "one density a voxel"));
    }
    if grid.place.class == LEVEL_SET {
        let expected = "a fog volume: densities, 0 outside (convert it before)";
        return Err(ReadError::at(path, place(), "is a level set: distances to a surface", expected));
    }
    Ok(())
}

/// The velocity that the file has, a grid of vectors or three of numbers: the one of that name, or the first of the usual names.
fn velocity(file: &Vdb, grids: &Grids) -> Option<Vec<Entry>> {
    let named = |name: &str| {
        if let Some(entry) = file.find(name).filter(|entry| entry.element.is_some_and(|e| e.components == 3)) {
            return Some(vec![entry.clone()]);
        }
        let number = |entry: &&Entry| entry.element.is_some_and(|e| e.components == 1);
        let find = |end: &str| file.find(&format!("{name}{end}")).filter(number).cloned();
        COMPONENTS.into_iter().find_map(|ends| ends.into_iter().map(find).collect())
    };
    match &grids.velocity {
        Some(name) => named(name),
        None => VELOCITIES.into_iter().find_map(named),
    }
}

fn turned(map: Map, up: Up) -> Map {
    match up {
        Up::Y => map,
        Up::Z => map.z_up(),
    }
}

/// The box of the voxels between `bounds`, and the way of these into it; none where the grid's axes are not the world's:
/// then the box is the least around them, with voxels as long as the shortest axis.
fn lattice(path: &Path, entry: &Entry, map: &Map, bounds: [[i32; 3]; 2]) -> Result<(Lattice, Option<Way>), ReadError> {
    let [first, last] = bounds.map(|voxel| DVec3::from_array(voxel.map(f64::from)));
    let [first, last] = [first - 0.5, last + 0.5];
    let corners = (0..8).map(|corner: u32| {
        let end = |axis: usize| if corner >> axis & 1 == 0 { first[axis] } else { last[axis] };
        map.world(DVec3::new(end(0), end(1), end(2)))
    });
    let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)));
    let count = |axis: usize| i64::from(bounds[1][axis]) - i64::from(bounds[0][axis]) + 1;
    let sizes = map.voxel_size();
    let (dimensions, voxel_size, way) = match map.along_axes() {
        Some(along) => {
            let dimensions = along.map(|(axis, _)| count(axis) as f64);
            let voxel_size = DVec3::from_array(along.map(|(axis, _)| sizes[axis]));
            let strides = [1, dimensions[0] as isize, (dimensions[0] * dimensions[1]) as isize];
            let mut way = Way { bounds, begin: 0, steps: [0; 3] };
            for (world, (axis, is_backward)) in along.into_iter().enumerate() {
                way.steps[axis] = if is_backward { -strides[world] } else { strides[world] };
                way.begin += if is_backward { (count(axis) - 1) as isize * strides[world] } else { 0 };
            }
            (dimensions, voxel_size, Some(way))
        }
        None => {
            let size = DVec3::splat(sizes.min_element());
            // What rounding adds to a side is no voxel.
            let dimensions = ((high - low) / size - 1e-6).ceil().max(DVec3::ONE);
            (dimensions.to_array(), size, None)
        }
    };
    if dimensions.iter().product::<f64>() > MAX_VOXELS as f64 {
        let why = format!("its active voxels span {dimensions:?} voxels");
        return Err(ReadError::at(path, format!("grid `{}`", entry.title()), why, format!("{MAX_VOXELS} at most")));
    }
    Ok((Lattice { dimensions: dimensions.map(|n| n as u32), voxel_size, corner: low }, way))
}

impl Lattice {
    /// The place of a voxel that is counted as they stand in memory.
    fn voxel(&self, at: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dimensions.map(|n| n as usize);
        [at % nx, at / nx % ny, at / nx / ny]
    }

    /// Middles of voxels in the world.
    fn centres(&self) -> impl Iterator<Item = DVec3> {
        let count = self.dimensions.iter().map(|n| *n as usize).product();
        let place = |voxel: [usize; 3]| DVec3::from_array(voxel.map(|c| c as f64 + 0.5));
        (0..count).map(move |at| self.corner + self.voxel_size * place(self.voxel(at)))
    }
}

/// Puts the values of a grid where they belong; the background is there.
fn fill(tree: &Tree, way: Way, slot: Slot, to: &mut [f32]) -> Result<(), ReadError> {
    let Way { bounds: [first, last], begin, steps } = way;
    let components = tree.element().components;
    let (mut left, mut has_overlap) = (to.len() / slot.width, false);
    tree.each(|brick| {
        let low = [0, 1, 2].map(|axis| brick.begin[axis].max(first[axis]));
        let high = [0, 1, 2].map(|axis| (brick.begin[axis] + brick.side - 1).min(last[axis]));
        let count = [0, 1, 2].map(|axis| (i64::from(high[axis]) - i64::from(low[axis]) + 1).max(0) as usize);
        // Nodes of a tree do not overlap: where some do, they may do so without end.
        match left.checked_sub(count.iter().product()) {
            Some(rest) => left = rest,
            None => has_overlap = true,
        }
        if has_overlap {
            return;
        }
        let step = |axis: usize, at: i32| (at - first[axis]) as isize * steps[axis];
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let [i, j, k] = [x - brick.begin[0], y - brick.begin[1], z - brick.begin[2]];
                    let voxel = if brick.is_uniform() { 0 } else { (64 * i + 8 * j + k) as usize };
                    let at = (begin + step(0, x) + step(1, y) + step(2, z)) as usize * slot.width + slot.first;
                    let values = &brick.values[components * voxel..][..components];
                    to[at..at + components].copy_from_slice(values);
                }
            }
        }
    })?;
    match has_overlap {
        true => Err(tree.fault("nodes of the tree overlap", "each voxel in one of them")),
        false => Ok(()),
    }
}

/// A grid's values, to be looked up anywhere.
struct Field {
    map: Map,
    inverse: DMat3,
    first: [i32; 3],
    size: [i64; 3],
    components: usize,
    values: Vec<f32>,
    background: [f32; 3],
}

impl Field {
    fn new(path: &Path, entry: &Entry, map: Map, tree: &Tree) -> Result<Field, ReadError> {
        let components = tree.element().components;
        let background = tree.background();
        let bounds = tree.bounds().unwrap_or([[0; 3], [-1; 3]]);
        let size = [0, 1, 2].map(|axis| i64::from(bounds[1][axis]) - i64::from(bounds[0][axis]) + 1);
        if size.iter().map(|n| *n as f64).product::<f64>() > MAX_VOXELS as f64 {
            let why = format!("its active voxels span {size:?} voxels");
            return Err(ReadError::at(path, format!("grid `{}`", entry.title()), why, format!("{MAX_VOXELS} at most")));
        }
        let count = size.iter().product::<i64>() as usize;
        let mut values: Vec<f32> = background[..components].repeat(count);
        let way = Way { bounds, begin: 0, steps: [1, size[0] as isize, (size[0] * size[1]) as isize] };
        fill(tree, way, Slot { width: components, first: 0 }, &mut values)?;
        Ok(Field { map, inverse: map.axes.inverse(), first: bounds[0], size, components, values, background })
    }

    fn value(&self, at: [i64; 3], component: usize) -> f32 {
        let at = [0, 1, 2].map(|axis| at[axis] - i64::from(self.first[axis]));
        if (0..3).any(|axis| !(0..self.size[axis]).contains(&at[axis])) {
            return self.background[component];
        }
        let index = at[0] + self.size[0] * (at[1] + self.size[1] * at[2]);
        self.values[index as usize * self.components + component]
    }

    /// The component at a place in the world, between the eight voxels around it; `shift`: how far, in voxels, the component
    /// stands before the middle of its own.
    fn at(&self, world: DVec3, component: usize, shift: DVec3) -> f32 {
        let place = self.inverse * (world - self.map.middle) + shift;
        // Exactly on a voxel, but for rounding: that voxel alone.
        let place = DVec3::select((place - place.round()).abs().cmplt(DVec3::splat(1e-6)), place.round(), place);
        let (low, share) = (place.floor(), place - place.floor());
        let mut sum = 0.0;
        for corner in 0..8 {
            let is_high = [0, 1, 2].map(|axis: usize| corner >> axis & 1 == 1);
            let weights = [0, 1, 2].map(|axis| if is_high[axis] { share[axis] } else { 1.0 - share[axis] });
            let weight: f64 = weights.iter().product();
            if weight > 0.0 {
                let at = [0, 1, 2].map(|axis| low[axis] as i64 + i64::from(is_high[axis]));
                sum += weight * f64::from(self.value(at, component));
            }
        }
        sum as f32
    }
}

/// Velocities at the voxels of the density, which is through `map` in a box.
fn velocities(
    file: &mut Vdb,
    path: &Path,
    entries: &[Entry],
    grids: &Grids,
    (map, lattice, way): (&Map, &Lattice, Option<Way>),
) -> Result<Vec<[f32; 3]>, ReadError> {
    let count = lattice.dimensions.iter().map(|n| *n as usize).product();
    let mut values = vec![[0.0_f32; 3]; count];
    for (number, entry) in entries.iter().enumerate() {
        let block = file.load(entry, true)?;
        let grid = block.grid()?;
        let own = turned(grid.place.map, grids.up);
        let components = grid.tree.element().components;
        let is_staggered = components == 3 && grid.place.class == STAGGERED;
        if let Some(way) = way.filter(|_| !is_staggered && own == *map) {
            let background = grid.tree.background();
            for value in &mut values {
                value[number..number + components].copy_from_slice(&background[..components]);
            }
            fill(&grid.tree, way, Slot { width: 3, first: number }, values.as_flattened_mut())?;
            continue;
        }
        let field = Field::new(path, entry, own, &grid.tree)?;
        for component in 0..components {
            let shift = if is_staggered { 0.5 * DVec3::AXES[component] } else { DVec3::ZERO };
            for (value, place) in values.iter_mut().zip(lattice.centres()) {
                value[number + component] = field.at(place, component, shift);
            }
        }
    }
    for value in &mut values {
        let [x, y, z] = value.map(|c| c * grids.velocity_scale);
        *value = match grids.up {
            Up::Y => [x, y, z],
            Up::Z => [x, z, -y],
        };
    }
    Ok(values)
}

#[cfg(test)]
mod tests;
