//! Density volumes: reading `.npz` and `.vdb`, and sequences of them.

mod npz;
mod vdb;

use std::path::Path;

pub use self::npz::{shape_of as shape_of_npz, write_npz};
use super::ReadError;
use super::sequence::{Input, Sequence, Source};
use crate::data::Volume;
use crate::simulate::smoke;

/// Most voxels of a volume that is read: a small file can unpack to any size.
pub const MAX_VOXELS: u64 = 1 << 30;

/// Largest component of a velocity, in metres per second.
pub const FASTEST: f32 = 1e6;

/// Which grids (in `.npz` files: arrays) are read, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Grids {
    /// The density; default `density`. `name[1]` is the second of that name.
    pub density: Option<String>,
    /// The velocity; default `velocity`, or in `.vdb` files the first of `velocity`, `vel` and `v`, of vectors or three of
    /// numbers (`vel.x`, `velX`, `vel_x`).
    pub velocity: Option<String>,
    /// Which axis is up in the files.
    pub up: Up,
    /// What velocities are multiplied with to be metres per second.
    pub velocity_scale: f32,
}

impl Default for Grids {
    fn default() -> Grids {
        Grids { density: None, velocity: None, up: Up::Y, velocity_scale: 1.0 }
    }
}

/// An axis that is up: no file says which.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Up {
    /// The second, as here.
    #[default]
    Y,
    /// The third: (x, y, z) of a file is (x, z, -y) here.
    Z,
}

impl Grids {
    fn density_name(&self) -> &str {
        self.density.as_deref().unwrap_or("density")
    }

    fn velocity_name(&self) -> &str {
        self.velocity.as_deref().unwrap_or("velocity")
    }
}

/// Description of a volume, without its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// As [`Volume::voxel_size`].
    pub voxel_size: [f32; 3],
    /// As [`Volume::origin`].
    pub origin: [f32; 3],
    /// Whether there is a velocity.
    pub velocity: bool,
}

/// What a file has of a volume.
#[derive(Clone, Copy, Debug)]
struct Contents {
    /// Voxels along x, y, z, of a density that has any.
    dimensions: Option<[u32; 3]>,
    velocity: bool,
}

/// A kind of file.
#[derive(Clone, Copy)]
enum Format {
    Npz,
    Vdb,
}

impl Format {
    fn of(path: &Path) -> Result<Format, ReadError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("npz") => Ok(Format::Npz),
            Some("vdb") => Ok(Format::Vdb),
            _ => Err(ReadError::file(path, "not a volume by its name", "a name that ends in .npz or .vdb")),
        }
    }
}

/// Reads a volume from a file, as its name ends: `.npz` ([`npz::read`]) or OpenVDB's `.vdb`. One that has no voxels (or, in
/// `.vdb` files, no such grid) is one without smoke.
///
/// # Errors
/// What cannot be read, with its place; an infinite density or a velocity beyond [`FASTEST`], with the voxel.
pub fn read(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
    match Format::of(path)? {
        Format::Npz => npz::read(path, grids),
        Format::Vdb => vdb::read(path, grids),
    }
}

fn contents(path: &Path, grids: &Grids) -> Result<Contents, ReadError> {
    match Format::of(path)? {
        Format::Npz => npz::contents(path, grids),
        Format::Vdb => vdb::contents(path, grids),
    }
}

impl Volume {
    /// One voxel of nothing.
    fn without_smoke(velocity: bool) -> Volume {
        let velocity = velocity.then(|| vec![[0.0; 3]]);
        Volume { dimensions: [1; 3], voxel_size: [1.0; 3], origin: [0.0; 3], density: vec![0.0], velocity }
    }
}

/// Contents of the volumes of a sequence, as far as headers tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Most voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// Whether there are velocities.
    pub velocity: bool,
    /// Whether some volumes have none all the same: nothing moves there.
    pub still: bool,
}

