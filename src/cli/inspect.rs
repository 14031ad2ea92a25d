//! `celfx inspect`: what a mesh, volume, particle or shot file holds.

mod grids;

use std::fmt::{self, Display};
use std::path::Path;

use clap::Args;
use serde::Serialize;

use super::{Failure, print};
use crate::data::Particles;
use crate::io::ReadError;
use crate::io::array::Archive;
use crate::io::particles;
use crate::io::scene::{AnimatedMesh, Choice, Clock};
use crate::io::shot;
use crate::program::{self, EFFECTS};

const EXAMPLES: &str = "\
Examples:
  celfx inspect walk.glb                    vertices, triangles, objects, and the animations by name
  celfx inspect --json plume.0001.npz       the grids of a volume, for scripts
  celfx inspect builtin:campfire            a shot: its size, frames and effects";

/// Options of `celfx inspect`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// A mesh (.glb, .gltf, .npz), a volume, particles or cameras (.npz), or a shot (.toml, builtin:NAME)
    #[arg(value_name = "FILE")]
    file: String,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let report = report(&options.file)?;
    let text = match options.json {
        true => serde_json::to_string_pretty(&report).map_err(|e| Failure::new(Failure::OUTPUT, e.to_string()))? + "\n",
        false => report.to_string(),
    };
    print(&text)
}

/// What parts of a mesh are called.
#[derive(Debug, Default, Serialize)]
struct Names {
    objects: Vec<String>,
    materials: Vec<String>,
}

/// The content of a file.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Report {
    Mesh {
        vertices: usize,
        triangles: usize,
        objects: usize,
        /// Their names, and those of materials.
        names: Names,
        animations: Vec<AnimationReport>,
        cameras: Vec<CameraReport>,
        notes: Vec<String>,
    },
    Volume {
        grids: Vec<GridReport>,
        notes: Vec<String>,
    },
    Particles {
        count: u64,
        bounds: Option<[[f32; 3]; 2]>,
        temperature: Option<Range>,
        not_finite: u64,
    },
    Cameras {
        cameras: usize,
    },
    Shot {
        size: [u32; 2],
        frames: [u32; 2],
        fps: f64,
        effects: Vec<&'static str>,
    },
}

#[derive(Debug, Serialize)]
struct AnimationReport {
    name: String,
    seconds: f64,
}

#[derive(Debug, Serialize)]
struct CameraReport {
    name: String,
    /// Whether the camera that `camera.name` may name is perspective.
    perspective: bool,
}

#[derive(Debug, Serialize)]
struct GridReport {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    dimensions: [u32; 3],
    voxel_size: [f32; 3],
    origin: [f32; 3],
    active: u64,
    /// Of what is finite; none if nothing is.
    min: Option<f32>,
    max: Option<f32>,
    sum: f64,
    /// How many values are NaN or infinite as f32.
    not_finite: u64,
}

#[derive(Debug, Serialize)]
struct Range {
    min: f32,
    max: f32,
}

/// Statistics of a stream of numbers. Those that are not finite are passed over, and counted.
#[derive(Debug, Default)]
struct Statistics {
    range: Option<Range>,
    sum: f64,
    not_finite: u64,
}

impl Statistics {
    /// A value that there is so often.
    fn add(&mut self, value: f32, times: u64) {
        if !value.is_finite() {
            self.not_finite += times;
            return;
        }
        let Range { min, max } = self.range.get_or_insert(Range { min: value, max: value });
        (*min, *max) = (min.min(value), max.max(value));
        self.sum += f64::from(value) * times as f64;
    }
}

fn report(file: &str) -> Result<Report, Failure> {
    let path = Path::new(file);
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        _ if file.starts_with("builtin:") => shot(file),
        Some("toml") => shot(file),
        Some("glb" | "gltf") => Ok(mesh(path)?),
        Some("npz") => Ok(archive(path)?),
        Some("ply" | "csv") => Ok(table(path)?),
        Some("vdb") => Ok(grids::vdb(path)?),
        _ => {
            let expected = "a name that ends in .glb, .gltf, .npz, .ply, .csv, .vdb or .toml";
            Err(ReadError::file(path, "not a known kind of file", expected).into())
        }
    }
}

