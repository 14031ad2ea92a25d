//! Density volumes: reading and writing `.npz`, and sequences of them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use npyz::WriterBuilder;
use npyz::npz::NpzWriter;

use super::array::{Archive, Array, check_count};
use super::pattern::{Pattern, PatternError};
use super::{ReadError, WriteError, write_atomic};
use crate::simulate::smoke;

/// A density volume in memory: x runs fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// Sides of a voxel in metres.
    pub voxel_size: [f32; 3],
    /// World position of the corner of voxel (0, 0, 0).
    pub origin: [f32; 3],
    /// One density per voxel.
    pub density: Vec<f32>,
    /// One velocity (m/s; x, y, z) per voxel.
    pub velocity: Option<Vec<[f32; 3]>>,
}

/// Most voxels of a volume that is read: a small file can unpack to any size.
pub const MAX_VOXELS: u64 = 1 << 30;

/// Names of the grids (in `.npz` files: arrays) to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grids {
    /// The density; default `density`.
    pub density: Option<String>,
    /// The velocity; default `velocity` where there is one. A name that is given must be there.
    pub velocity: Option<String>,
}

/// Reads a volume from an `.npz` file: `density` [nz, ny, nx], optionally `velocity` [nz, ny, nx, 3] in m/s (both f16,
/// f32 or f64, which become f32), `voxel_size` (a number or three, metres, above 0) and optionally `origin` [3]
/// (default 0, 0, 0), both of any float or integer type. At most [`MAX_VOXELS`] voxels, at least one.
pub fn read(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("npz") => read_npz(path, grids),
        Some("vdb") => Err(ReadError::file(path, "OpenVDB files cannot be read yet", "an .npz file")),
        _ => Err(ReadError::file(path, "not a volume by its name", "a name that ends in .npz")),
    }
}

/// What the volumes of a sequence hold, as far as headers tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Most voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// Whether there are velocities.
    pub velocity: bool,
}

fn read_npz(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
    let mut archive = Archive::open(path)?;
    let (dimensions, has_velocity) = check_headers(&mut archive, path, grids)?;
    let mut values = |name: &str, limit: u64| -> Result<Vec<f32>, ReadError> {
        Ok(archive.read(name, limit)?.map(|array: Array<f32>| array.values).unwrap_or_default())
    };
    let density = values(density_name(grids), MAX_VOXELS)?;
    let velocity = if has_velocity { Some(values(velocity_name(grids), 3 * MAX_VOXELS)?) } else { None };
    Ok(Volume {
        dimensions,
        voxel_size: voxel_size(&mut archive, path)?,
        origin: origin(&mut archive, path)?,
        density,
        velocity: velocity.map(|v| v.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()),
    })
}

/// Voxels along x, y, z, and whether there is a velocity.
fn check_headers(archive: &mut Archive, path: &Path, grids: &Grids) -> Result<([u32; 3], bool), ReadError> {
    let name = density_name(grids);
    let shape = float_shape(archive, path, name)?;
    let shape = shape.ok_or_else(|| missing(path, archive, name, "[nz, ny, nx] of floats"))?;
    let [nz, ny, nx] = shape[..] else {
        return Err(wrong_shape(path, name, &shape, "three axes, [nz, ny, nx]"));
    };
    if shape.contains(&0) {
        return Err(wrong_shape(path, name, &shape, "at least one voxel along each axis"));
    }
    if shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis)).is_none_or(|n| n > MAX_VOXELS) {
        return Err(wrong_shape(path, name, &shape, &format!("at most {MAX_VOXELS} voxels")));
    }
    let velocity = float_shape(archive, path, velocity_name(grids))?;
    if velocity.is_none() && grids.velocity.is_some() {
        return Err(missing(path, archive, velocity_name(grids), "[nz, ny, nx, 3] of floats"));
    }
    if let Some(shape) = velocity.as_ref().filter(|shape| **shape != [nz, ny, nx, 3]) {
        let expected = format!("{:?}, that of `{name}` and a last axis of 3", [nz, ny, nx, 3]);
        return Err(wrong_shape(path, velocity_name(grids), shape, &expected));
    }
    // No axis is longer than MAX_VOXELS.
    Ok(([nx as u32, ny as u32, nz as u32], velocity.is_some()))
}

fn density_name(grids: &Grids) -> &str {
    grids.density.as_deref().unwrap_or("density")
}