impl Extent {
    /// An error if the volume that was read from `path` is not within the extent: then the file is no longer the one
    /// whose header was read.
    pub fn check(&self, volume: &Volume, path: &Path) -> Result<(), ReadError> {
        let [nx, ny, nz] = volume.dimensions;
        if (0..3).any(|axis| volume.dimensions[axis] > self.dimensions[axis]) {
            let [x, y, z] = self.dimensions;
            let expected = format!("at most [{z}, {y}, {x}], as when the rendering began");
            return Err(ReadError::at(path, "density", format!("has grown to [{nz}, {ny}, {nx}]"), expected));
        }
        match (volume.velocity.is_some(), self.velocity) {
            (true, false) => Err(ReadError::at(path, "velocity", "is there", "none, as when the rendering began")),
            (false, true) if !self.still => {
                Err(ReadError::at(path, "velocity", "is missing", "one, as when the rendering began"))
            }
            _ => Ok(()),
        }
    }
}

impl Input for Volume {
    type Builtin = smoke::Builtin;
    type Options = Grids;
    const ONE: &str = "a volume";

    fn builtin(name: &str) -> Result<smoke::Builtin, String> {
        let which = smoke::Builtin::named(name);
        which.ok_or_else(|| "no such volume; there are builtin:plume and builtin:cloud".to_owned())
    }

    fn make(which: smoke::Builtin, frame: u32, fps: f64) -> Volume {
        which.volume(frame, fps)
    }

    fn read(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
        read(path, grids)
    }
}

/// The volumes of a shot: `builtin:plume`, `builtin:cloud` or files.
pub type VolumeSequence = Sequence<Volume>;

impl VolumeSequence {
    /// The extent of these frames' volumes, from the headers of all files, so that a missing or unfit one is found
    /// before work begins. A frame may be without smoke, or be still because it has no velocity, but not all of them without
    /// smoke: then a name is wrong. Where these frames do not tell, `others` of the shot do, as far as their files are there:
    /// frames that are rendered alone are as among all.
    pub fn extent(
        &self,
        frames: impl IntoIterator<Item = u32>,
        others: impl IntoIterator<Item = u32>,
    ) -> Result<Extent, ReadError> {
        let grids = self.options();
        let (mut extent, mut first, mut has_smoke) =
            (Extent { dimensions: [1; 3], velocity: false, still: false }, None, false);
        for source in self.sources(frames) {
            let path = match source? {
                Source::File(path) => path,
                Source::Builtin { which, frame, fps } => {
                    // All frames of a built-in volume are of one size.
                    let volume = which.volume(frame, fps);
                    let velocity = volume.velocity.is_some();
                    return Ok(Extent { dimensions: volume.dimensions, velocity, still: !velocity });
                }
            };
            let Contents { dimensions, velocity } = contents(&path, grids)?;
            extent.velocity |= velocity;
            extent.still |= !velocity;
            has_smoke |= dimensions.is_some();
            let dimensions = dimensions.unwrap_or_default();
            (0..3).for_each(|axis| extent.dimensions[axis] = extent.dimensions[axis].max(dimensions[axis]));
            first.get_or_insert(path);
        }
        for source in self.sources(others) {
            if has_smoke && extent.velocity {
                break;
            }
            // What cannot be read is told when it is rendered.
            let Ok(Source::File(path)) = source else { continue };
            let Ok(Contents { dimensions, velocity }) = contents(&path, grids) else { continue };
            extent.velocity |= velocity;
            has_smoke |= dimensions.is_some();
        }
        match first {
            Some(path) if !has_smoke => Err(self.without_smoke(&path)),
            Some(path) if grids.velocity.is_some() && !extent.velocity => {
                let why = format!("no frame has a velocity `{}`", grids.velocity_name());
                Err(ReadError::file(&path, why, "smoke.velocity_grid to name a grid of vectors"))
            }
            _ => Ok(extent),
        }
    }

    /// What is wrong where no frame has smoke, of which a file is the first.
    fn without_smoke(&self, path: &Path) -> ReadError {
        let grids = self.options();
        match Format::of(path) {
            Ok(Format::Vdb) => vdb::missing(path, grids),
            _ => ReadError::at(path, grids.density_name(), "has no voxels, in any frame", "some in one of them"),
        }
    }
}

#[cfg(test)]
mod tests;
