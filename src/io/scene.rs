//! Animated meshes: glTF 2.0 (`.glb`, `.gltf`), `.npz` caches of vertices, and those that the program makes itself.

mod budget;
mod cache;
mod choice;
mod colour;
mod data_uri;
mod document;
mod extensions;
mod gltf;
mod instances;
mod json;
mod meshopt;
mod reach;
mod references;
mod rig;
mod shares;
mod texels;
mod track;
mod weld;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

pub use self::choice::{Choice, NamedCamera, Pick};
pub use self::references::references;
pub use self::weld::{CREASE, Welder, shading_groups, weld};

use self::cache::Cache;
use self::rig::Rig;
use super::ReadError;
use super::pattern::{Pattern, PatternError};
use crate::data::Topology;
use crate::simulate::mesh::{Builtin, Model};
use crate::threads::map;
use crate::view::{Camera, FARTHEST};

/// Most vertices of a scene that is read.
pub const MAX_VERTICES: usize = 1 << 26;

/// A part of a file that was passed over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// A sentence.
    pub text: String,
    /// Whether it concerns the looks of the mesh alone, and nothing where frames are images.
    pub looks: bool,
}

impl Note {
    fn new(text: String) -> Note {
        Note { text, looks: false }
    }

    fn of_looks(text: String) -> Note {
        Note { text, looks: true }
    }
}

/// An animation of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// Its name; that of an unnamed one is its number, from 0.
    pub name: String,
    /// Time of its last key, from 0.
    pub seconds: f64,
}

/// When a frame is: `(frame - first) / fps` seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Frame at 0 seconds, and the first frame of a cache.
    pub first: u32,
    /// Frames per second, above 0.
    pub fps: f64,
}

impl Clock {
    /// Time of a frame, which may lie between two.
    pub fn seconds(self, frame: f64) -> f64 {
        (frame - f64::from(self.first)) / self.fps
    }
}

/// Where an animated mesh comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// The program makes it.
    Builtin(Builtin),
    /// A `.glb`, `.gltf` or `.npz` file.
    File(PathBuf),
}

/// The answer to a name with a place for the frame number.
const NO_SEQUENCE: &str = "animated meshes and cameras are no sequences of files: expected one glTF file, or one .npz file \
    with all frames";

impl Source {
    /// The source of that name: `builtin:NAME`, or a path relative to `folder` of one file for all frames.
    pub fn named(name: &str, folder: &Path) -> Result<Source, PatternError> {
        let Some(builtin) = name.strip_prefix("builtin:") else {
            let path = folder.join(name);
            let is_pattern = Pattern::parse(&path).map_or(true, |pattern| pattern.has_number());
            return match is_pattern && !path.exists() {
                true => Err(PatternError { path: name.into(), why: NO_SEQUENCE.to_owned() }),
                false => Ok(Source::File(path)),
            };
        };
        let why = || "no such animated mesh; there are builtin:run, builtin:spin and builtin:crossing".to_owned();
        let found = Builtin::named(builtin).ok_or_else(|| PatternError { path: name.into(), why: why() });
        found.map(Source::Builtin)
    }
}

#[derive(Clone, Debug)]
enum Motion {
    Rig(Rig),
    Cache(Cache),
    Model(Model),
}

/// Contents of a file beside its mesh, and which of them are used.
#[derive(Clone, Debug, Default)]
struct Contents {
    animations: Vec<Animation>,
    /// Numbers of the animations that are played.
    playing: Vec<usize>,
    cameras: Vec<NamedCamera>,
    /// Number of the camera that is looked through.
    camera: Option<usize>,
    notes: Vec<Note>,
}

/// A mesh whose vertices move. Poses are had on demand, of any frame in any order.
#[derive(Clone, Debug)]
pub struct AnimatedMesh {
    path: PathBuf,
    clock: Clock,
    topology: Topology,
    motion: Motion,
    contents: Contents,
}

