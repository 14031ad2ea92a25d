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
mod files;
mod keys;
mod print;
mod read;
mod texture;
mod track;
mod tree;

use std::io;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::overlap::Files;
use super::particles::ParticleSequence;
use super::pattern::{Pattern, PatternError};
use super::picture::{self, Format};
use super::scene::{self, AnimatedMesh, Choice, Clock, Pick};
use super::volume::{Grids, VolumeSequence};
use super::{ReadError, file};
use crate::blur;
use crate::error::Error;
use crate::flame::{self, settings::Colour};
use crate::smoke::settings::Settings;
use crate::view::{Camera, Light, LightSource};
use camera::CameraTrack;
pub use camera::count_cameras;
use track::Track;
use tree::Tree;

/// The shots inside the program: name, and text without the comments at settings, which [`builtin_text`] adds.
pub const BUILTIN: &[(&str, &str)] = &[
    ("builtin:smoke", include_str!("shot/smoke.toml")),
    ("builtin:cloud", include_str!("shot/cloud.toml")),
    ("builtin:flame", include_str!("shot/flame.toml")),
    ("builtin:campfire", include_str!("shot/campfire.toml")),
    ("builtin:blur", include_str!("shot/blur.toml")),
];

/// What is behind the effects.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// Linear RGB, each finite and >= 0.
    Colour([f32; 3]),
    /// An image file.
    Image(PathBuf),
    /// Nothing: pictures keep their alpha.
    None,
}

/// `[smoke]`: its input and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoke {
    /// Where density and velocity come from: `builtin:plume`, `builtin:cloud`, a file for all frames, or a pattern.
    pub volume: String,
    /// Names of the arrays in the files.
    pub grids: Grids,
    /// A frame without a file keeps the last volume before it; otherwise it is an error.
    pub hold: bool,
    /// Everything else; validated.
    pub settings: Settings,
}

/// `[flame]`: its input and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Flame {
    /// Where particles come from: `builtin:random`, a file for all frames, or a pattern.
    pub particles: String,
    /// A frame without a file keeps the last particles before it; otherwise it is an error.
    pub hold: bool,
    /// Everything else; validated. `spread` is none where the shot does not say it.
    pub settings: flame::Settings,
}

/// `[blur]`: its input and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Blur {
    /// Where the animated mesh comes from.
    pub scene: scene::Source,
    /// The animations of the file that are played; none: its first.
    pub animations: Vec<Pick>,
    /// The frames that are blurred, one picture each; none: they are drawn.
    pub images: Option<Pattern>,
    /// Everything else; validated.
    pub settings: blur::Settings,
}

#[derive(Clone, Debug, PartialEq)]
enum LightTrack {
    Direction(Track<DVec3>),
    Position(Track<DVec3>),
}