fn velocity_name(grids: &Grids) -> &str {
    grids.velocity.as_deref().unwrap_or("velocity")
}

/// The shape of an array of floats, if there is one.
fn float_shape(archive: &mut Archive, path: &Path, name: &str) -> Result<Option<Vec<u64>>, ReadError> {
    match archive.header(name)? {
        Some(header) if !header.element.is_float() => {
            Err(ReadError::at(path, format!("array `{name}`"), "elements are integers", "f16, f32 or f64"))
        }
        header => Ok(header.map(|header| header.shape)),
    }
}

fn voxel_size(archive: &mut Archive, path: &Path) -> Result<[f32; 3], ReadError> {
    let expected = "one number or three, in metres, above 0 and finite";
    let Some(array) = archive.read::<f32>("voxel_size", 3)? else {
        return Err(missing(path, archive, "voxel_size", expected));
    };
    let size = match (&array.shape[..], &array.values[..]) {
        ([] | [1], &[h]) => [h; 3],
        ([3], &[x, y, z]) => [x, y, z],
        _ => return Err(wrong_shape(path, "voxel_size", &array.shape, expected)),
    };
    match size.iter().all(|&h| h > 0.0 && h.is_finite()) {
        true => Ok(size),
        false => Err(ReadError::at(path, "array `voxel_size`", format!("is {size:?} as f32"), expected)),
    }
}

fn origin(archive: &mut Archive, path: &Path) -> Result<[f32; 3], ReadError> {
    let expected = "three finite numbers, in metres";
    let Some(array) = archive.read::<f32>("origin", 3)? else {
        return Ok([0.0; 3]);
    };
    let (&[3], &[x, y, z]) = (&array.shape[..], &array.values[..]) else {
        return Err(wrong_shape(path, "origin", &array.shape, expected));
    };
    match [x, y, z].iter().all(|o| o.is_finite()) {
        true => Ok([x, y, z]),
        false => Err(ReadError::at(path, "array `origin`", format!("is {:?} as f32", [x, y, z]), expected)),
    }
}

fn missing(path: &Path, archive: &Archive, name: &str, expected: &str) -> ReadError {
    let why = format!("is missing; the file has {:?}", archive.names());
    ReadError::at(path, format!("array `{name}`"), why, expected)
}

fn wrong_shape(path: &Path, name: &str, shape: &[u64], expected: &str) -> ReadError {
    ReadError::at(path, format!("array `{name}`"), format!("has shape {shape:?}"), expected)
}

/// Writes a volume as an `.npz` file of f32 arrays that [`read`] gives back bit for bit. Atomic.
pub fn write_npz(path: &Path, volume: &Volume) -> Result<(), WriteError> {
    let [nx, ny, nz] = volume.dimensions.map(u64::from);
    write_atomic(path, |file| {
        let mut npz = NpzWriter::new(file);
        put(&mut npz, "density", &[nz, ny, nx], &volume.density)?;
        if let Some(velocity) = &volume.velocity {
            put(&mut npz, "velocity", &[nz, ny, nx, 3], velocity.as_flattened())?;
        }
        put(&mut npz, "voxel_size", &[3], &volume.voxel_size)?;
        put(&mut npz, "origin", &[3], &volume.origin)?;
        npz.zip_writer().finish().map(|_| ()).map_err(io::Error::other)
    })
}

fn put<W: io::Write + io::Seek>(npz: &mut NpzWriter<W>, name: &str, shape: &[u64], values: &[f32]) -> io::Result<()> {
    check_count(shape, values.len())?;
    let mut writer = npz.array::<f32>(name, Default::default())?.default_dtype().shape(shape).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()
}

/// Where the volume of a frame comes from. Frames of equal source have the same volume.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    Builtin { which: smoke::Builtin, frame: u32, fps: f64 },
    File(PathBuf),
}

#[derive(Clone, Debug)]
enum Kind {
    Builtin { which: smoke::Builtin, fps: f64 },
    Files(Pattern),
}

/// How far back `hold` looks for a file, in frames.
const MAX_HOLD: u32 = 100_000;

/// The volumes of a shot, one per frame: a built-in one, one file for all frames, or files numbered by frame.
#[derive(Clone, Debug)]
pub struct VolumeSequence {
    kind: Kind,
    grids: Grids,
    hold: bool,
    last: Option<(Source, Arc<Volume>)>,
}