impl AnimatedMesh {
    /// Reads or makes a mesh, which has triangles. `choice` is of what a glTF file has several of.
    pub fn open(source: &Source, choice: &Choice, clock: Clock) -> Result<AnimatedMesh, ReadError> {
        let mesh = AnimatedMesh::open_any(source, choice, clock)?;
        match mesh.topology.triangles.is_empty() {
            true => {
                let (why, expected) = ("has no triangles in its scene", "at least one mesh of triangles");
                Err(ReadError::at(&mesh.path, "meshes", why, expected))
            }
            false => Ok(mesh),
        }
    }

    /// As [`AnimatedMesh::open`], for its camera: a file may hold nothing else.
    pub fn open_any(source: &Source, choice: &Choice, clock: Clock) -> Result<AnimatedMesh, ReadError> {
        match source {
            Source::Builtin(which) => Ok(AnimatedMesh::builtin(*which, which.usual_vertices(), clock)),
            Source::File(path) => AnimatedMesh::read(path, choice, clock),
        }
    }

    /// One that the program makes, of about so many vertices.
    pub fn builtin(which: Builtin, vertices: u32, clock: Clock) -> AnimatedMesh {
        let (model, topology) = Model::new(which, vertices);
        let path = PathBuf::from(format!("builtin:{}", which.name()));
        AnimatedMesh { path, clock, topology, motion: Motion::Model(model), contents: Contents::default() }
    }

