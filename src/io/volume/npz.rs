//! Volumes from `.npz` files, and into them.

use std::io;
use std::path::Path;

use super::{Contents, FASTEST, Grids, MAX_VOXELS, Shape, Up};
use crate::data::Volume;
use crate::io::array::{Archive, ArchiveWriter, Array, Kind, check_count};
use crate::io::{ReadError, WriteError, write_atomic};
use crate::view::FARTHEST;

/// Reads a volume from an `.npz` file: `density` [nz, ny, nx], optionally `velocity` [nz, ny, nx, 3] in m/s, `voxel_size`
/// (a number or three, metres, above 0) and optionally `origin` (three numbers, default 0, 0, 0), all of any float or integer type,
/// which become f32. At most [`MAX_VOXELS`] voxels, at least one. NaN is no smoke, or no motion; an infinite density or a
/// velocity beyond [`FASTEST`] is an error that names the voxel (x, y, z), counted from 0.
pub fn read(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
    let mut archive = Archive::open(path)?;
    let voxels = density_header(&mut archive, grids)?;
    if voxels.contains(&0) {
        return Ok(Volume::without_smoke(velocity_header(&mut archive, grids, voxels)?));
    }
    let density = values(&mut archive, grids.density_name(), MAX_VOXELS)?;
    let Shape { dimensions, voxel_size, origin, velocity } = shape_of(&mut archive, grids)?;
    let place = |name: &str, at: usize| {
        let [nx, ny] = [dimensions[0] as usize, dimensions[1] as usize];
        format!("array `{name}`, voxel ({}, {}, {})", at % nx, at / nx % ny, at / nx / ny)
    };
    if let Some(at) = density.iter().position(|d: &f32| d.is_infinite()) {
        let why = format!("is {} as f32", density[at]);
        return Err(ReadError::at(path, place(grids.density_name(), at), why, "a finite density"));
    }
    let velocity: Option<Vec<[f32; 3]>> = match velocity {
        true => Some(values(&mut archive, grids.velocity_name(), 3 * MAX_VOXELS)?.as_chunks().0.to_vec()),
        false => None,
    };
    let is_too_fast = |v: &[f32; 3]| v.iter().any(|c| c.abs() > FASTEST);
    if let Some((at, v)) = velocity.iter().flatten().enumerate().find(|(_, v)| is_too_fast(v)) {
        let expected = format!("m/s, none beyond {FASTEST}");
        return Err(ReadError::at(path, place(grids.velocity_name(), at), format!("is {v:?} as f32"), expected));
    }
    let velocity = velocity.map(|values| values.into_iter().map(|v| v.map(|c| c * grids.velocity_scale)).collect());
    let volume = Volume { dimensions, voxel_size, origin, density, velocity };
    Ok(match grids.up {
        Up::Y => volume,
        Up::Z => z_up(&volume),
    })
}

/// A volume whose third axis is up, with the second up.
fn z_up(volume: &Volume) -> Volume {
    let [nx, ny, nz] = volume.dimensions.map(|n| n as usize);
    // Row by row: those of a slice that lies flat here stand one above the other there.
    let rows = || (0..ny).rev().flat_map(|y| (0..nz).map(move |z| nx * (y + ny * z)));
    let ([hx, hy, hz], [x, y, z]) = (volume.voxel_size, volume.origin);
    Volume {
        dimensions: [nx, nz, ny].map(|n| n as u32),
        voxel_size: [hx, hz, hy],
        origin: [x, z, -(y + ny as f32 * hy)],
        density: rows().flat_map(|row| volume.density[row..row + nx].iter().copied()).collect(),
        velocity: volume
            .velocity
            .as_ref()
            .map(|values| rows().flat_map(|row| values[row..row + nx].iter().map(|[x, y, z]| [*x, *z, -y])).collect()),
    }
}

/// Description of the volume of an open archive.
pub fn shape_of(archive: &mut Archive, grids: &Grids) -> Result<Shape, ReadError> {
    let dimensions = density_header(archive, grids)?;
    let velocity = velocity_header(archive, grids, dimensions)?;
    Ok(Shape { dimensions, voxel_size: voxel_size(archive)?, origin: origin(archive)?, velocity })
}

/// What a file has of a volume.
pub(super) fn contents(path: &Path, grids: &Grids) -> Result<Contents, ReadError> {
    let mut archive = Archive::open(path)?;
    let dimensions = density_header(&mut archive, grids)?;
    if dimensions.contains(&0) {
        return Ok(Contents { dimensions: None, velocity: velocity_header(&mut archive, grids, dimensions)? });
    }
    let Shape { dimensions, velocity, .. } = shape_of(&mut archive, grids)?;
    Ok(Contents { dimensions: Some(dimensions), velocity })
}