/// The kind of an `.npz` file, from its arrays: that of which all are there, with as many axes as it needs; a volume
/// before a mesh, and these before particles and cameras, for they may hold more than they need. If none is whole, what
/// is named first says what is missing.
fn archive(path: &Path) -> Result<Report, ReadError> {
    let mut archive = Archive::open(path)?;
    // A header that cannot be read is told where its array is needed.
    let mut axes = |name: &str| archive.header(name).ok().flatten().map(|header| header.shape.len());
    let [density, voxels, triangle, temperature, cameras] =
        ["density", "voxel_size", "triangle", "temperature", "view_projection"].map(|name| axes(name).is_some());
    let position = axes("position");
    match () {
        () if density && voxels => grids::npz(path),
        () if triangle && position == Some(3) => cache(path),
        () if temperature && position == Some(2) => particles(path),
        () if cameras => self::cameras(path),
        () if density => grids::npz(path),
        () if triangle => cache(path),
        () if temperature => particles(path),
        () => {
            let expected = "`density` and `voxel_size` (a volume), `position` and `triangle` (a mesh), `position` and \
                `temperature` (particles) or `view_projection` (cameras)";
            Err(ReadError::file(path, format!("has the arrays {:?}", archive.names()), expected))
        }
    }
}

fn cameras(path: &Path) -> Result<Report, ReadError> {
    Ok(Report::Cameras { cameras: shot::count_cameras(path)? })
}

fn cache(path: &Path) -> Result<Report, ReadError> {
    let [vertices, triangles, objects] = AnimatedMesh::count_of_cache(path)?;
    let (animations, cameras, notes) = (Vec::new(), Vec::new(), Vec::new());
    Ok(Report::Mesh { vertices, triangles, objects, names: Names::default(), animations, cameras, notes })
}

fn names(mesh: &AnimatedMesh) -> Names {
    let named = |names: &[String]| names.iter().filter(|name| !name.is_empty()).cloned().collect();
    Names { objects: named(&mesh.topology().objects), materials: named(&mesh.topology().materials) }
}

fn mesh(path: &Path) -> Result<Report, ReadError> {
    // What is reported does not depend on the time.
    let mesh = AnimatedMesh::read(path, &Choice::default(), Clock { first: 0, fps: 1.0 })?;
    let (animations, cameras) = (mesh.animations().iter(), mesh.cameras().iter());
    Ok(Report::Mesh {
        vertices: mesh.vertices(),
        triangles: mesh.topology().triangles.len(),
        objects: mesh.topology().objects.len(),
        names: names(&mesh),
        animations: animations.map(|a| AnimationReport { name: a.name.clone(), seconds: a.seconds }).collect(),
        cameras: cameras.map(|c| CameraReport { name: c.name.clone(), perspective: c.is_perspective }).collect(),
        notes: mesh.notes().iter().map(|note| note.text.clone()).collect(),
    })
}

/// Of text and PLY only what is right is reported.
fn table(path: &Path) -> Result<Report, ReadError> {
    let Particles { position, temperature, .. } = particles::read(path)?;
    let mut axes = [const { Statistics { range: None, sum: 0.0, not_finite: 0 } }; 3];
    for place in &position {
        axes.iter_mut().zip(place).for_each(|(axis, value)| axis.add(*value, 1));
    }
    let mut all = Statistics::default();
    temperature.iter().for_each(|value| all.add(*value, 1));
    Ok(Report::Particles { count: position.len() as u64, bounds: bounds(axes), temperature: all.range, not_finite: 0 })
}

fn bounds(axes: [Statistics; 3]) -> Option<[[f32; 3]; 2]> {
    match axes.map(|axis| axis.range) {
        [Some(x), Some(y), Some(z)] => Some([[x.min, y.min, z.min], [x.max, y.max, z.max]]),
        _ => None,
    }
}

