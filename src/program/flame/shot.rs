//! `[flame]`: its input and its settings.

use std::path::Path;
use std::sync::Arc;

use crate::flame::{Settings, settings::Colour};
use crate::io::particles::ParticleSequence;
use crate::io::pattern::PatternError;
use crate::io::picture::{self, Format};
use crate::io::shot::{Exposure, FileKey, Part, Section, Shot, ShotError, Table, pattern_error, setting_error};

/// A shot's settings of fire.
#[derive(Clone, Debug, PartialEq)]
pub struct Flame {
    /// Where particles come from: `builtin:random`, a file for all frames, or a pattern.
    pub particles: String,
    /// A frame without a file keeps the last particles before it; otherwise it is an error.
    pub hold: bool,
    /// How long its drawings last.
    pub exposure: Exposure,
    /// Everything else; validated. `spread` is none where the shot does not say it.
    pub settings: Settings,
}

/// Colours that are no file.
const COLOURS: &[&str] = &["physical", "displayable"];

/// Keys of its input, each with what is allowed.
const INPUTS: &[(&str, &str)] = &[
    ("flame.particles", "\"builtin:random\", or a file or pattern (\"fire.####.ply\", .csv, .npz)"),
    ("flame.hold", "true or false"),
    ("flame.on", "1, 2 or 3 frames"),
];

pub(super) const TABLE: Table = Table {
    name: "flame",
    inputs: INPUTS,
    dials: Settings::dials,
    files: &[FileKey::sequence("flame.particles"), FileKey::or_words("flame.colour", COLOURS)],
    excluding: &[],
    read,
};

/// Whether the fire of a shot lights its smoke as a lamp, and so tints nothing. With a mesh, it tints both.
pub(in crate::program) fn fire_lights_smoke(shot: &Shot) -> bool {
    let lights = shot.part().is_some_and(|flame: &Flame| flame.settings.lights());
    lights && shot.has("smoke") && !shot.has("blur")
}

impl Part for Flame {
    /// Fire lights what else is in the shot.
    fn check(&self, is_alone: bool) -> Result<(), String> {
        let light = self.settings.light;
        match is_alone && self.settings.lights() {
            true => Err(format!(
                "flame.light = {light}: allowed: only with something for the fire to tint: add a table [smoke] or \
                 [blur], or leave it out"
            )),
            false => Ok(()),
        }
    }
}

impl Flame {
    /// The particles of the frames, not yet read.
    ///
    /// # Errors
    /// A name that no particles have.
    pub fn particles(&self, shot: &Shot) -> Result<ParticleSequence, PatternError> {
        ParticleSequence::new(&self.particles, &shot.folder, (), self.hold, shot.fps)
    }
}

fn read(section: &Section) -> Result<Arc<dyn Part>, ShotError> {
    let Section { tree, folder, fps, .. } = *section;
    let mut settings: Settings = tree.settings("flame", &["particles", "hold", "on", "colour"])?;
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
    let particles = tree.text("flame.particles")?.unwrap_or_else(|| "builtin:random".to_owned());
    let hold = tree.flag("flame.hold")?;
    ParticleSequence::new(&particles, folder, (), hold, fps).map_err(|e| pattern_error(tree, "flame.particles", &e))?;
    let exposure = section.exposure("flame.on")?;
    Ok(Arc::new(Flame { particles, hold, exposure, settings }))
}