/// The values of an array whose header has been read.
fn values(archive: &mut Archive, name: &str, limit: u64) -> Result<Vec<f32>, ReadError> {
    Ok(archive.read(name, limit)?.map(|array: Array<f32>| array.values).unwrap_or_default())
}

/// Voxels along x, y, z.
fn density_header(archive: &mut Archive, grids: &Grids) -> Result<[u32; 3], ReadError> {
    let name = grids.density_name();
    const EXPECTED: &str = "[nz, ny, nx] of numbers";
    let shape = archive.shape(name, 3, Kind::Any, EXPECTED)?;
    let shape = shape.ok_or_else(|| archive.missing(name, EXPECTED))?;
    let [nz, ny, nx] = shape[..] else {
        return Err(archive.wrong_shape(name, &shape, "three axes, [nz, ny, nx]"));
    };
    if shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis)).is_none_or(|n| n > MAX_VOXELS) {
        let why = format!("of shape {shape:?} is too large");
        return Err(archive.fault(name, why, format!("{MAX_VOXELS} values at most")));
    }
    // No axis is longer than MAX_VOXELS.
    Ok([nx as u32, ny as u32, nz as u32])
}

/// Whether there is a velocity; one that is there fits the density.
fn velocity_header(archive: &mut Archive, grids: &Grids, [nx, ny, nz]: [u32; 3]) -> Result<bool, ReadError> {
    let name = grids.velocity_name();
    let expected = [nz, ny, nx, 3].map(u64::from);
    match archive.shape(name, 4, Kind::Any, "")? {
        Some(shape) if shape != expected => {
            let expected = format!("{expected:?}, that of `{}` and a last axis of 3", grids.density_name());
            Err(archive.wrong_shape(name, &shape, &expected))
        }
        found => Ok(found.is_some()),
    }
}

fn voxel_size(archive: &mut Archive) -> Result<[f32; 3], ReadError> {
    let expected = "one number or three, in metres, above 0 and finite, at most 1e12";
    let Some(array) = archive.read::<f32>("voxel_size", 3)? else {
        return Err(archive.missing("voxel_size", expected));
    };
    let size = match (&without_ones(&array.shape)[..], &array.values[..]) {
        ([], &[h]) => [h; 3],
        ([3], &[x, y, z]) => [x, y, z],
        _ => return Err(archive.wrong_shape("voxel_size", &array.shape, expected)),
    };
    match size.iter().all(|&h| h > 0.0 && h <= FARTHEST) {
        true => Ok(size),
        false => Err(archive.fault("voxel_size", format!("is {size:?} as f32"), expected)),
    }
}

fn origin(archive: &mut Archive) -> Result<[f32; 3], ReadError> {
    let expected = "three finite numbers, in metres, none beyond 1e12";
    let Some(array) = archive.read::<f32>("origin", 3)? else {
        return Ok([0.0; 3]);
    };
    let ([3], &[x, y, z]) = (&without_ones(&array.shape)[..], &array.values[..]) else {
        return Err(archive.wrong_shape("origin", &array.shape, expected));
    };
    match [x, y, z].iter().all(|o| o.abs() <= FARTHEST) {
        true => Ok([x, y, z]),
        false => Err(archive.fault("origin", format!("is {:?} as f32", [x, y, z]), expected)),
    }
}

/// The axes that have more than one element, or none.
fn without_ones(shape: &[u64]) -> Vec<u64> {
    shape.iter().copied().filter(|&axis| axis != 1).collect()
}

/// Writes a volume as an `.npz` file of f32 arrays that [`read`] gives back bit for bit. Atomic.
pub fn write_npz(path: &Path, volume: &Volume) -> Result<(), WriteError> {
    let [nx, ny, nz] = volume.dimensions.map(u64::from);
    write_atomic(path, |file| {
        let mut npz = ArchiveWriter::new(file);
        put(&mut npz, "density", &[nz, ny, nx], &volume.density)?;
        if let Some(velocity) = &volume.velocity {
            put(&mut npz, "velocity", &[nz, ny, nx, 3], velocity.as_flattened())?;
        }
        put(&mut npz, "voxel_size", &[3], &volume.voxel_size)?;
        put(&mut npz, "origin", &[3], &volume.origin)?;
        npz.finish().map(|_| ())
    })
}

fn put<W: io::Write + io::Seek>(
    npz: &mut ArchiveWriter<W>,
    name: &str,
    shape: &[u64],
    values: &[f32],
) -> io::Result<()> {
    check_count(shape, values.len())?;
    npz.add(name, shape, values.iter().copied())
}