impl VolumeSequence {
    /// `volume` is `builtin:plume`, `builtin:cloud`, or a path relative to `folder`, with a place for the frame number
    /// (see [`Pattern`]) or without. With `hold`, a missing frame has the volume of the last one before it that is
    /// there (at most 100,000 frames back). `fps` (above 0) is the time scale of the built-in volumes.
    pub fn new(
        volume: &str,
        folder: &Path,
        grids: Grids,
        hold: bool,
        fps: f64,
    ) -> Result<VolumeSequence, PatternError> {
        let kind = match volume.strip_prefix("builtin:") {
            Some(name) => match smoke::Builtin::named(name) {
                Some(which) => Kind::Builtin { which, fps },
                None => {
                    let why = "no such volume; there are builtin:plume and builtin:cloud".into();
                    return Err(PatternError { path: volume.into(), why });
                }
            },
            None => Kind::Files(Pattern::parse(volume)?.below(folder)),
        };
        Ok(VolumeSequence { kind, grids, hold, last: None })
    }

    /// The volume of a frame. The last one is kept, so that a frame with the same volume costs nothing.
    pub fn frame(&mut self, frame: u32) -> Result<Arc<Volume>, ReadError> {
        let source = self.source(frame)?;
        if let Some((last, volume)) = &self.last {
            if *last == source {
                return Ok(volume.clone());
            }
        }
        let volume = Arc::new(match &source {
            Source::File(path) => read(path, &self.grids)?,
            Source::Builtin { which, frame, fps } => which.volume(*frame, *fps),
        });
        self.last = Some((source, volume.clone()));
        Ok(volume)
    }

    /// The extent of these frames' volumes, from the headers of all files, so that a missing or unfit one is found
    /// before work begins. Either all volumes of a sequence have velocities or none.
    pub fn extent(&self, first: u32, last: u32) -> Result<Extent, ReadError> {
        let mut extent: Option<Extent> = None;
        let mut before = None;
        for frame in first..=last {
            let source = self.source(frame)?;
            if before.as_ref() == Some(&source) {
                continue;
            }
            let path = match &source {
                Source::File(path) => path,
                Source::Builtin { which, frame, fps } => {
                    // All frames of a built-in volume are of one size.
                    let volume = which.volume(*frame, *fps);
                    return Ok(Extent { dimensions: volume.dimensions, velocity: volume.velocity.is_some() });
                }
            };
            let (dimensions, velocity) = check_headers(&mut Archive::open(path)?, path, &self.grids)?;
            let largest = extent.get_or_insert(Extent { dimensions, velocity });
            if velocity != largest.velocity {
                let why = if velocity { "is there" } else { "is missing" };
                let expected = "a velocity in all volumes of the sequence or in none";
                return Err(ReadError::at(path, format!("array `{}`", velocity_name(&self.grids)), why, expected));
            }
            (0..3).for_each(|axis| largest.dimensions[axis] = largest.dimensions[axis].max(dimensions[axis]));
            before = Some(source);
        }
        Ok(extent.unwrap_or_default())
    }

    /// Whether `frame` has the very volume of the frame before, so that it need not be read or uploaded again.
    pub fn same_as_before(&self, frame: u32) -> Result<bool, ReadError> {
        let source = self.source(frame)?;
        // The frame before the first one need not have a volume.
        Ok(frame.checked_sub(1).is_some_and(|before| self.source(before).is_ok_and(|s| s == source)))
    }

    fn source(&self, frame: u32) -> Result<Source, ReadError> {
        let pattern = match &self.kind {
            Kind::Builtin { which, fps } => return Ok(Source::Builtin { which: *which, frame, fps: *fps }),
            Kind::Files(pattern) => pattern,
        };
        let wanted = pattern.path(frame);
        if exists(&wanted)? {
            return Ok(Source::File(wanted));
        }
        if self.hold && pattern.has_number() {
            for before in (frame.saturating_sub(MAX_HOLD)..frame).rev() {
                let path = pattern.path(before);
                if exists(&path)? {
                    return Ok(Source::File(path));
                }
            }
            return Err(ReadError::file(&wanted, "no such file, and none of an earlier frame to hold", "a volume"));
        }
        let expected = match pattern.has_number() {
            true => format!("a volume for frame {frame} (hold = true keeps the last one before)"),
            false => "a volume".into(),
        };
        Err(ReadError::file(&wanted, "no such file", expected))
    }
}

fn exists(path: &Path) -> Result<bool, ReadError> {
    fs::exists(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))
}
