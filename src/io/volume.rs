//! Density volumes: reading and writing `.npz`, and sequences of them.

use std::io;
use std::path::Path;

use super::array::{Archive, ArchiveWriter, Array, Kind, check_count};
use super::sequence::{Input, Sequence, Source};
use super::{ReadError, WriteError, write_atomic};
use crate::data::Volume;
use crate::simulate::smoke;
use crate::view::FARTHEST;

/// Most voxels of a volume that is read: a small file can unpack to any size.
pub const MAX_VOXELS: u64 = 1 << 30;

/// Largest component of a velocity, in metres per second.
pub const FASTEST: f32 = 1e6;

/// Names of the grids (in `.npz` files: arrays) to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grids {
    /// The density; default `density`.
    pub density: Option<String>,
    /// The velocity; default `velocity` where there is one. A name that is given must be there.
    pub velocity: Option<String>,
}

/// Reads a volume from an `.npz` file: `density` [nz, ny, nx], optionally `velocity` [nz, ny, nx, 3] in m/s, `voxel_size`
/// (a number or three, metres, above 0) and optionally `origin` (three numbers, default 0, 0, 0), all of any float or integer type,
/// which become f32. At most [`MAX_VOXELS`] voxels, at least one. NaN is no smoke, or no motion; an infinite density or a
/// velocity beyond [`FASTEST`] is an error that names the voxel (x, y, z), counted from 0.
pub fn read(path: &Path, grids: &Grids) -> Result<Volume, ReadError> {
    let mut archive = open(path)?;
    density_header(&mut archive, grids)?;
    let density = values(&mut archive, density_name(grids), MAX_VOXELS)?;
    let Shape { dimensions, voxel_size, origin, velocity } = shape(&mut archive, grids)?;
    let place = |name: &str, at: usize| {
        let [nx, ny] = [dimensions[0] as usize, dimensions[1] as usize];
        format!("array `{name}`, voxel ({}, {}, {})", at % nx, at / nx % ny, at / nx / ny)
    };
    if let Some(at) = density.iter().position(|d: &f32| d.is_infinite()) {
        let why = format!("is {} as f32", density[at]);
        return Err(ReadError::at(path, place(density_name(grids), at), why, "a finite density"));
    }
    let velocity: Option<Vec<[f32; 3]>> = match velocity {
        true => Some(values(&mut archive, velocity_name(grids), 3 * MAX_VOXELS)?.as_chunks().0.to_vec()),
        false => None,
    };
    let is_too_fast = |v: &[f32; 3]| v.iter().any(|c| c.abs() > FASTEST);
    if let Some((at, v)) = velocity.iter().flatten().enumerate().find(|(_, v)| is_too_fast(v)) {
        let expected = format!("m/s, none beyond {FASTEST}");
        return Err(ReadError::at(path, place(velocity_name(grids), at), format!("is {v:?} as f32"), expected));
    }
    Ok(Volume { dimensions, voxel_size, origin, density, velocity })
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

/// Description of the volume of an open archive.
pub fn shape(archive: &mut Archive, grids: &Grids) -> Result<Shape, ReadError> {
    let dimensions = density_header(archive, grids)?;
    let velocity = velocity_header(archive, grids, dimensions)?;
    Ok(Shape { dimensions, voxel_size: voxel_size(archive)?, origin: origin(archive)?, velocity })
}

/// Opens a file that is a volume by its name.
pub fn open(path: &Path) -> Result<Archive, ReadError> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("npz") => Archive::open(path),
        Some("vdb") => Err(ReadError::file(path, "OpenVDB files cannot be read yet", "an .npz file")),
        _ => Err(ReadError::file(path, "not a volume by its name", "a name that ends in .npz")),
    }
}

/// Contents of the volumes of a sequence, as far as headers tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Most voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// Whether there are velocities.
    pub velocity: bool,
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
        if volume.velocity.is_some() != self.velocity {
            let why = if self.velocity { "is missing" } else { "is there" };
            let expected = if self.velocity { "one" } else { "none" };
            let expected = format!("{expected}, as when the rendering began");
            return Err(ReadError::at(path, "velocity", why, expected));
        }
        Ok(())
    }
}

