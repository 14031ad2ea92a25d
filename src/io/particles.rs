//! Particles with a temperature: reading `.npz`, PLY and CSV, and sequences of them.

mod checked;
mod csv;
mod ply;
mod table;

use std::path::Path;

use self::checked::row_error;
use super::ReadError;
use super::array::{Archive, Array, Kind, Number};
use super::sequence::{Input, Sequence, Source};
use crate::data::{ParticleExtent, Particles};
use crate::simulate::flame;

/// Most particles of a file that is read: a small file can unpack to any size.
pub const MAX_PARTICLES: u64 = 1 << 28;

const POSITIONS: &str = "[n, 3] of numbers, in metres";
const TEMPERATURES: &str = "[n] of numbers, in kelvin, n as in `position`";
const IDS: &str = "[n] of integers, 0 to 4294967295, n as in `position`";
const VELOCITIES: &str = "[n, 3] of numbers, in m/s, n as in `position`";
const FILE: &str = "a name that ends in .npz, .ply or .csv";

/// A kind of file.
#[derive(Clone, Copy)]
enum Format {
    Npz,
    Ply,
    Csv,
}

impl Format {
    fn of(path: &Path) -> Result<Format, ReadError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("npz") => Ok(Format::Npz),
            Some("ply") => Ok(Format::Ply),
            Some("csv") => Ok(Format::Csv),
            _ => Err(ReadError::file(path, "not a file of particles by its name", FILE)),
        }
    }
}

/// Reads particles from a file, as its name ends. `.npz`: `position` (n x 3) in metres, `temperature` (n) in kelvin (both of
/// any float or integer type, which become f32) and optionally `id` (n integers, 0 to 4294967295) and `velocity` (n x 3) in
/// m/s. PLY and CSV: columns `x`, `y`, `z`, `temperature` and optionally `id` and `vx`, `vy`, `vz`, or as programs call them.
///
/// # Errors
/// More than [`MAX_PARTICLES`]; a position beyond 1e12 m, a temperature that is not above 0 and at most 1e6 K: with the row,
/// counted from 0; whatever is damaged, with its place.
pub fn read(path: &Path) -> Result<Particles, ReadError> {
    match Format::of(path)? {
        Format::Npz => read_npz(path),
        Format::Ply => ply::read(path),
        Format::Csv => csv::read(path),
    }
}

fn read_npz(path: &Path) -> Result<Particles, ReadError> {
    let mut archive = Archive::open(path)?;
    let count = count(&mut archive)?;
    let temperature = temperature(&mut archive, path, count)?;
    let position: Vec<f32> = values(&mut archive, "position", 3 * count)?;
    let position = position.as_chunks().0.to_vec();
    checked::positions(path, &position)?;
    let id = archive.read::<f64>("id", count)?.map(|Array { values, .. }| checked::ids(path, values)).transpose()?;
    let velocity: Option<Array<f32>> = archive.read("velocity", 3 * count)?;
    let velocity = velocity.map(|array| array.values.as_chunks().0.to_vec());
    velocity.iter().try_for_each(|values: &Vec<[f32; 3]>| checked::velocities(path, values))?;
    Ok(Particles { position, temperature, id, velocity })
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
    checked::temperatures(path, &temperature)?;
    Ok(temperature)
}

impl ParticleExtent {
    /// An error if the particles that were read from `path` are not within the extent: then the file is no longer the one
    /// that was looked at.
    pub fn check(&self, particles: &Particles, path: &Path) -> Result<(), ReadError> {
        let count = particles.position.len();
        if count > self.most as usize {
            let expected = format!("at most {}, as when the rendering began", self.most);
            return Err(ReadError::at(path, "`position`", format!("has grown to {count} rows"), expected));
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
            let temperatures = match Format::of(&path)? {
                Format::Npz => {
                    let mut archive = Archive::open(&path)?;
                    let count = count(&mut archive)?;
                    temperature(&mut archive, &path, count)?
                }
                Format::Ply | Format::Csv => read(&path)?.temperature,
            };
            // No more than MAX_PARTICLES.
            extent.most = extent.most.max(temperatures.len() as u32);
            extent.hottest = temperatures.into_iter().fold(extent.hottest, f32::max);
        }
        Ok(extent)
    }
}

#[cfg(test)]
mod tests;
