//! Particles with a temperature: reading `.npz`, and sequences of them.

use std::path::Path;

use super::ReadError;
use super::array::{Archive, Array, Kind, Number};
use super::sequence::{Input, Sequence, Source};
use crate::data::{ParticleExtent, Particles};
use crate::flame::settings::HOTTEST;
use crate::simulate::flame;
use crate::view::FARTHEST;

/// Most particles of a file that is read: a small file can unpack to any size.
pub const MAX_PARTICLES: u64 = 1 << 28;

const POSITIONS: &str = "[n, 3] of numbers, in metres";
const TEMPERATURES: &str = "[n] of numbers, in kelvin, n as in `position`";
const IDS: &str = "[n] of integers, 0 to 4294967295, n as in `position`";
const VELOCITIES: &str = "[n, 3] of numbers, in m/s, n as in `position`";
const FILE: &str = "an .npz file with `position` [n, 3], `temperature` [n] and maybe `id` [n] and `velocity` [n, 3]";

/// Reads particles from an `.npz` file: `position` (n x 3) in metres, `temperature` (n) in kelvin (both of any float or
/// integer type, which become f32) and optionally `id` (n integers, 0 to 4294967295) and `velocity` (n x 3) in m/s. At most [`MAX_PARTICLES`]; none is
/// allowed. A position beyond [`FARTHEST`] or a temperature that is not above 0 and at most [`HOTTEST`] is an error that
/// names the row, counted from 0.
pub fn read(path: &Path) -> Result<Particles, ReadError> {
    let mut archive = open(path)?;
    let count = count(&mut archive)?;
    let temperature = temperature(&mut archive, path, count)?;
    let position: Vec<f32> = values(&mut archive, "position", 3 * count)?;
    let position = position.as_chunks().0.to_vec();
    if let Some(row) = position.iter().position(|p: &[f32; 3]| !p.iter().all(|x| x.abs() <= FARTHEST)) {
        let (why, expected) = (format!("is {:?} as f32", position[row]), "three finite numbers, none beyond 1e12 m");
        return Err(row_error(path, "position", row, why, expected));
    }
    let id = ids(&mut archive, path, count)?;
    let velocity = velocities(&mut archive, path, count)?;
    Ok(Particles { position, temperature, id, velocity })
}

/// Opens a file that holds particles by its name.
pub fn open(path: &Path) -> Result<Archive, ReadError> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("npz") => Archive::open(path),
        Some("ply") => Err(ReadError::file(path, "PLY files cannot be read yet", FILE)),
        Some("csv") => Err(ReadError::file(path, "CSV files cannot be read yet", FILE)),
        _ => Err(ReadError::file(path, "not a file of particles by its name", FILE)),
    }
}

fn row_error(path: &Path, name: &str, row: usize, why: String, expected: &str) -> ReadError {
    ReadError::at(path, format!("array `{name}`, row {row}"), why, expected)
}

/// The values of an array whose header has been read.
fn values<T: Number>(archive: &mut Archive, name: &str, limit: u64) -> Result<Vec<T>, ReadError> {
    Ok(archive.read(name, limit)?.map(|array: Array<T>| array.values).unwrap_or_default())
}

/// How many particles there are, from the headers; those of all arrays fit.
pub fn count(archive: &mut Archive) -> Result<u64, ReadError> {
    let shape = archive.shape("position", 2, Kind::Any, POSITIONS)?;
    let shape = shape.ok_or_else(|| archive.missing("position", POSITIONS))?;
    let [count, 3] = shape[..] else {
        return Err(archive.wrong_shape("position", &shape, POSITIONS));
    };
    if count > MAX_PARTICLES {
        let why = format!("of shape {shape:?} is too large");
        return Err(archive.fault("position", why, format!("{MAX_PARTICLES} particles at most")));
    }
    match archive.shape("temperature", 1, Kind::Any, TEMPERATURES)? {
        None => return Err(archive.missing("temperature", TEMPERATURES)),
        Some(shape) if shape != [count] => return Err(archive.wrong_shape("temperature", &shape, TEMPERATURES)),
        Some(_) => {}
    }
    match archive.shape("velocity", 2, Kind::Any, VELOCITIES)? {
        Some(shape) if shape != [count, 3] => return Err(archive.wrong_shape("velocity", &shape, VELOCITIES)),
        _ => {}
    }
    match archive.shape("id", 1, Kind::Whole, IDS)? {
        Some(shape) if shape != [count] => Err(archive.wrong_shape("id", &shape, IDS)),
        _ => Ok(count),
    }
}

