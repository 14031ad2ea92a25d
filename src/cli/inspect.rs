//! `celfx inspect`: what a mesh, volume, particle or shot file holds.

use std::fmt::{self, Display};
use std::path::Path;

use clap::Args;
use serde::Serialize;

use super::{Failure, print};
use crate::io::ReadError;
use crate::io::array::{Archive, Element};
use crate::io::particles;
use crate::io::scene::{AnimatedMesh, Choice, Clock};
use crate::io::shot::Shot;
use crate::io::volume::{self, Grids};

const EXAMPLES: &str = "\
Examples:
  celfx inspect walk.glb                    vertices, triangles, objects, and the animations by name
  celfx inspect --json plume.0001.npz       the grids of a volume, for scripts
  celfx inspect builtin:campfire            a shot: its size, frames and effects";

/// Options of `celfx inspect`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// A mesh (.glb, .gltf, .npz), a volume (.npz), particles (.npz), or a shot (.toml, builtin:NAME)
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

/// What a file holds.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Report {
    Mesh {
        vertices: usize,
        triangles: usize,
        objects: usize,
        animations: Vec<AnimationReport>,
        cameras: Vec<CameraReport>,
        notes: Vec<String>,
    },
    Volume {
        grids: Vec<GridReport>,
    },
    Particles {
        count: usize,
        bounds: Option<[[f32; 3]; 2]>,
        temperature: Option<Range>,
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
    /// What `camera.name` may name is perspective.
    perspective: bool,
}

#[derive(Debug, Serialize)]
struct GridReport {
    name: &'static str,
    #[serde(rename = "type")]
    kind: &'static str,
    dimensions: [u32; 3],
    voxel_size: [f32; 3],
    origin: [f32; 3],
    active: usize,
    min: f32,
    max: f32,
    sum: f64,
}

#[derive(Debug, Serialize)]
struct Range {
    min: f32,
    max: f32,
}

impl Range {
    /// NaN is passed over; none where there is nothing.
    fn of(values: &[f32]) -> Option<Range> {
        let min = values.iter().copied().reduce(f32::min)?;
        let max = values.iter().copied().reduce(f32::max)?;
        Some(Range { min, max })
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
        Some("ply" | "csv") => Ok(particles(path)?),
        Some("vdb") => Ok(volume(path)?),
        _ => {
            let expected = "a name that ends in .glb, .gltf, .npz, .ply, .csv, .vdb or .toml";
            Err(ReadError::file(path, "not a known kind of file", expected).into())
        }
    }
}

/// What an `.npz` file is, its arrays tell.
fn archive(path: &Path) -> Result<Report, ReadError> {
    let names = Archive::open(path)?.names();
    let has = |name: &str| names.iter().any(|n| n == name);
    match () {
        () if has("triangle") => mesh(path),
        () if has("temperature") => particles(path),
        () if has("density") => volume(path),
        () => {
            let expected = "`triangle` (a mesh), `temperature` (particles) or `density` (a volume)";
            Err(ReadError::file(path, format!("has the arrays {names:?}"), expected))
        }
    }
}

fn mesh(path: &Path) -> Result<Report, ReadError> {
    // What is reported does not depend on the time.
    let mesh = AnimatedMesh::read(path, &Choice::default(), Clock { first: 0, fps: 1.0 })?;
    let (animations, cameras) = (mesh.animations().iter(), mesh.cameras().iter());
    Ok(Report::Mesh {
        vertices: mesh.vertices(),
        triangles: mesh.topology().triangles.len(),
        objects: mesh.topology().objects.len(),
        animations: animations.map(|a| AnimationReport { name: a.name.clone(), seconds: a.seconds }).collect(),
        cameras: cameras.map(|c| CameraReport { name: c.name.clone(), perspective: c.is_perspective }).collect(),
        notes: mesh.notes().iter().map(|note| note.text.clone()).collect(),
    })
}

fn volume(path: &Path) -> Result<Report, ReadError> {
    let volume = volume::read(path, &Grids::default())?;
    let mut archive = Archive::open(path)?;
    let mut grid = |name: &'static str, kinds: [&'static str; 3], values: &[f32], active: usize| {
        let kind = match archive.header(name)?.map(|header| header.element) {
            Some(Element::F16) => kinds[0],
            Some(Element::F64) => kinds[2],
            _ => kinds[1],
        };
        let Range { min, max } = Range::of(values).unwrap_or(Range { min: 0.0, max: 0.0 });
        let sum = values.iter().map(|&x| f64::from(x)).sum();
        let volume::Volume { dimensions, voxel_size, origin, .. } = volume;
        Ok(GridReport { name, kind, dimensions, voxel_size, origin, active, min, max, sum })
    };
    let active = volume.density.len();
    let mut grids = vec![grid("density", ["half", "float", "double"], &volume.density, active)?];
    if let Some(velocity) = &volume.velocity {
        grids.push(grid("velocity", ["vec3h", "vec3f", "vec3d"], velocity.as_flattened(), active)?);
    }
    Ok(Report::Volume { grids })
}

fn particles(path: &Path) -> Result<Report, ReadError> {
    let particles = particles::read(path)?;
    let corner = |pick: fn(f32, f32) -> f32| {
        particles.position.iter().copied().reduce(|a, b| std::array::from_fn(|i| pick(a[i], b[i])))
    };
    let bounds = corner(f32::min).zip(corner(f32::max)).map(|(low, high)| [low, high]);
    Ok(Report::Particles { count: particles.position.len(), bounds, temperature: Range::of(&particles.temperature) })
}

fn shot(name: &str) -> Result<Report, Failure> {
    let shot = Shot::load(name, &[])?;
    let effects = [("smoke", shot.smoke.is_some()), ("flame", shot.flame.is_some()), ("blur", shot.blur.is_some())];
    let effects = effects.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect();
    Ok(Report::Shot { size: shot.size, frames: shot.frames, fps: shot.fps, effects })
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Report::Mesh { vertices, triangles, objects, animations, cameras, notes } => {
                writeln!(f, "mesh: {vertices} vertices, {triangles} triangles, {objects} objects")?;
                animations.iter().try_for_each(|a| writeln!(f, "animation `{}`: {} s", a.name, a.seconds))?;
                cameras.iter().try_for_each(|c| {
                    let kind = if c.perspective { "perspective" } else { "orthographic, cannot be looked through" };
                    writeln!(f, "camera `{}`: {kind}", c.name)
                })?;
                notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))
            }
            Report::Volume { grids } => grids.iter().try_for_each(|grid| {
                let GridReport { name, kind, dimensions: [x, y, z], voxel_size, origin, active, min, max, sum } = grid;
                writeln!(f, "grid `{name}`: {kind}, {x} x {y} x {z} voxels of {voxel_size:?} m from {origin:?}")?;
                writeln!(f, "  {active} active, {min} to {max}, sum {sum}")
            }),
            Report::Particles { count, bounds, temperature } => {
                writeln!(f, "particles: {count}")?;
                bounds.iter().try_for_each(|[low, high]| writeln!(f, "bounds: {low:?} to {high:?} m"))?;
                temperature.iter().try_for_each(|t| writeln!(f, "temperature: {} to {} K", t.min, t.max))
            }
            Report::Shot { size: [width, height], frames: [first, last], fps, effects } => {
                let effects = effects.join(", ");
                writeln!(f, "shot: {width} x {height}, frames {first} to {last}, {fps} fps, effects: {effects}")
            }
        }
    }
}
