//! Shots: TOML files that say what is rendered, seen from where and lit how.
//!
//! ```toml
//! size = [512, 512]
//! frames = [1, 48]
//! [camera]
//! eye = [[1, [0, 1, 4]], [48, [2, 1, 4]]]   # keyframes: linear between, constant outside
//! [smoke]
//! volume = "plume.####.npz"                 # relative to the shot's file
//! [flame]
//! particles = "fire.####.npz"
//! [blur]
//! scene = "walk.glb"
//! images = "frames/####.png"
//! ```
//!
//! `celfx shot builtin:campfire` and `celfx shot builtin:blur` print every key.

mod camera;
mod exposure;
mod files;
mod keys;
mod print;
mod read;
pub(crate) mod texture;
mod track;
mod tree;

use std::any::Any;
use std::fmt::Debug;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::display::{Display, Output};
use super::overlap::Files;
use super::pattern::PatternError;
use super::scene::AnimatedMesh;
use super::{ReadError, file};
use crate::error::Error;
use crate::settings::Dial;
use crate::view::{Camera, Light, LightSource, SecondLight};
use camera::CameraTrack;
pub use camera::count_cameras;
pub use exposure::Exposure;
pub use files::FileKey;
use keys::Keys;
use track::Track;
pub(crate) use tree::Tree;

/// The shots inside the program: name, and text without the comments at settings, which [`builtin_text`] adds.
pub const BUILTIN: &[(&str, &str)] = &[
    ("builtin:smoke", include_str!("shot/smoke.toml")),
    ("builtin:cloud", include_str!("shot/cloud.toml")),
    ("builtin:paper_smoke", include_str!("shot/paper_smoke.toml")),
    ("builtin:flame", include_str!("shot/flame.toml")),
    ("builtin:paper_flame", include_str!("shot/paper_flame.toml")),
    ("builtin:paper_blur", include_str!("shot/paper_blur.toml")),
    ("builtin:campfire", include_str!("shot/campfire.toml")),
    ("builtin:blur", include_str!("shot/blur.toml")),
];

/// The background of the effects.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// Linear RGB, each finite and >= 0.
    Colour([f32; 3]),
    /// An image file.
    Image(PathBuf),
    /// Nothing: pictures keep their alpha.
    None,
}

/// A shot's settings of an effect.
pub trait Part: Any + Debug + Send + Sync {
    /// Checks it with the rest of the shot, of which it may be the only effect.
    ///
    /// # Errors
    /// A key, its value and what is allowed.
    fn check(&self, _is_alone: bool) -> Result<(), String> {
        Ok(())
    }
}

/// The table of an effect in shots.
#[derive(Debug)]
pub struct Table {
    /// Its name.
    pub name: &'static str,
    /// Keys of its input, with its name and a dot before them, each with what is allowed.
    pub inputs: &'static [(&'static str, &'static str)],
    /// Keys of its settings.
    pub dials: fn() -> Vec<Dial>,
    /// Keys that take the name of a file.
    pub files: &'static [FileKey],
    /// Pairs of keys that exclude each other: naming one on the command line takes the place of the file's other.
    pub excluding: &'static [[&'static str; 2]],
    /// Reads it.
    pub read: fn(&Section) -> Result<Arc<dyn Part>, ShotError>,
}

/// A shot, as far as the tables of its effects need it.
#[derive(Debug)]
pub struct Section<'a> {
    pub(crate) tree: &'a Tree,
    /// The folder that relative paths start from.
    pub(crate) folder: &'a Path,
    /// First and last frame.
    pub(crate) frames: [u32; 2],
    /// Frames per second.
    pub(crate) fps: f64,
}

impl Section<'_> {
    /// How long drawings of an effect last: as its key `on` says, or that of the shot.
    pub(crate) fn exposure(&self, key: &str) -> Result<Exposure, ShotError> {
        let on = self.tree.exposure("on", 1)?;
        Ok(Exposure::new(self.frames[0], self.tree.exposure(key, on)?))
    }
}