fn particles(path: &Path) -> Result<Report, ReadError> {
    let mut archive = Archive::open(path)?;
    let count = particles::count(&mut archive)?;
    let (mut axes, mut at) = ([const { Statistics { range: None, sum: 0.0, not_finite: 0 } }; 3], 0);
    let is_fortran = archive.header("position")?.is_some_and(|header| header.fortran_order);
    archive.each("position", |value: f32| {
        let axis = if is_fortran { at / count.max(1) } else { at % 3 };
        axes[axis as usize % 3].add(value, 1);
        at += 1;
    })?;
    let mut temperature = Statistics::default();
    archive.each("temperature", |value| temperature.add(value, 1))?;
    let not_finite = axes.iter().chain([&temperature]).map(|of| of.not_finite).sum();
    Ok(Report::Particles { count, bounds: bounds(axes), temperature: temperature.range, not_finite })
}

fn shot(name: &str) -> Result<Report, Failure> {
    let shot = program::load(name, &[])?;
    let effects = EFFECTS.iter().map(|effect| effect.name()).filter(|name| shot.has(name)).collect();
    Ok(Report::Shot { size: shot.size, frames: shot.frames, fps: shot.fps, effects })
}

/// Most names of a kind that are written out.
const MOST_NAMES: usize = 24;

fn listed(f: &mut fmt::Formatter, kind: &str, names: &[String]) -> fmt::Result {
    names.iter().take(MOST_NAMES).try_for_each(|name| writeln!(f, "{kind} `{name}`"))?;
    match names.len().checked_sub(MOST_NAMES).filter(|more| *more > 0) {
        Some(more) => writeln!(f, "and {more} more {kind}s"),
        None => Ok(()),
    }
}

fn not_finite(count: u64) -> String {
    if count > 0 { format!(", {count} values not finite") } else { String::new() }
}