/// The values of an array whose header has been read.
fn values(archive: &mut Archive, name: &str, limit: u64) -> Result<Vec<f32>, ReadError> {
    Ok(archive.read(name, limit)?.map(|array: Array<f32>| array.values).unwrap_or_default())
}

/// Voxels along x, y, z.
fn density_header(archive: &mut Archive, grids: &Grids) -> Result<[u32; 3], ReadError> {
    let name = density_name(grids);
    const EXPECTED: &str = "[nz, ny, nx] of numbers";
    let shape = archive.shape(name, 3, Kind::Any, EXPECTED)?;
    let shape = shape.ok_or_else(|| archive.missing(name, EXPECTED))?;
    let [nz, ny, nx] = shape[..] else {
        return Err(archive.wrong_shape(name, &shape, "three axes, [nz, ny, nx]"));
    };
    if shape.contains(&0) {
        return Err(archive.wrong_shape(name, &shape, "at least one voxel along each axis"));
    }
    if shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis)).is_none_or(|n| n > MAX_VOXELS) {
        let why = format!("of shape {shape:?} is too large");
        return Err(archive.fault(name, why, format!("{MAX_VOXELS} values at most")));
    }
    // No axis is longer than MAX_VOXELS.
    Ok([nx as u32, ny as u32, nz as u32])
}

/// Whether there is a velocity; one that is there fits the density.
fn velocity_header(archive: &mut Archive, grids: &Grids, [nx, ny, nz]: [u32; 3]) -> Result<bool, ReadError> {
    let name = velocity_name(grids);
    let expected = [nz, ny, nx, 3].map(u64::from);
    match archive.shape(name, 4, Kind::Any, "")? {
        None if grids.velocity.is_some() => Err(archive.missing(name, "[nz, ny, nx, 3] of numbers")),
        Some(shape) if shape != expected => {
            let expected = format!("{expected:?}, that of `{}` and a last axis of 3", density_name(grids));
            Err(archive.wrong_shape(name, &shape, &expected))
        }
        found => Ok(found.is_some()),
    }
}

fn density_name(grids: &Grids) -> &str {
    grids.density.as_deref().unwrap_or("density")
}