/// What names of OCIO configs that are built in begin with.
const OCIO: &str = "ocio://";
/// Strength of a second light where the shot does not say it.
const SECOND_STRENGTH: f64 = 0.3;

#[derive(Clone, Debug, PartialEq)]
enum LightTrack {
    Direction(Track<DVec3>),
    Position(Track<DVec3>),
}

/// A shot, checked: whatever [`Shot::load`] returns can be rendered as far as its own values go.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Where it came from, for messages: a path or `builtin:NAME`.
    pub name: String,
    /// The folder that relative paths in it start from.
    pub folder: PathBuf,
    /// Width and height in pixels, 1 to 16384 each.
    pub size: [u32; 2],
    /// First and last frame, both rendered.
    pub frames: [u32; 2],
    /// Frames per second, 0.001 to 1,000,000.
    pub fps: f64,
    /// Seed of everything random.
    pub seed: u32,
    /// The background of the effects.
    pub background: Background,
    /// How pictures that people look at are coded.
    pub output: Output,
    /// Its settings of effects, by their names; at least of one.
    parts: Vec<(&'static str, Arc<dyn Part>)>,
    camera: CameraTrack,
    light: LightTrack,
    ambient: Track<f64>,
    fill: Track<f64>,
    rim: Track<f64>,
    /// The second light, and its strength.
    second: Option<(LightTrack, Track<f64>)>,
    /// Files that its keys name.
    files: Vec<Files>,
}

/// Why a shot cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShotError {
    /// The shot's file cannot be read.
    #[error("{}: cannot read the shot: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The shot says something that is not allowed.
    #[error("{place}: {message}")]
    Wrong {
        /// File and line, or the `--set` that it is in.
        place: String,
        /// The key, its value and what is allowed.
        message: String,
    },
    /// A file that the shot names cannot be read.
    #[error(transparent)]
    Input(#[from] ReadError),
}