impl Display for GridReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let GridReport { name, kind, dimensions: [x, y, z], voxel_size, origin, active, sum, .. } = self;
        writeln!(f, "grid `{name}`: {kind}, {x} x {y} x {z} voxels of {voxel_size:?} m from {origin:?}")?;
        write!(f, "  {active} active")?;
        self.min.zip(self.max).iter().try_for_each(|(min, max)| write!(f, ", {min} to {max}, sum {sum}"))?;
        writeln!(f, "{}", not_finite(self.not_finite))
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Report::Mesh { vertices, triangles, objects, names, animations, cameras, notes } => {
                writeln!(f, "mesh: {vertices} vertices, {triangles} triangles, {objects} objects")?;
                listed(f, "object", &names.objects)?;
                listed(f, "material", &names.materials)?;
                animations.iter().try_for_each(|a| writeln!(f, "animation `{}`: {} s", a.name, a.seconds))?;
                cameras.iter().try_for_each(|c| {
                    let kind = if c.perspective { "perspective" } else { "orthographic" };
                    writeln!(f, "camera `{}`: {kind}", c.name)
                })?;
                notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))
            }
            Report::Volume { grids, notes } => {
                grids.iter().try_for_each(|grid| write!(f, "{grid}"))?;
                notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))
            }
            Report::Particles { count, bounds, temperature, not_finite: odd } => {
                writeln!(f, "particles: {count}{}", not_finite(*odd))?;
                bounds.iter().try_for_each(|[low, high]| writeln!(f, "bounds: {low:?} to {high:?} m"))?;
                temperature.iter().try_for_each(|t| writeln!(f, "temperature: {} to {} K", t.min, t.max))
            }
            Report::Cameras { cameras } => writeln!(f, "cameras: {cameras}, one a frame"),
            Report::Shot { size: [width, height], frames: [first, last], fps, effects } => {
                let effects = effects.join(", ");
                writeln!(f, "shot: {width} x {height}, frames {first} to {last}, {fps} fps, effects: {effects}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::array::tests::{npy, write_archive};
    use crate::io::tests::Folder;

    fn floats(shape: &str, values: &[f32]) -> Vec<u8> {
        npy("'<f4'", false, shape, &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
    }

    /// The report on a file of these arrays.
    fn inspected(arrays: &[(&str, Vec<u8>)]) -> serde_json::Value {
        let folder = Folder::new();
        let path = folder.0.join("a.npz");
        write_archive(&path, arrays);
        let report = report(path.to_str().expect("UTF-8")).expect("a known kind of file");
        assert!(!report.to_string().is_empty());
        serde_json::to_value(report).expect("JSON")
    }

    fn volume(density: &[f32]) -> Vec<(&'static str, Vec<u8>)> {
        vec![("density", floats("(1, 2, 2)", density)), ("voxel_size", floats("()", &[0.5]))]
    }

    fn mesh() -> Vec<(&'static str, Vec<u8>)> {
        vec![("position", floats("(2, 3, 3)", &[0.0; 18])), ("triangle", npy("'|u1'", false, "(1, 3)", &[0, 1, 2]))]
    }

    fn particles(temperature: &[f32]) -> Vec<(&'static str, Vec<u8>)> {
        vec![
            ("position", floats("(2, 3)", &[0.0, 1.0, 2.0, 3.0, 4.0, -5.0])),
            ("temperature", floats("(2,)", temperature)),
        ]
    }

    /// Each kind of file holds all arrays that tell another one.
    #[test]
    fn a_file_is_what_all_of_its_arrays_say() {
        let other = |name, shape: &str, count: usize| (name, floats(shape, &vec![1.0; count]));
        let mut smoke = volume(&[1.0; 4]);
        smoke.extend([other("temperature", "(1, 2, 2)", 4), other("triangle", "(1, 3)", 3), other("other", "(3,)", 3)]);
        smoke.extend([other("position", "(2, 3)", 6), other("view_projection", "(1, 4, 4)", 16)]);
        let grids = inspected(&smoke)["grids"].as_array().expect("grids").clone();
        let names: Vec<_> = grids.iter().map(|grid| grid["name"].as_str().expect("a name")).collect();
        assert_eq!(names, ["density", "temperature"]);
        let mut run = mesh();
        run.extend([other("density", "(3,)", 3), other("temperature", "(3,)", 3), other("view_projection", "(1,)", 1)]);
        assert_eq!(inspected(&run)["triangles"], 1);
        let mut fire = particles(&[900.0, 1000.0]);
        fire.extend([other("triangle", "(1, 3)", 3), other("density", "(2,)", 2), other("view_projection", "(1,)", 1)]);
        assert_eq!(inspected(&fire)["count"], 2);
        let pinhole = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0, 0.0];
        let mut cameras = vec![("view_projection", floats("(2, 4, 4)", &pinhole.repeat(2)))];
        cameras.push(other("position", "(2, 3)", 6));
        assert_eq!(inspected(&cameras)["cameras"], 2);
    }

    #[test]
    fn what_is_missing_is_told_of_what_a_file_would_be() {
        let folder = Folder::new();
        let path = folder.0.join("a.npz");
        for (arrays, needle) in [
            (&volume(&[1.0; 4])[..1], "`voxel_size`: is missing"),
            (&mesh()[1..], "`position`: is missing"),
            (&particles(&[1.0; 2])[1..], "`position`: is missing"),
            (&mesh()[..1], "`density` and `voxel_size` (a volume)"),
            (&[("view_projection", floats("(4, 4)", &[0.0; 16]))], "`view_projection`: has shape [4, 4]"),
        ] {
            write_archive(&path, arrays);
            let failure = report(path.to_str().expect("UTF-8")).expect_err("incomplete");
            assert!(failure.code == Failure::INPUT && failure.message.contains(needle), "{}", failure.message);
        }
    }

    #[test]
    fn what_is_not_finite_is_counted_and_passed_over() {
        let grid = &inspected(&volume(&[f32::NAN, 1.0, -0.5, f32::INFINITY]))["grids"][0];
        assert_eq!([&grid["min"], &grid["max"], &grid["sum"]], [-0.5, 1.0, 0.5]);
        assert_eq!([&grid["not_finite"], &grid["active"]], [2, 4]);
        assert_eq!(inspected(&volume(&[f32::NAN; 4]))["grids"][0]["not_finite"], 4);
        let fire = inspected(&particles(&[f32::NAN, 900.0]));
        assert_eq!(fire["temperature"], serde_json::json!({"min": 900.0, "max": 900.0}));
        assert_eq!((&fire["not_finite"], &fire["count"]), (&1.into(), &2.into()));
        assert_eq!(fire["bounds"], serde_json::json!([[0.0, 1.0, -5.0], [3.0, 4.0, 2.0]]));
    }
}