fn temperature(archive: &mut Archive, path: &Path, count: u64) -> Result<Vec<f32>, ReadError> {
    let temperature: Vec<f32> = values(archive, "temperature", count)?;
    match temperature.iter().position(|t| !(*t > 0.0 && *t <= HOTTEST)) {
        Some(row) => {
            let why = format!("is {} as f32", temperature[row]);
            Err(row_error(path, "temperature", row, why, "kelvin, above 0 and finite, at most 1e6"))
        }
        None => Ok(temperature),
    }
}

fn ids(archive: &mut Archive, path: &Path, count: u64) -> Result<Option<Vec<u32>>, ReadError> {
    // Every integer up to 2^53 is exact as f64, and none above it becomes one that is allowed.
    let Some(Array { values, .. }) = archive.read::<f64>("id", count)? else { return Ok(None) };
    match values.iter().position(|id| !(0.0..=f64::from(u32::MAX)).contains(id)) {
        Some(row) => Err(row_error(path, "id", row, format!("is {}", values[row]), "0 to 4294967295")),
        None => Ok(Some(values.into_iter().map(|id| id as u32).collect())),
    }
}

fn velocities(archive: &mut Archive, path: &Path, count: u64) -> Result<Option<Vec<[f32; 3]>>, ReadError> {
    let Some(Array { values, .. }) = archive.read::<f32>("velocity", 3 * count)? else { return Ok(None) };
    let rows: Vec<[f32; 3]> = values.as_chunks().0.to_vec();
    match rows.iter().position(|v| !v.iter().all(|x| x.abs() <= FARTHEST)) {
        Some(row) => {
            let (why, expected) = (format!("is {:?} as f32", rows[row]), "three finite numbers, none beyond 1e12 m/s");
            Err(row_error(path, "velocity", row, why, expected))
        }
        None => Ok(Some(rows)),
    }
}

impl ParticleExtent {
    /// An error if the particles that were read from `path` are not within the extent: then the file is no longer the one
    /// that was looked at.
    pub fn check(&self, particles: &Particles, path: &Path) -> Result<(), ReadError> {
        let count = particles.position.len();
        if count > self.most as usize {
            let expected = format!("at most {}, as when the rendering began", self.most);
            return Err(ReadError::at(path, "array `position`", format!("has grown to {count} rows"), expected));
        }
        match particles.temperature.iter().position(|temperature| *temperature > self.hottest) {
            None => Ok(()),
            Some(row) => {
                let why = format!("is {}", particles.temperature[row]);
                let expected = format!("at most {}, as when the rendering began", self.hottest);
                Err(row_error(path, "temperature", row, why, &expected))
            }
        }
    }
}

impl Input for Particles {
    type Builtin = flame::Builtin;
    type Options = ();
    const ONE: &str = "particles";

    fn builtin(name: &str) -> Result<flame::Builtin, String> {
        match (flame::Builtin::named(name), name) {
            (Some(which), _) => Ok(which),
            (None, "sph") => Err("this simulation is not built yet; there is builtin:random".to_owned()),
            (None, _) => Err("no such particles; there is builtin:random".to_owned()),
        }
    }

    fn make(which: flame::Builtin, frame: u32, fps: f64) -> Particles {
        which.particles(frame, fps)
    }

    fn read(path: &Path, (): &()) -> Result<Particles, ReadError> {
        read(path)
    }
}

/// The particles of a shot: `builtin:random` or files.
pub type ParticleSequence = Sequence<Particles>;

