//! The grids of volumes.

use std::path::Path;

use glam::DVec3;

use super::{GridReport, Report, Statistics};
use crate::io::ReadError;
use crate::io::array::{Archive, Element, Header};
use crate::io::vdb::{Brick, Entry, Vdb};
use crate::io::volume::{Grids, Shape, shape_of_npz};

/// All grids of an OpenVDB file that have numbers or vectors, over what is active.
pub(super) fn vdb(path: &Path) -> Result<Report, ReadError> {
    let mut file = Vdb::open(path)?;
    let (mut grids, mut notes) = (Vec::new(), Vec::new());
    for entry in file.grids().to_vec() {
        match entry.element {
            Some(_) => grids.push(vdb_grid(&mut file, &entry)?),
            None => notes.push(format!("grid `{}` is passed over: {}", entry.title(), entry.type_name())),
        }
    }
    Ok(Report::Volume { grids, notes })
}

fn vdb_grid(file: &mut Vdb, entry: &Entry) -> Result<GridReport, ReadError> {
    let block = file.load(entry, true)?;
    let grid = block.grid()?;
    let mut all = Statistics::default();
    let components = grid.tree.element().components;
    grid.tree.each(|brick: &Brick| {
        for (voxel, values) in brick.values.chunks_exact(components).enumerate() {
            if brick.is_active(voxel) {
                values.iter().for_each(|value| all.add(*value, brick.voxels_of_each()));
            }
        }
    })?;
    let map = grid.place.map;
    let [first, last] = grid.tree.bounds().unwrap_or([[0; 3], [-1; 3]]);
    let dimensions = [0, 1, 2].map(|axis| (i64::from(last[axis]) - i64::from(first[axis]) + 1) as u32);
    let corner = map.world(DVec3::from_array(first.map(f64::from)) - 0.5);
    Ok(GridReport {
        name: entry.title(),
        kind: entry.type_name(),
        dimensions,
        voxel_size: map.voxel_size().as_vec3().to_array(),
        origin: corner.as_vec3().to_array(),
        active: grid.tree.active(),
        min: all.range.as_ref().map(|range| range.min),
        max: all.range.as_ref().map(|range| range.max),
        sum: all.sum,
        not_finite: all.not_finite,
    })
}

/// The grids: density, velocity, and whatever else has a value or a vector for each voxel.
pub(super) fn npz(path: &Path) -> Result<Report, ReadError> {
    let mut archive = Archive::open(path)?;
    let shape = shape_of_npz(&mut archive, &Grids::default())?;
    let [nx, ny, nz] = shape.dimensions.map(u64::from);
    let mut names = archive.names();
    names.sort_by_key(|name| (name != "density", name != "velocity"));
    let mut grids = Vec::new();
    for name in names {
        let Some(header) = archive.header(&name).ok().flatten() else { continue };
        let is_vector = match header.shape[..] {
            [z, y, x] | [z, y, x, 1] if [x, y, z] == [nx, ny, nz] => false,
            [z, y, x, 3] if [x, y, z] == [nx, ny, nz] => true,
            _ => continue,
        };
        let mut all = Statistics::default();
        archive.each(&name, |value| all.add(value, 1))?;
        let Shape { dimensions, voxel_size, origin, .. } = shape;
        grids.push(GridReport {
            kind: kind(&header, is_vector).to_owned(),
            name,
            dimensions,
            voxel_size,
            origin,
            active: nx * ny * nz,
            min: all.range.as_ref().map(|range| range.min),
            max: all.range.as_ref().map(|range| range.max),
            sum: all.sum,
            not_finite: all.not_finite,
        });
    }
    Ok(Report::Volume { grids, notes: Vec::new() })
}

/// The type of a grid by the names that OpenVDB has for them.
fn kind(header: &Header, is_vector: bool) -> &'static str {
    let [value, vector] = match header.element {
        Element::F16 => ["half", "vec3h"],
        Element::F32 => ["float", "vec3f"],
        Element::F64 => ["double", "vec3d"],
        Element::Int(8) | Element::Uint(8) => ["int64", "vec3i"],
        Element::Int(_) | Element::Uint(_) => ["int32", "vec3i"],
    };
    if is_vector { vector } else { value }
}