/// A shot, checked: whatever [`Shot::load`] returns can be rendered as far as its own values go.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// Where it came from, for messages: a path or `builtin:NAME`.
    pub name: String,
    /// What relative paths in it are relative to.
    pub folder: PathBuf,
    /// Width and height in pixels, 1 to 16384 each.
    pub size: [u32; 2],
    /// First and last frame, both rendered.
    pub frames: [u32; 2],
    /// Frames per second, 0.001 to 1,000,000.
    pub fps: f64,
    /// Seed of everything random.
    pub seed: u32,
    /// What is behind the effects.
    pub background: Background,
    /// The smoke. There is at least one effect.
    pub smoke: Option<Smoke>,
    /// The fire.
    pub flame: Option<Flame>,
    /// The motion blur of an animated mesh.
    pub blur: Option<Blur>,
    camera: CameraTrack,
    light: LightTrack,
    ambient: Track<f64>,
    /// What its keys name.
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
    /// Loads a shot file or a built-in shot and overrides keys.
    ///
    /// `name` is a path or `builtin:NAME`; each of `sets` is `KEY=VALUE` with a dotted key and a TOML value
    /// (a bare word is a string). Relative paths become relative to the shot's file; those of a built-in shot to
    /// the current folder.
    pub fn load(name: &str, sets: &[String]) -> Result<Shot, ShotError> {
        let (text, folder) = match name.starts_with("builtin:") {
            true => (builtin_text(name)?, PathBuf::new()),
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
        let mut tree = Tree::parse(name, &text)?;
        for set in sets {
            tree.set(set)?;
        }
        Shot::from_tree(&tree, &folder)
    }

    fn from_tree(tree: &Tree, folder: &Path) -> Result<Shot, ShotError> {
        tree.check_keys()?;
        let light = Light::default();
        let (frames, fps) = (tree.frames()?, tree.fps()?);
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
            camera: CameraTrack::new(tree, folder, frames, fps)?,
            light: light_track(tree, light)?,
            ambient: tree.number("light.ambient", light.ambient)?,
            smoke: tree.get("smoke").map(|_| smoke(tree, folder)).transpose()?,
            flame: tree.get("flame").map(|_| flame(tree, folder)).transpose()?,
            blur: tree.get("blur").map(|_| blur(tree, folder, frames)).transpose()?,
            files: files::named(tree, folder)?,
        };
        if shot.smoke.is_none() && shot.flame.is_none() && shot.blur.is_none() {
            let message =
                "the shot holds no effect: add a table [smoke], [flame] or [blur] (every key of it has a default)";
            return Err(ShotError::Wrong { place: tree.name.clone(), message: message.to_owned() });
        }
        shot.check_frames(tree)?;
        shot.volumes().map_err(|e| pattern_error(tree, "smoke.volume", &e))?;
        shot.particles().map_err(|e| pattern_error(tree, "flame.particles", &e))?;
        Ok(shot)
    }

    /// The volumes of the frames, not yet read; none without smoke.
    pub fn volumes(&self) -> Result<Option<VolumeSequence>, PatternError> {
        let sequence = |Smoke { volume, grids, hold, .. }: &Smoke| {
            VolumeSequence::new(volume, &self.folder, grids.clone(), *hold, self.fps)
        };
        self.smoke.as_ref().map(sequence).transpose()
    }

    /// The particles of the frames, not yet read; none without fire.
    pub fn particles(&self) -> Result<Option<ParticleSequence>, PatternError> {
        let sequence =
            |Flame { particles, hold, .. }: &Flame| ParticleSequence::new(particles, &self.folder, (), *hold, self.fps);
        self.flame.as_ref().map(sequence).transpose()
    }

    /// The animated mesh, read or made; none without blur.
    pub fn scene(&self) -> Result<Option<AnimatedMesh>, ReadError> {
        let clock = Clock { first: self.frames[0], fps: self.fps };
        let Some(Blur { scene, animations, .. }) = &self.blur else { return Ok(None) };
        let choice = Choice { animations: animations.clone(), ..Choice::default() };
        let mesh = AnimatedMesh::open(scene, &choice, clock)?;
        mesh.check_frames(self.frames)?;
        Ok(Some(mesh))
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
        let source = match &self.light {
            LightTrack::Direction(direction) => LightSource::Direction(direction.at(frame)),
            LightTrack::Position(position) => LightSource::Position(position.at(frame)),
        };
        Light { source, ambient: self.ambient.at(frame) }
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
        let (LightTrack::Direction(light) | LightTrack::Position(light)) = &self.light;
        self.camera.is_constant() && light.is_constant() && self.ambient.is_constant()
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
pub fn builtin_text(name: &str) -> Result<String, ShotError> {
    BUILTIN.iter().find(|(builtin, _)| *builtin == name).map(|(_, text)| print::commented(text)).ok_or_else(|| {
        let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
        let near = keys::nearest_of(name, &names);
        let message = format!("no such shot is built in; did you mean {near}? There are: {}", names.join(", "));
        ShotError::Wrong { place: name.to_owned(), message }
    })
}

fn light_track(tree: &Tree, default: Light) -> Result<LightTrack, ShotError> {
    match (tree.get("light.direction"), tree.get("light.position")) {
        (Some(_), Some(_)) => {
            let message = "light.position: a light has a direction or a position, not both".to_owned();
            Err(tree.wrong("light.position", message))
        }
        (None, Some(_)) => Ok(LightTrack::Position(tree.vector("light.position", DVec3::ZERO)?)),
        _ => {
            let direction = match default.source {
                LightSource::Direction(direction) | LightSource::Position(direction) => direction,
            };
            Ok(LightTrack::Direction(tree.vector("light.direction", direction)?))
        }
    }
}

fn smoke(tree: &Tree, folder: &Path) -> Result<Smoke, ShotError> {
    const ELSEWHERE: &[&str] = &["volume", "density_grid", "velocity_grid", "hold"];
    let tones = tree.word("smoke.tones");
    let elsewhere = [ELSEWHERE, if tones.is_some() { &["tones"] } else { &[] }].concat();
    let mut settings: Settings = tree.settings("smoke", &elsewhere)?;
    if let Some(file) = tones {
        settings.tones = texture::tones(&folder.join(file))?;
    }
    settings.validate().map_err(|e| setting_error(tree, &e, ""))?;
    Ok(Smoke {
        volume: tree.text("smoke.volume")?.unwrap_or_else(|| "builtin:plume".to_owned()),
        grids: Grids { density: tree.text("smoke.density_grid")?, velocity: tree.text("smoke.velocity_grid")? },
        hold: tree.flag("smoke.hold")?,
        settings,
    })
}

fn flame(tree: &Tree, folder: &Path) -> Result<Flame, ShotError> {
    let mut settings: flame::Settings = tree.settings("flame", &["particles", "hold", "colour"])?;
    match (tree.get("flame.colour"), tree.word("flame.colour")) {
        (None, _) => {}
        (_, Some("physical")) => settings.colour = Colour::Physical,
        (_, Some("displayable")) => settings.colour = Colour::Displayable,
        (_, Some(file)) if Format::of(Path::new(file)).is_some() => {
            settings.colour = Colour::Ramp(picture::read_row(&folder.join(file))?);
        }
        _ => return Err(tree.not_allowed("flame.colour")),
    }
    settings.validate().map_err(|e| setting_error(tree, &e, ""))?;
    Ok(Flame {
        particles: tree.text("flame.particles")?.unwrap_or_else(|| "builtin:random".to_owned()),
        hold: tree.flag("flame.hold")?,
        settings,
    })
}

fn blur(tree: &Tree, folder: &Path, [first, last]: [u32; 2]) -> Result<Blur, ShotError> {
    const ELSEWHERE: &[&str] = &["scene", "animation", "images"];
    let tones = tree.word("blur.toon.tones");
    let elsewhere = [ELSEWHERE, if tones.is_some() { &["toon.tones"] } else { &[] }].concat();
    let mut settings: blur::Settings = tree.settings("blur", &elsewhere)?;
    if let Some(file) = tones {
        settings.toon.tones = texture::tones(&folder.join(file))?;
    }
    settings.validate().map_err(|e| setting_error(tree, &e, ""))?;
    let scene = tree.text("blur.scene")?.unwrap_or_else(|| "builtin:run".to_owned());
    let scene = scene::Source::named(&scene, folder).map_err(|e| pattern_error(tree, "blur.scene", &e))?;
    let animations = tree.picks("blur.animation")?;
    if matches!(scene, scene::Source::Builtin(_)) {
        only_with_gltf(tree, "blur.animation", "blur.scene")?;
    }
    let is_cache = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"));
    match &scene {
        scene::Source::File(path) if is_cache(path) && settings.trajectory == blur::settings::Trajectory::Exact => {
            let message = "blur.trajectory = \"exact\": allowed: \"spline\"; an .npz file has no poses between frames";
            return Err(tree.wrong("blur.trajectory", message.to_owned()));
        }
        _ => {}
    }
    let images = match tree.text("blur.images")? {
        Some(pattern) => {
            let pattern = Pattern::parse(&pattern).and_then(|pattern| {
                pattern.check_frames(first, last)?;
                Ok(pattern.below(folder))
            });
            Some(pattern.map_err(|e| pattern_error(tree, "blur.images", &e))?)
        }
        None => None,
    };
    Ok(Blur { scene, animations, images, settings })
}

/// Refuses a key that chooses among what a glTF file holds, where `file` is no such file.
fn only_with_gltf(tree: &Tree, key: &str, file: &str) -> Result<(), ShotError> {
    let Some(node) = tree.get(key) else { return Ok(()) };
    let message = format!("{key} = {}: allowed: only with a glTF file as {file}", tree::value(node));
    Err(tree.wrong(key, message))
}

/// A refused name of an input, with its place in the shot.
fn pattern_error(tree: &Tree, key: &str, error: &PatternError) -> ShotError {
    tree.wrong(key, format!("{key} = \"{}\": {}", tree.word(key).unwrap_or_default(), error.why))
}

/// A refused setting, with its place in the shot.
fn setting_error(tree: &Tree, error: &Error, when: &str) -> ShotError {
    match error {
        Error::Setting { name, value, allowed } => {
            tree.wrong(name, format!("{name} = {value}{when}: allowed: {allowed}"))
        }
        other => ShotError::Wrong { place: tree.name.clone(), message: other.to_string() },
    }
}

#[cfg(test)]
mod tests;