impl Shot {
    /// Loads a shot file or a built-in shot, in which there may be `tables`, and overrides keys.
    ///
    /// `name` is a path or `builtin:NAME`; each of `sets` is `KEY=VALUE` with a dotted key and a TOML value
    /// (a bare word is a string). Relative paths become relative to the shot's file; those of a built-in shot to
    /// the current folder.
    pub fn load(name: &str, sets: &[String], tables: &[&'static Table]) -> Result<Shot, ShotError> {
        let (text, folder) = match name.starts_with("builtin:") {
            true => (builtin_text(name, tables)?, PathBuf::new()),
            false => {
                let path = Path::new(name);
                let text = read(path).map_err(|source| ShotError::Read { path: path.to_owned(), source })?;
                let text = String::from_utf8(text).map_err(|e| ShotError::Wrong {
                    place: name.to_owned(),
                    message: format!("not UTF-8 text at byte {}", e.utf8_error().valid_up_to()),
                })?;
                (text, path.parent().unwrap_or(Path::new("")).to_owned())
            }
        };
        let mut tree = Tree::parse(name, &text, tables)?;
        for set in sets {
            tree.set(set)?;
        }
        Shot::from_tree(&tree, &folder, tables)
    }

    fn from_tree(tree: &Tree, folder: &Path, tables: &[&'static Table]) -> Result<Shot, ShotError> {
        tree.check_keys()?;
        let light = Light::default();
        let (frames, fps) = (tree.frames()?, tree.fps()?);
        let section = Section { tree, folder, frames, fps };
        let there = tables.iter().filter(|table| tree.get(table.name).is_some());
        let parts = there.map(|table| (table.read)(&section).map(|part| (table.name, part)));
        let shot = Shot {
            name: tree.name.clone(),
            folder: folder.to_owned(),
            size: tree.size()?,
            frames,
            fps,
            seed: tree.seed()?,
            background: match tree.background()? {
                Background::Image(path) => Background::Image(folder.join(path)),
                other => other,
            },
            output: output(tree, folder)?,
            camera: CameraTrack::new(tree, folder, frames, fps, tree.size()?)?,
            light: light_track(tree, "light")?.unwrap_or(LightTrack::of(light.source)),
            ambient: tree.number("light.ambient", light.ambient)?,
            fill: tree.number("light.fill", light.fill)?,
            rim: tree.number("light.rim", light.rim)?,
            second: second(tree)?,
            parts: parts.collect::<Result<_, ShotError>>()?,
            files: files::named(tree, folder, tables)?,
        };
        if shot.parts.is_empty() {
            let tables: Vec<String> = tables.iter().map(|table| format!("[{}]", table.name)).collect();
            let message =
                format!("the shot holds no effect: add a table {} (every key of it has a default)", one_of(&tables));
            return Err(ShotError::Wrong { place: tree.name.clone(), message });
        }
        shot.check_frames(tree)?;
        Ok(shot)
    }

    /// Whether it has an effect of this name.
    pub fn has(&self, effect: &str) -> bool {
        self.parts.iter().any(|(name, _)| *name == effect)
    }

    /// Its settings of an effect, if it has that.
    pub fn part<P: Part>(&self) -> Option<&P> {
        self.parts.iter().find_map(|(_, part)| (&**part as &dyn Any).downcast_ref())
    }

    /// The same with other settings of an effect that it has.
    pub(crate) fn with_part<P: Part>(&self, part: P) -> Shot {
        let mut shot = self.clone();
        if let Some((_, own)) = shot.parts.iter_mut().find(|(_, own)| (&**own as &dyn Any).is::<P>()) {
            *own = Arc::new(part);
        }
        shot
    }

    /// Checks its effects together.
    ///
    /// # Errors
    /// A key, its value and what is allowed.
    pub fn check_effects(&self) -> Result<(), String> {
        let is_alone = self.parts.len() == 1;
        self.parts.iter().try_for_each(|(_, part)| part.check(is_alone))
    }

    /// The camera at `frame`, which may lie between two.
    pub fn camera(&self, frame: impl Into<f64>) -> Camera {
        self.camera.at(frame.into())
    }

    /// The file that the camera is of, as far as it is one of several things.
    pub fn camera_scene(&self) -> Option<&AnimatedMesh> {
        self.camera.scene()
    }

    /// The light at `frame`.
    pub fn light(&self, frame: u32) -> Light {
        let second = self.second.as_ref();
        Light {
            source: self.light.at(frame),
            ambient: self.ambient.at(frame),
            fill: self.fill.at(frame),
            rim: self.rim.at(frame),
            second: second.map(|(light, own)| SecondLight { source: light.at(frame), strength: own.at(frame) }),
            ..Light::default()
        }
    }

    /// Camera and light must hold at every frame: keyframes can pass through what neither end says.
    fn check_frames(&self, tree: &Tree) -> Result<(), ShotError> {
        let [first, last] = self.frames;
        let last = if self.is_still() { first } else { last };
        for frame in first..=last {
            let checked = self.camera(frame).validate().and_then(|()| self.light(frame).validate());
            let when = if self.is_still() { String::new() } else { format!(" (at frame {frame})") };
            checked.map_err(|e| setting_error(tree, &e, &when))?;
        }
        Ok(())
    }

    fn is_still(&self) -> bool {
        let second = self.second.as_ref();
        let numbers = [&self.ambient, &self.fill, &self.rim].into_iter().chain(second.map(|(_, own)| own));
        self.camera.is_constant()
            && self.light.is_constant()
            && second.is_none_or(|(light, _)| light.is_constant())
            && numbers.into_iter().all(Track::is_constant)
    }
}

fn output(tree: &Tree, folder: &Path) -> Result<Output, ShotError> {
    let config = tree.text("output.config")?.map(|config| match config.starts_with(OCIO) {
        true => PathBuf::from(config),
        false => folder.join(config),
    });
    let view = tree.text("output.view")?.unwrap_or(Output::default().view);
    let output = Output { view, config, space: tree.text("output.space")? };
    match Display::new(&output) {
        Ok(_) => Ok(output),
        Err((key, why)) => Err(tree.wrong(key, format!("{key} = {why}"))),
    }
}

/// Reads a shot's file; what is larger than any shot could be is refused.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    const LARGEST: u64 = 1 << 24;
    let text = file::read(path, LARGEST + 1)?;
    match text.len() as u64 > LARGEST {
        true => Err(io::Error::other("larger than 16 MiB; expected a TOML file")),
        false => Ok(text),
    }
}

/// The commented text of a built-in shot.
pub fn builtin_text(name: &str, tables: &[&'static Table]) -> Result<String, ShotError> {
    BUILTIN
        .iter()
        .find(|(builtin, _)| *builtin == name)
        .map(|(_, text)| print::commented(text, &Keys::new(tables)))
        .ok_or_else(|| {
            let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
            let near = keys::nearest_of(name, &names);
            let message = format!("no such shot is built in; did you mean {near}? There are: {}", names.join(", "));
            ShotError::Wrong { place: name.to_owned(), message }
        })
}

impl LightTrack {
    /// The same at every frame.
    fn of(source: LightSource) -> LightTrack {
        match source {
            LightSource::Direction(direction) => LightTrack::Direction(Track::constant(direction)),
            LightSource::Position(position) => LightTrack::Position(Track::constant(position)),
        }
    }

    fn at(&self, frame: u32) -> LightSource {
        match self {
            LightTrack::Direction(direction) => LightSource::Direction(direction.at(frame)),
            LightTrack::Position(position) => LightSource::Position(position.at(frame)),
        }
    }

    fn is_constant(&self) -> bool {
        let (LightTrack::Direction(track) | LightTrack::Position(track)) = self;
        track.is_constant()
    }
}

/// The light of a table; none where the shot says neither direction nor position.
fn light_track(tree: &Tree, table: &str) -> Result<Option<LightTrack>, ShotError> {
    let [direction, position] = ["direction", "position"].map(|key| format!("{table}.{key}"));
    match (tree.get(&direction), tree.get(&position)) {
        (Some(_), Some(_)) => {
            let message = format!("{position}: a light has a direction or a position, not both");
            Err(tree.wrong(&position, message))
        }
        (None, Some(_)) => Ok(Some(LightTrack::Position(tree.vector(&position, DVec3::ZERO)?))),
        (Some(_), None) => Ok(Some(LightTrack::Direction(tree.vector(&direction, DVec3::ZERO)?))),
        (None, None) => Ok(None),
    }
}

/// The second light, if there is one, and its strength.
fn second(tree: &Tree) -> Result<Option<(LightTrack, Track<f64>)>, ShotError> {
    let strength = tree.number("light.second.strength", SECOND_STRENGTH)?;
    Ok(light_track(tree, "light.second")?.map(|light| (light, strength)))
}

/// Words as a choice: `a, b or c`.
fn one_of(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [some @ .., last] => format!("{} or {last}", some.join(", ")),
    }
}

/// Refuses a key that chooses among what a glTF file holds, where `file` is no such file.
pub(crate) fn only_with_gltf(tree: &Tree, key: &str, file: &str) -> Result<(), ShotError> {
    let Some(node) = tree.get(key) else { return Ok(()) };
    let message = format!("{key} = {}: allowed: only with a glTF file as {file}", tree::value(node));
    Err(tree.wrong(key, message))
}

/// A refused name of an input, with its place in the shot.
pub(crate) fn pattern_error(tree: &Tree, key: &str, error: &PatternError) -> ShotError {
    tree.wrong(key, format!("{key} = \"{}\": {}", tree.word(key).unwrap_or_default(), error.why))
}

/// A refused setting, with its place in the shot.
pub(crate) fn setting_error(tree: &Tree, error: &Error, when: &str) -> ShotError {
    match error {
        Error::Setting { name, value, allowed } => {
            tree.wrong(name, format!("{name} = {value}{when}: allowed: {allowed}"))
        }
        other => ShotError::Wrong { place: tree.name.clone(), message: other.to_string() },
    }
}

#[cfg(test)]
mod tests;