impl ParticleSequence {
    /// The extent of these frames' particles, from the headers and temperatures of all files, so that a missing or unfit
    /// one is found before work begins.
    pub fn extent(&self, frames: impl IntoIterator<Item = u32>) -> Result<ParticleExtent, ReadError> {
        let mut extent = ParticleExtent { most: 0, hottest: 1.0 };
        for source in self.sources(frames) {
            let path = match source? {
                Source::File(path) => path,
                Source::Builtin { which, .. } => return Ok(which.extent()),
            };
            let mut archive = open(&path)?;
            let count = count(&mut archive)?;
            extent.hottest = temperature(&mut archive, &path, count)?.into_iter().fold(extent.hottest, f32::max);
            // No more than MAX_PARTICLES.
            extent.most = extent.most.max(count as u32);
        }
        Ok(extent)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Arc;

    use super::super::array::tests::{npy, write_archive};
    use super::super::tests::Folder;
    use super::*;

    fn f32s(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// Arrays of two valid particles.
    fn arrays() -> Vec<(&'static str, Vec<u8>)> {
        vec![
            ("position", npy("'<f4'", false, "(2, 3)", &f32s(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]))),
            ("temperature", npy("'<f4'", false, "(2,)", &f32s(&[900.0, 3000.0]))),
            ("id", npy("'<u4'", false, "(2,)", &[7, 0, 0, 0, 255, 255, 255, 255])),
        ]
    }

    fn read_arrays(arrays: &[(&str, Vec<u8>)]) -> Result<Particles, ReadError> {
        let folder = Folder::new();
        let path = folder.0.join("p.npz");
        write_archive(&path, arrays);
        read(&path)
    }

    /// The arrays with one replaced, or left out.
    fn with(name: &'static str, bytes: Option<Vec<u8>>) -> Result<Particles, ReadError> {
        let mut arrays = arrays();
        arrays.retain(|(n, _)| *n != name);
        arrays.extend(bytes.map(|b| (name, b)));
        read_arrays(&arrays)
    }

    /// Writes so many particles, the last of that temperature.
    fn write(path: &Path, count: usize, last: f32) {
        let mut temperature = vec![1000.0; count];
        temperature.iter_mut().last().into_iter().for_each(|t| *t = last);
        let positions = npy("'<f4'", false, &format!("({count}, 3)"), &f32s(&vec![0.5; 3 * count]));
        let temperatures = npy("'<f4'", false, &format!("({count},)"), &f32s(&temperature));
        write_archive(path, &[("position", positions), ("temperature", temperatures)]);
    }

    #[test]
    fn particles_are_read_whatever_their_types() {
        let expected = Particles {
            position: vec![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]],
            temperature: vec![900.0, 3000.0],
            id: Some(vec![7, u32::MAX]),
            velocity: None,
        };
        assert_eq!(read_arrays(&arrays()).unwrap(), expected);
        assert_eq!(with("id", None).unwrap(), Particles { id: None, ..expected.clone() });
        let velocities = npy("'<f4'", false, "(2, 3)", &f32s(&[0.5, 0.0, -1.0, 2.0, 0.0, 3.0]));
        let velocity = Some(vec![[0.5, 0.0, -1.0], [2.0, 0.0, 3.0]]);
        assert_eq!(with("velocity", Some(velocities)).unwrap(), Particles { velocity, ..expected.clone() });
        for (shape, values) in [("(3, 2)", [0.0; 6]), ("(2, 3)", [0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0])] {
            let message = with("velocity", Some(npy("'<f4'", false, shape, &f32s(&values)))).unwrap_err().to_string();
            assert!(message.contains("velocity"), "{message}");
        }
        // Fortran order: the coordinates of one axis are together.
        let doubles: Vec<u8> = [0.0f64, 3.0, 1.0, 4.0, 2.0, 5.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(with("position", Some(npy("'<f8'", true, "(2, 3)", &doubles))).unwrap(), expected);
        let halves: Vec<u8> = [0x6308u16, 0x69dc].iter().flat_map(|v| v.to_be_bytes()).collect();
        assert_eq!(with("temperature", Some(npy("'>f2'", false, "(2,)", &halves))).unwrap(), expected);
        let wide: Vec<u8> = [7i64, 4_294_967_295].iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(with("id", Some(npy("'<i8'", false, "(2,)", &wide))).unwrap(), expected);
        let bytes = with("id", Some(npy("'|u1'", false, "(2,)", &[3, 200]))).unwrap();
        assert_eq!(bytes.id, Some(vec![3, 200]));
        let kelvin = [900i32, 3000].map(i32::to_le_bytes).concat();
        assert_eq!(with("temperature", Some(npy("'<i4'", false, "(2,)", &kelvin))).unwrap(), expected);
        let column = with("temperature", Some(npy("'<i4'", true, "(2, 1)", &kelvin))).unwrap();
        assert_eq!(column, expected);
        let column = with("id", Some(npy("'<u4'", false, "(2, 1)", &[7, 0, 0, 0, 255, 255, 255, 255]))).unwrap();
        assert_eq!(column, expected);
        let whole = with("position", Some(npy("'|u1'", false, "(2, 3)", &[0, 1, 2, 3, 4, 5]))).unwrap();
        assert_eq!(whole, expected);
    }

    #[test]
    fn no_particles_are_particles() {
        let folder = Folder::new();
        let path = folder.0.join("p.npz");
        write(&path, 0, 0.0);
        assert_eq!(read(&path).unwrap(), Particles::default());
        let sequence = ParticleSequence::new("p.npz", &folder.0, (), false, 24.0).unwrap();
        assert_eq!(sequence.extent(1..=9).unwrap(), ParticleExtent { most: 0, hottest: 1.0 });
    }

    #[test]
    fn every_fault_names_its_array_and_row() {
        let says = |name: &'static str, bytes: Option<Vec<u8>>, words: &[&str]| {
            let error = with(name, bytes).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)) && error.contains("p.npz"), "{error}");
        };
        let floats = |shape: &str, values: &[f32]| Some(npy("'<f4'", false, shape, &f32s(values)));
        says("position", None, &["array `position`: is missing", "[n, 3]"]);
        says("position", floats("(6,)", &[0.0; 6]), &["array `position`: has shape [6]", "[n, 3]"]);
        says("position", floats("(3, 2)", &[0.0; 6]), &["array `position`: has shape [3, 2]", "[n, 3]"]);
        says("position", floats("(3, 3)", &[0.0; 9]), &["array `temperature`: has shape [2]"]);
        says("position", Some(npy("'<f4'", false, "(268435457, 3)", &[0; 24])), &["too large", "268435456 particles"]);
        says("position", Some(npy("'<f4'", false, "(2, 3)", &[0; 20])), &["`position`", "20 bytes", "24 bytes"]);
        says("temperature", None, &["array `temperature`: is missing", "kelvin"]);
        says("temperature", floats("(1, 2)", &[1.0; 2]), &["`temperature`: has shape [1, 2]"]);
        says("temperature", floats("(2, 2)", &[1.0; 4]), &["`temperature`: has shape [2, 2]"]);
        says("id", floats("(2,)", &[1.0; 2]), &["array `id`: elements are floats", "integers"]);
        says("id", Some(npy("'<u4'", false, "(3,)", &[0; 12])), &["array `id`: has shape [3]"]);
        for bad in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, 1.1e6] {
            let needle = format!("array `temperature`, row 1: is {bad} as f32");
            says(
                "temperature",
                floats("(2,)", &[900.0, bad]),
                &[&needle, "expected kelvin, above 0 and finite, at most 1e6"],
            );
        }
        let tiny: Vec<u8> = [1e-60f64, 1.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        says("temperature", Some(npy("'<f8'", false, "(2,)", &tiny)), &["row 0: is 0 as f32"]);
        for bad in [f32::NAN, f32::INFINITY, 1.1e12] {
            let position = floats("(2, 3)", &[0.0, 0.0, 0.0, 1.0, bad, 1.0]);
            says("position", position, &["array `position`, row 1: is [1.0, ", "three finite numbers"]);
        }
        let ids = |values: [i64; 2]| Some(npy("'<i8'", false, "(2,)", &values.map(i64::to_le_bytes).concat()));
        says("id", ids([0, -1]), &["array `id`, row 1: is -1", "0 to 4294967295"]);
        says("id", ids([1 << 32, 0]), &["array `id`, row 0: is 4294967296"]);
        says("id", Some(npy("'<u8'", false, "(2,)", &[255; 16])), &["array `id`, row 0: is 18446744073709552000"]);
    }

    #[test]
    fn files_that_are_no_particles_are_named() {
        let folder = Folder::new();
        for (name, needle) in [
            ("a.ply", "PLY files cannot be read yet"),
            ("a.CSV", "CSV files cannot be read yet"),
            ("a.txt", "not a file of particles"),
            ("a.npz", "no zip archive"),
        ] {
            fs::write(folder.0.join(name), "x").unwrap();
            let mut sequence = ParticleSequence::new(name, &folder.0, (), false, 24.0).unwrap();
            for error in [sequence.frame(1).unwrap_err(), sequence.extent(1..=2).unwrap_err()] {
                let error = error.to_string();
                assert!(error.contains(name) && error.contains(needle) && error.contains(".npz"), "{error}");
            }
        }
    }

    #[test]
    fn sequences_follow_their_files_and_know_their_extent() {
        let folder = Folder::new();
        for (frame, count, last) in [(1, 3, 1200.0), (2, 5, 800.0), (4, 2, 2500.0)] {
            write(&folder.0.join(format!("p.{frame:04}.npz")), count, last);
        }
        let open = |name: &str, hold| ParticleSequence::new(name, &folder.0, (), hold, 24.0).unwrap();
        let mut hold = open("p.####.npz", true);
        assert_eq!(hold.extent(1..=3).unwrap(), ParticleExtent { most: 5, hottest: 1200.0 });
        assert_eq!(hold.extent(1..=9).unwrap(), ParticleExtent { most: 5, hottest: 2500.0 });
        assert!(Arc::ptr_eq(&hold.frame(2).unwrap(), &hold.frame(3).unwrap()));
        let mut is_same = |f| Arc::ptr_eq(&hold.frame(f - 1).unwrap(), &hold.frame(f).unwrap());
        assert_eq!([2, 3, 4, 5].map(&mut is_same), [false, true, false, true]);
        let strict = open("p.%04d.npz", false);
        let error = strict.extent(1..=4).unwrap_err().to_string();
        assert!(error.contains("p.0003.npz: no such file; expected particles for frame 3"), "{error}");
        // One in the middle that cannot be used is found before the first frame.
        write(&folder.0.join("p.0003.npz"), 4, f32::NAN);
        let error = strict.extent(1..=4).unwrap_err().to_string();
        assert!(error.contains("p.0003.npz: array `temperature`, row 3: is NaN"), "{error}");
        let mut single = open("p.0001.npz", false);
        assert!(Arc::ptr_eq(&single.frame(1).unwrap(), &single.frame(7).unwrap()));
    }

    #[test]
    fn built_in_sequences() {
        let open = |name: &str| ParticleSequence::new(name, Path::new(""), (), false, 24.0);
        let mut random = open("builtin:random").unwrap();
        assert_eq!(*random.frame(7).unwrap(), flame::Builtin::Random.particles(7, 24.0));
        assert!(!Arc::ptr_eq(&random.frame(6).unwrap(), &random.frame(7).unwrap()));
        assert_eq!(random.extent(1..=1_000_000).unwrap(), flame::Builtin::Random.extent());
        let error = open("builtin:sph").unwrap_err().to_string();
        assert!(error.contains("builtin:sph: ") && error.contains("not built yet"), "{error}");
        let error = open("builtin:rand").unwrap_err().to_string();
        assert!(error.contains("builtin:rand: ") && error.contains("builtin:random"), "{error}");
    }
}