    /// Reads a file: glTF 2.0 (`.glb` or `.gltf`, with its buffers within or beside it), or an `.npz` cache:
    /// `position` [frames, vertices, 3] of floats, `triangle` [m, 3] of integers, and optionally `colour` [vertices, 3]
    /// (linear RGB) and `object` (an integer a vertex). `choice` as in [`AnimatedMesh::open`]; caches leave none. A glTF
    /// file may hold no triangles.
    pub fn read(path: &Path, choice: &Choice, clock: Clock) -> Result<AnimatedMesh, ReadError> {
        let path_kept = path.to_owned();
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("glb" | "gltf") => {
                let gltf::Scene { topology, rig, contents } = gltf::read(path, choice)?;
                Ok(AnimatedMesh { path: path_kept, clock, topology, motion: Motion::Rig(rig), contents })
            }
            Some("npz") if !choice.animations.is_empty() => {
                Err(ReadError::file(path, "a cache has no animations by name", "no key `animation`, or a glTF file"))
            }
            Some("npz") => {
                let (cache, topology) = cache::read(path)?;
                let contents = Contents::default();
                Ok(AnimatedMesh { path: path_kept, clock, topology, motion: Motion::Cache(cache), contents })
            }
            _ => Err(ReadError::file(
                path,
                "not an animated mesh by its name",
                "a name that ends in .glb, .gltf or .npz",
            )),
        }
    }

    /// How many vertices, triangles and objects an `.npz` cache holds, which is not kept in memory for that.
    pub fn count_of_cache(path: &Path) -> Result<[usize; 3], ReadError> {
        cache::count(path)
    }

    /// The constant part of the mesh.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.topology.object.len()
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's animations.
    pub fn animations(&self) -> &[Animation] {
        &self.contents.animations
    }

    /// Those that are played, the later ones over the earlier ones.
    pub fn playing(&self) -> impl Iterator<Item = &Animation> {
        self.contents.playing.iter().map(|number| &self.contents.animations[*number])
    }

    /// The cameras of a glTF file's scene.
    pub fn cameras(&self) -> &[NamedCamera] {
        &self.contents.cameras
    }

    /// The one of them that is looked through.
    pub fn camera_taken(&self) -> Option<&NamedCamera> {
        self.contents.camera.map(|number| &self.contents.cameras[number])
    }

    /// Parts of the file that were passed over.
    pub fn notes(&self) -> &[Note] {
        &self.contents.notes
    }

    /// How many frames a cache holds, from the clock's first on; none where poses are a function of time. Before the
    /// first and after the last the mesh stands still.
    pub fn frames(&self) -> Option<u32> {
        match &self.motion {
            Motion::Cache(cache) => Some(cache.frames()),
            _ => None,
        }
    }

    /// An error if a cache ends before the last of a shot's frames: it would stand still from there on.
    pub fn check_frames(&self, [first, last]: [u32; 2]) -> Result<(), ReadError> {
        let wanted = last.saturating_sub(first).saturating_add(1);
        match self.frames() {
            Some(frames) if frames < wanted => {
                let why = format!("has {frames} frames");
                let expected = format!("at least {wanted}, one for each of the shot's frames {first} to {last}");
                Err(ReadError::at(&self.path, "array `position`", why, expected))
            }
            _ => Ok(()),
        }
    }

    /// World positions of all vertices, in metres, at a frame of the clock, which may lie between two: exact, but for
    /// caches, which are linear between frames. `out` has [`AnimatedMesh::vertices`] rows.
    pub fn positions(&self, frame: f64, out: &mut [[f32; 3]]) {
        match &self.motion {
            Motion::Rig(rig) => rig.positions(self.clock.seconds(frame), out),
            Motion::Model(model) => model.positions(self.clock.seconds(frame), out),
            Motion::Cache(cache) => cache.positions(frame - f64::from(self.clock.first), out),
        }
    }

    /// World positions as [`AnimatedMesh::positions`]; an error that names vertex and frame where one is beyond
    /// [`FARTHEST`].
    pub fn pose(&self, frame: f64) -> Result<Vec<[f32; 3]>, ReadError> {
        let mut pose = vec![[0.0; 3]; self.vertices()];
        self.positions(frame, &mut pose);
        match pose.iter().position(|p| !p.iter().all(|x| x.abs() <= FARTHEST)) {
            None => Ok(pose),
            Some(row) => {
                let place = format!("vertex {row}, frame {frame}");
                Err(ReadError::at(
                    &self.path,
                    place,
                    format!("is at {:?}", pose[row]),
                    "three finite numbers, none beyond 1e12 m",
                ))
            }
        }
    }

    /// The poses of several frames, with at most so many threads.
    pub fn poses(&self, frames: &[f64], threads: usize) -> Result<Vec<Vec<[f32; 3]>>, ReadError> {
        let each = frames.len().div_ceil(threads.max(1)).max(1);
        let some = |frames: &[f64]| frames.iter().map(|&frame| self.pose(frame)).collect::<Result<Vec<_>, _>>();
        if each >= frames.len() {
            return some(frames);
        }
        let parts: Result<Vec<_>, _> = map(frames.chunks(each), some).into_iter().collect();
        Ok(parts?.into_iter().flatten().collect())
    }

    /// The scene's own camera at a frame: that of a glTF file (see [`Choice`]), or the natural one of what
    /// the program makes. It may be unfit ([`Camera::validate`]) where the file's is.
    pub fn camera(&self, frame: f64) -> Option<Camera> {
        match &self.motion {
            Motion::Rig(rig) => rig.camera(self.clock.seconds(frame)),
            Motion::Model(model) => Some(model.camera(self.clock.seconds(frame))),
            Motion::Cache(_) => None,
        }
    }

    /// Point of each vertex, numbered by first occurrence: vertices of one object are one point if nothing can move them
    /// apart. In a file of joints, nodes and morph targets, and in what the program makes, that follows from what moves them
    /// and from where they begin; in a cache from all of its frames. It does not depend on the frames that are shown.
    pub fn weld(&self) -> Vec<u32> {
        let mut welder = Welder::new(&self.topology.object);
        match &self.motion {
            Motion::Rig(rig) => rig.weld(&mut welder),
            Motion::Cache(cache) => cache.weld(&mut welder),
            Motion::Model(model) => {
                let rest = model.rest();
                welder.split(|vertex| (rest[vertex].0, weld::place(rest[vertex].1)));
            }
        }
        welder.finish()
    }
}