fn velocity_name(grids: &Grids) -> &str {
    grids.velocity.as_deref().unwrap_or("velocity")
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
    /// before work begins. Either all volumes of a sequence have velocities or none.
    pub fn extent(&self, frames: impl IntoIterator<Item = u32>) -> Result<Extent, ReadError> {
        let grids = self.options();
        let mut extent: Option<Extent> = None;
        for source in self.sources(frames) {
            let path = match source? {
                Source::File(path) => path,
                Source::Builtin { which, frame, fps } => {
                    // All frames of a built-in volume are of one size.
                    let volume = which.volume(frame, fps);
                    return Ok(Extent { dimensions: volume.dimensions, velocity: volume.velocity.is_some() });
                }
            };
            let mut archive = open(&path)?;
            let dimensions = density_header(&mut archive, grids)?;
            let velocity = velocity_header(&mut archive, grids, dimensions)?;
            let largest = extent.get_or_insert(Extent { dimensions, velocity });
            if velocity != largest.velocity {
                let why = if velocity { "is there" } else { "is missing" };
                let expected = "a velocity in all volumes of the sequence or in none";
                return Err(archive.fault(velocity_name(grids), why, expected));
            }
            (0..3).for_each(|axis| largest.dimensions[axis] = largest.dimensions[axis].max(dimensions[axis]));
        }
        Ok(extent.unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::super::array::tests::{npy, write_archive};
    use super::super::tests::Folder;
    use super::*;
    use std::fs;
    use std::sync::Arc;

    /// 2 x 3 x 4 voxels of numbers that tell where they are; NaN and the largest among them.
    fn numbered(velocity: bool) -> Volume {
        let mut density: Vec<f32> = (0..24).map(|i| i as f32 * 0.1).collect();
        density[3..6].copy_from_slice(&[f32::NAN, f32::MAX, f32::MIN]);
        Volume {
            dimensions: [2, 3, 4],
            voxel_size: [0.1, 0.2, 0.25],
            origin: [-1.0, 0.0, 2.5],
            density,
            velocity: velocity.then(|| (0..24).map(|i| [i as f32, -0.5, 1e-30 * i as f32]).collect()),
        }
    }

    fn bits(volume: &Volume) -> (Vec<u32>, Option<Vec<u32>>) {
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect();
        (bits(&volume.density), volume.velocity.as_ref().map(|v| bits(v.as_flattened())))
    }

    fn f32s(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// Arrays of a valid volume of 1 x 2 x 2 voxels.
    fn arrays() -> Vec<(&'static str, Vec<u8>)> {
        vec![
            ("density", npy("'<f4'", false, "(2, 2, 1)", &f32s(&[0.0, 1.0, 2.0, 3.0]))),
            ("velocity", npy("'<f4'", false, "(2, 2, 1, 3)", &f32s(&[1.0; 12]))),
            ("voxel_size", npy("'<f8'", false, "()", &0.5f64.to_le_bytes())),
            ("origin", npy("'<i4'", false, "(3,)", &[1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0])),
        ]
    }

    fn read_arrays(arrays: &[(&str, Vec<u8>)]) -> Result<Volume, ReadError> {
        let folder = Folder::new();
        let path = folder.0.join("v.npz");
        write_archive(&path, arrays);
        read(&path, &Grids::default())
    }

    /// The error with one array replaced, or left out.
    fn error_with(name: &'static str, bytes: Option<Vec<u8>>) -> String {
        let mut arrays = arrays();
        arrays.retain(|(n, _)| *n != name);
        arrays.extend(bytes.map(|b| (name, b)));
        read_arrays(&arrays).unwrap_err().to_string()
    }

    #[test]
    fn written_volumes_come_back() {
        let folder = Folder::new();
        for velocity in [false, true] {
            let path = folder.0.join("out/v.NPZ");
            let volume = numbered(velocity);
            write_npz(&path, &volume).unwrap();
            let back = read(&path, &Grids::default()).unwrap();
            assert_eq!(bits(&back), bits(&volume));
            assert_eq!(
                (back.dimensions, back.voxel_size, back.origin),
                (volume.dimensions, volume.voxel_size, volume.origin)
            );
        }
        let short = Volume { density: vec![0.0; 3], ..numbered(false) };
        assert!(write_npz(&folder.0.join("short.npz"), &short).is_err());
        assert_eq!(folder.names(), ["out"]);
    }

    #[test]
    fn half_double_and_fortran_order_are_read() {
        let volume = read_arrays(&arrays()).unwrap();
        assert_eq!((volume.dimensions, volume.voxel_size), ([1, 2, 2], [0.5; 3]));
        assert_eq!(volume.origin, [1.0, 2.0, 3.0]);
        let halves: Vec<u8> = [0u16, 0x3c00, 0x4000, 0x4200].iter().flat_map(|v| v.to_be_bytes()).collect();
        // Fortran order: z runs fastest, so the four values are transposed.
        let doubles: Vec<u8> = [0.0f64, 2.0, 1.0, 3.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let components: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let velocity = npy("'<f4'", true, "(2, 2, 1, 3)", &f32s(&components));
        for density in [npy("'>f2'", false, "(2, 2, 1)", &halves), npy("'<f8'", true, "(2, 2, 1)", &doubles)] {
            let mut arrays = arrays();
            (arrays[0].1, arrays[1].1) = (density, velocity.clone());
            let read = read_arrays(&arrays).unwrap();
            assert_eq!(read.density, volume.density);
            // Index z + 2 y + 4 component in the file; x fastest, then y, then z in memory.
            let expected = [[0.0, 4.0, 8.0], [2.0, 6.0, 10.0], [1.0, 5.0, 9.0], [3.0, 7.0, 11.0]];
            assert_eq!(read.velocity.unwrap(), expected);
        }
    }

    #[test]
    fn integers_and_axes_of_one_are_read() {
        let volume = read_arrays(&arrays()).unwrap();
        let [size, origin] = [[0.5f32; 3], [1.0, 2.0, 3.0]];
        let changed = [
            ("density", npy("'|u1'", false, "(2, 2, 1)", &[0, 1, 2, 3])),
            ("density", npy("'<f4'", false, "(2, 2, 1, 1)", &f32s(&volume.density))),
            ("velocity", npy("'|i1'", false, "(2, 2, 1, 3)", &[1; 12])),
            ("voxel_size", npy("'<f4'", false, "(1, 1)", &f32s(&size[..1]))),
            ("voxel_size", npy("'<f4'", false, "(1, 3)", &f32s(&size))),
            ("origin", npy("'<f4'", true, "(3, 1)", &f32s(&origin))),
        ];
        for (name, bytes) in changed {
            let mut arrays = arrays();
            arrays.retain(|(n, _)| *n != name);
            arrays.push((name, bytes));
            assert_eq!(read_arrays(&arrays).unwrap(), volume, "{name}");
        }
    }

    #[test]
    fn optional_arrays_and_other_names() {
        let mut arrays = arrays();
        arrays.remove(3);
        arrays.remove(1);
        let volume = read_arrays(&arrays).unwrap();
        assert_eq!((volume.velocity, volume.origin), (None, [0.0; 3]));
        arrays.push(("vel", npy("'<f4'", false, "(2, 2, 1, 3)", &f32s(&[2.0; 12]))));
        let folder = Folder::new();
        let path = folder.0.join("v.npz");
        write_archive(&path, &arrays);
        let grids = Grids { velocity: Some("vel".into()), ..Grids::default() };
        assert_eq!(read(&path, &grids).unwrap().velocity, Some(vec![[2.0; 3]; 4]));
        let grids = Grids { velocity: Some("wind".into()), ..Grids::default() };
        let error = read(&path, &grids).unwrap_err().to_string();
        assert!(error.contains("array `wind`: is missing") && error.contains("\"vel\""), "{error}");
        let grids = Grids { density: Some("fuel".into()), ..Grids::default() };
        assert!(read(&path, &grids).unwrap_err().to_string().contains("array `fuel`: is missing"));
    }

    #[test]
    fn every_fault_names_its_array() {
        let says = |error: String, words: &[&str]| {
            assert!(words.iter().all(|w| error.contains(w)) && error.contains("v.npz"), "{error}");
        };
        says(error_with("density", None), &["array `density`: is missing", "[nz, ny, nx]"]);
        says(error_with("density", Some(npy("'<f4'", false, "(4,)", &[0; 16]))), &["`density`", "[4]", "three axes"]);
        says(error_with("density", Some(npy("'<f4'", false, "(2, 0, 2)", &[]))), &["[2, 0, 2]", "at least one voxel"]);
        says(error_with("density", Some(npy("'|O'", false, "(2, 2, 1)", &[0; 16]))), &["`|O`", "f16, f32 or f64"]);
        let huge = npy("'<f4'", false, "(1024, 1024, 1025)", &[0; 16]);
        says(error_with("density", Some(huge)), &["too large", "1073741824 values at most"]);
        let promised = npy("'<f4'", false, "(1024, 1024, 1024)", &[0; 16]);
        says(error_with("density", Some(promised)), &["16 bytes", "4294967296 bytes"]);
        let other = npy("'<f4'", false, "(2, 2, 3)", &[0; 48]);
        says(error_with("velocity", Some(other)), &["array `velocity`", "[2, 2, 3]", "[2, 2, 1, 3]"]);
        // The fourth voxel is the second along y and along z.
        for bad in [f32::INFINITY, f32::NEG_INFINITY] {
            let density = npy("'<f4'", false, "(2, 2, 1)", &f32s(&[0.0, f32::NAN, 1.0, bad]));
            says(
                error_with("density", Some(density)),
                &["array `density`, voxel (0, 1, 1): is", "inf", "a finite density"],
            );
        }
        for bad in [f32::INFINITY, -1.1e6] {
            let mut components = [f32::NAN; 12];
            components[10] = bad;
            let velocity = npy("'<f4'", false, "(2, 2, 1, 3)", &f32s(&components));
            says(error_with("velocity", Some(velocity)), &["array `velocity`, voxel (0, 1, 1): is [NaN, ", "m/s"]);
        }
        says(error_with("voxel_size", None), &["array `voxel_size`: is missing", "metres"]);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-60, 1e60] {
            let scalar = npy("'<f8'", false, "()", &bad.to_le_bytes());
            says(error_with("voxel_size", Some(scalar)), &["array `voxel_size`", "above 0 and finite"]);
            if !(bad <= 0.0 || bad < 1.0) {
                let three = npy("'<f8'", false, "(3,)", &[0.0, bad, 0.0].map(f64::to_le_bytes).concat());
                says(error_with("origin", Some(three)), &["array `origin`", "finite"]);
            }
        }
        let two = npy("'<f8'", false, "(2,)", &[0; 16]);
        says(error_with("voxel_size", Some(two.clone())), &["array `voxel_size`", "[2]"]);
        says(error_with("origin", Some(two)), &["array `origin`", "[2]"]);
    }

    #[test]
    fn files_that_are_no_volumes_are_named() {
        let folder = Folder::new();
        let says = |name: &str, bytes: Option<&[u8]>, words: &[&str]| {
            let path = folder.0.join(name);
            if let Some(bytes) = bytes {
                fs::write(&path, bytes).unwrap();
            }
            let error = read(&path, &Grids::default()).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)) && error.contains(name), "{error}");
        };
        says("absent.npz", None, &["No such file"]);
        says("text.npz", Some(b"hello"), &["no zip archive"]);
        says("empty.npz", Some(b""), &["no zip archive"]);
        says("smoke.vdb", Some(b" BDV"), &["OpenVDB files cannot be read yet"]);
        says("smoke.raw", Some(b""), &[".npz"]);
        let path = folder.0.join("whole.npz");
        write_npz(&path, &numbered(true)).unwrap();
        let whole = fs::read(&path).unwrap();
        says("cut.npz", Some(&whole[..whole.len() - 30]), &["cut short"]);
    }

    #[test]
    fn the_extent_of_a_sequence_is_known_from_its_headers() {
        let folder = Folder::new();
        for (frame, dimensions) in [(1, [3, 1, 2]), (2, [1, 4, 2])] {
            let density = vec![1.0; dimensions.iter().product::<u32>() as usize];
            let volume = Volume { dimensions, density, ..numbered(false) };
            write_npz(&folder.0.join(format!("v.{frame:04}.npz")), &volume).unwrap();
        }
        write_npz(&folder.0.join("v.0004.npz"), &numbered(true)).unwrap();
        let open = |name: &str, hold| VolumeSequence::new(name, &folder.0, Grids::default(), hold, 24.0).unwrap();
        let files = open("v.####.npz", true);
        assert_eq!(files.extent(1..=3).unwrap(), Extent { dimensions: [3, 4, 2], velocity: false });
        assert_eq!(files.extent(4..=9).unwrap(), Extent { dimensions: numbered(true).dimensions, velocity: true });
        let mixed = files.extent(1..=4).unwrap_err().to_string();
        assert!(mixed.contains("v.0004.npz") && mixed.contains("`velocity`: is there"), "{mixed}");
        let missing = open("v.####.npz", false).extent(1..=4).unwrap_err();
        assert_eq!(missing.path, folder.0.join("v.0003.npz"));
        let plume = open("builtin:plume", false);
        let volume = plume.clone().frame(7).unwrap();
        let extent = Extent { dimensions: volume.dimensions, velocity: volume.velocity.is_some() };
        assert_eq!(plume.extent(1..=1_000_000).unwrap(), extent);
    }

    #[test]
    fn sequences_follow_their_files() {
        let folder = Folder::new();
        for frame in [2, 3, 5] {
            let volume = Volume { origin: [frame as f32, 0.0, 0.0], ..numbered(false) };
            write_npz(&folder.0.join(format!("v.{frame:04}.npz")), &volume).unwrap();
        }
        let open = |name: &str, hold| VolumeSequence::new(name, &folder.0, Grids::default(), hold, 24.0).unwrap();
        let mut strict = open("v.####.npz", false);
        assert_eq!(strict.frame(3).unwrap().origin[0], 3.0);
        assert_eq!(strict.frame(2).unwrap().origin[0], 2.0);
        let error = strict.frame(4).unwrap_err().to_string();
        assert!(error.contains("v.0004.npz") && error.contains("hold"), "{error}");

        let mut hold = open("v.####.npz", true);
        let third = hold.frame(3).unwrap();
        assert!(Arc::ptr_eq(&third, &hold.frame(4).unwrap()));
        assert_eq!(hold.frame(5).unwrap().origin[0], 5.0);
        assert_eq!(hold.frame(u32::MAX).map(|_| ()).unwrap_err().path, folder.0.join("v.4294967295.npz"));
        assert_eq!(hold.frame(90).unwrap().origin[0], 5.0);
        let mut is_same = |f| Arc::ptr_eq(&hold.frame(f - 1).unwrap(), &hold.frame(f).unwrap());
        assert_eq!([3, 4, 5, 6, 7].map(&mut is_same), [false, true, false, true, true]);
        assert!(hold.frame(1).unwrap_err().to_string().contains("none of an earlier frame"));

        let mut single = open("v.0005.npz", false);
        assert!(Arc::ptr_eq(&single.frame(1).unwrap(), &single.frame(900).unwrap()));
        assert!(open("none.npz", true).frame(1).unwrap_err().to_string().contains("none.npz"));
    }

    #[test]
    fn built_in_sequences() {
        let open = |name: &str| VolumeSequence::new(name, Path::new(""), Grids::default(), false, 24.0);
        let mut plume = open("builtin:plume").unwrap();
        assert_eq!(*plume.frame(7).unwrap(), smoke::Builtin::Plume.volume(7, 24.0));
        assert!(!Arc::ptr_eq(&plume.frame(6).unwrap(), &plume.frame(7).unwrap()));
        assert_ne!(plume.frame(7).unwrap(), open("builtin:cloud").unwrap().frame(7).unwrap());
        let error = open("builtin:plum").unwrap_err().to_string();
        assert!(error.contains("builtin:plum:") && error.contains("builtin:plume"), "{error}");
        assert!(open("a##_%d.npz").is_err());
    }

    /// A real simulation, where there is one beside the checkout.
    #[test]
    fn the_shared_simulation_is_read() {
        let pattern = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/smoke64/plume.####.npz");
        let mut sequence =
            VolumeSequence::new(pattern.to_str().unwrap(), Path::new(""), Grids::default(), false, 24.0).unwrap();
        if sequence.source(20).is_err() {
            eprintln!("skipped: no {}", pattern.display());
            return;
        }
        let volume = sequence.frame(20).unwrap();
        assert_eq!((volume.dimensions, volume.voxel_size), ([38, 64, 38], [0.03125; 3]));
        assert_eq!(volume.origin, [-0.59375, 0.0, -0.59375]);
        // As NumPy reads them.
        assert_eq!(volume.density.iter().copied().fold(0.0, f32::max), 0.942_871_1);
        assert_eq!(volume.density[(20 * 64 + 30) * 38 + 18], 0.015_625);
        assert_eq!(volume.velocity.as_ref().unwrap()[(20 * 64 + 30) * 38 + 18][1], 0.165_283_2);
    }
}
