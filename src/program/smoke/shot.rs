//! `[smoke]`: its input and its settings.

use std::sync::Arc;

use crate::io::pattern::PatternError;
use crate::io::shot::{
    Exposure, FileKey, Part, Section, Shot, ShotError, Table, pattern_error, setting_error, texture,
};
use crate::io::volume::{Grids, Up, VolumeSequence};
use crate::smoke::Settings;

/// A shot's settings of smoke.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoke {
    /// Where density and velocity come from: `builtin:plume`, `builtin:cloud`, a file for all frames, or a pattern.
    pub volume: String,
    /// Names of the arrays in the files.
    pub grids: Grids,
    /// A frame without a file keeps the last volume before it; otherwise it is an error.
    pub hold: bool,
    /// Frames per second of the files, if those are not the shot's.
    pub volume_fps: Option<f64>,
    /// How long its drawings last.
    pub exposure: Exposure,
    /// Everything else; validated.
    pub settings: Settings,
}

/// Keys of its input, each with what is allowed.
const INPUTS: &[(&str, &str)] = &[
    ("smoke.volume", "\"builtin:plume\", \"builtin:cloud\", or a file or pattern (\"smoke.####.vdb\", .npz)"),
    ("smoke.density_grid", "the name of a grid of the file; \"name[1]\" is the second of that name"),
    (
        "smoke.velocity_grid",
        "the name of a grid of the file, of vectors, or what three of numbers have before x, y and z",
    ),
    ("smoke.velocity_scale", "-1e6 to 1e6"),
    ("smoke.volume_fps", "0.001 to 1000000"),
    ("smoke.up", "\"y\" or \"z\""),
    ("smoke.hold", "true or false"),
    ("smoke.on", "1, 2 or 3 frames"),
];

pub(super) const TABLE: Table = Table {
    name: "smoke",
    inputs: INPUTS,
    dials: Settings::dials,
    files: &[FileKey::sequence("smoke.volume"), FileKey::one("smoke.tones"), FileKey::one("smoke.tones_above")],
    excluding: &[],
    read,
};

impl Part for Smoke {}

impl Smoke {
    /// The volumes of the frames, not yet read.
    ///
    /// # Errors
    /// A name that no volume has.
    pub fn volumes(&self, shot: &Shot) -> Result<VolumeSequence, PatternError> {
        let all = VolumeSequence::new(&self.volume, &shot.folder, self.grids.clone(), self.hold, shot.fps)?;
        Ok(match self.volume_fps {
            Some(fps) => all.at_rate(shot.frames[0], fps / shot.fps),
            None => all,
        })
    }
}

fn read(section: &Section) -> Result<Arc<dyn Part>, ShotError> {
    const ELSEWHERE: &[&str] =
        &["volume", "density_grid", "velocity_grid", "velocity_scale", "volume_fps", "up", "hold", "on"];
    let Section { tree, folder, fps, .. } = *section;
    let [tones, above] = ["smoke.tones", "smoke.tones_above"].map(|key| tree.word(key));
    let of_files = [("tones", tones), ("tones_above", above)].into_iter().filter(|(_, file)| file.is_some());
    let elsewhere: Vec<&str> = ELSEWHERE.iter().copied().chain(of_files.map(|(key, _)| key)).collect();
    let mut settings: Settings = tree.settings("smoke", &elsewhere)?;
    if let Some(file) = tones {
        settings.tones = texture::tones(&folder.join(file))?;
    }
    if let Some(file) = above {
        settings.tones_above = Some(texture::tones(&folder.join(file))?);
    }
    settings.validate().map_err(|e| setting_error(tree, &e, ""))?;
    let volume = tree.text("smoke.volume")?.unwrap_or_else(|| "builtin:plume".to_owned());
    let grids = Grids {
        density: tree.text("smoke.density_grid")?,
        velocity: tree.text("smoke.velocity_grid")?,
        up: tree.read("smoke.up", Up::Y, |value| match value.as_str()? {
            "y" => Some(Up::Y),
            "z" => Some(Up::Z),
            _ => None,
        })?,
        velocity_scale: tree.plain_number("smoke.velocity_scale", 1.0, -1e6..=1e6)? as f32,
    };
    let volume_fps = tree.read("smoke.volume_fps", None, |value| {
        let fps = value.as_float().or_else(|| value.as_integer().map(|n| n as f64))?;
        (1e-3..=1e6).contains(&fps).then_some(Some(fps))
    })?;
    let hold = tree.flag("smoke.hold")?;
    VolumeSequence::new(&volume, folder, grids.clone(), hold, fps)
        .map_err(|e| pattern_error(tree, "smoke.volume", &e))?;
    let exposure = section.exposure("smoke.on")?;
    Ok(Arc::new(Smoke { volume, grids, hold, volume_fps, exposure, settings }))
}
