//! `[blur]`: its input and its settings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::passes;
use crate::blur::Settings;
use crate::blur::settings::Trajectory;
use crate::io::ReadError;
use crate::io::passes::Passes;
use crate::io::pattern::Pattern;
use crate::io::scene::{AnimatedMesh, Choice, Clock, Pick, Source};
use crate::io::shot::{
    FileKey, Part, Section, Shot, ShotError, Table, only_with_gltf, pattern_error, setting_error, texture,
};

/// A shot's settings of the motion blur of an animated mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Blur {
    /// Where the animated mesh comes from, if there are no passes.
    pub scene: Source,
    /// The animations of the file that are played; none: its first.
    pub animations: Vec<Pick>,
    /// The frames that are blurred, one picture each; none: they are drawn.
    pub images: Option<Pattern>,
    /// What a renderer wrote beside the images, instead of a mesh.
    pub passes: Option<Passes>,
    /// Frames that begin a new shot, of mesh and camera; none: they are found.
    pub cuts: Option<Vec<u32>>,
    /// Shares of strength of objects and materials, by name.
    pub shares: Vec<(String, f32)>,
    /// A picture of shares of strength, painted on the mesh's texture coordinates.
    pub share_map: Option<PathBuf>,
    /// Everything else; validated.
    pub settings: Settings,
}

/// Keys of its input, each with what is allowed.
const INPUTS: &[(&str, &str)] = {
    let [of_passes, colour, depth, motion, id, vectors, scale] = passes::INPUTS;
    &[SCENE, ANIMATION, CUTS, SHARES, SHARE_MAP, IMAGES, of_passes, colour, depth, motion, id, vectors, scale]
};
const SCENE: (&str, &str) =
    ("blur.scene", "\"builtin:run\", \"builtin:spin\" or \"builtin:crossing\", or a file (.glb, .gltf, .npz)");
const ANIMATION: (&str, &str) = (
    "blur.animation",
    "the name of an animation of the glTF file, its number, from 0, a list of names and numbers, or \"*\" for all",
);
const CUTS: (&str, &str) = ("blur.cuts", "a list of frames, whole numbers, 0 to 999999, ascending; [] for none");
const IMAGES: (&str, &str) = ("blur.images", "a pattern of image files, one a frame (\"frames/####.png\", .exr, .jpg)");
const SHARES: (&str, &str) =
    ("blur.shares", "[[name, share], ...]: names of objects or materials of the scene, and shares of strength, 0 to 1");
const SHARE_MAP: (&str, &str) = ("blur.share_map", "an image file (.png, .exr, .jpg)");

pub(super) const TABLE: Table = Table {
    name: "blur",
    inputs: INPUTS,
    dials: Settings::dials,
    files: &[
        FileKey::one("blur.scene"),
        FileKey::sequence("blur.images"),
        FileKey::one("blur.share_map"),
        FileKey::sequence("blur.passes.colour"),
        FileKey::sequence("blur.passes.depth"),
        FileKey::sequence("blur.passes.motion"),
        FileKey::sequence("blur.passes.id"),
        FileKey::one("blur.toon.tones"),
    ],
    excluding: &[
        ["blur.teeth", "blur.tooth_width"],
        ["blur.scene", "blur.passes.colour"],
        ["blur.animation", "blur.passes.colour"],
        ["blur.images", "blur.passes.colour"],
        ["blur.shares", "blur.passes.colour"],
        ["blur.share_map", "blur.passes.colour"],
        ["blur.scene", "blur.passes.depth"],
        ["blur.animation", "blur.passes.depth"],
        ["blur.images", "blur.passes.depth"],
        ["blur.scene", "blur.passes.motion"],
        ["blur.animation", "blur.passes.motion"],
        ["blur.images", "blur.passes.motion"],
        ["blur.scene", "blur.passes.id"],
        ["blur.animation", "blur.passes.id"],
        ["blur.images", "blur.passes.id"],
    ],
    read,
};

impl Part for Blur {
    /// Depth of passes is not that of what else is in a shot.
    fn check(&self, is_alone: bool) -> Result<(), String> {
        match self.passes.is_some() && !is_alone {
            true => Err("blur.passes: allowed: only where [blur] is the only effect".to_owned()),
            false => Ok(()),
        }
    }
}

impl Blur {
    /// The animated mesh, read or made.
    ///
    /// # Errors
    /// A file that cannot be read, or has no pose of the shot's frames.
    pub fn mesh(&self, shot: &Shot) -> Result<AnimatedMesh, ReadError> {
        let clock = Clock { first: shot.frames[0], fps: shot.fps };
        let choice = Choice { animations: self.animations.clone(), ..Choice::default() };
        let mut mesh = AnimatedMesh::open(&self.scene, &choice, clock)?;
        mesh.check_frames(shot.frames)?;
        mesh.share_strength(&self.shares)?;
        self.share_map.iter().try_for_each(|map| mesh.paint_strength(map))?;
        Ok(mesh)
    }
}

fn read(section: &Section) -> Result<Arc<dyn Part>, ShotError> {
    const ELSEWHERE: &[&str] = &["scene", "animation", "images", "cuts", "shares", "share_map", "passes"];
    let Section { tree, folder, .. } = *section;
    let tones = tree.word("blur.toon.tones");
    let elsewhere = [ELSEWHERE, if tones.is_some() { &["toon.tones"] } else { &[] }].concat();
    let mut settings: Settings = tree.settings("blur", &elsewhere)?;
    if let Some(file) = tones {
        settings.toon.tones = texture::tones(&folder.join(file))?;
    }
    settings.validate().map_err(|e| setting_error(tree, &e, ""))?;
    let scene = tree.text("blur.scene")?.unwrap_or_else(|| "builtin:run".to_owned());
    let scene = Source::named(&scene, folder).map_err(|e| pattern_error(tree, "blur.scene", &e))?;
    let animations = tree.picks("blur.animation")?;
    if matches!(scene, Source::Builtin(_)) {
        only_with_gltf(tree, "blur.animation", "blur.scene")?;
    }
    let is_cache = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"));
    match &scene {
        Source::File(path) if is_cache(path) && settings.trajectory == Trajectory::Exact => {
            let message = "blur.trajectory = \"exact\": allowed: \"spline\"; an .npz file has no poses between frames";
            return Err(tree.wrong("blur.trajectory", message.to_owned()));
        }
        _ => {}
    }
    let passes = passes::read(section)?;
    if passes.is_some() && settings.trajectory == Trajectory::Exact {
        let message =
            "blur.trajectory = \"exact\": allowed: \"spline\" or \"past\"; passes have no poses between frames";
        return Err(tree.wrong("blur.trajectory", message.to_owned()));
    }
    let (images, passes) = match passes {
        Some((colour, passes)) => (Some(colour), Some(passes)),
        None => (sequence(section, "blur.images")?, None),
    };
    let cuts = tree.frame_list("blur.cuts")?;
    if cuts.is_some() {
        // What is given is all: none are looked for.
        settings.jump = 0.0;
    }
    let shares = tree.shares("blur.shares")?;
    let share_map = tree.text("blur.share_map")?.map(|file| folder.join(file));
    Ok(Arc::new(Blur { scene, animations, images, passes, cuts, shares, share_map, settings }))
}

/// The files of a key that has one a frame.
pub(super) fn sequence(section: &Section, key: &str) -> Result<Option<Pattern>, ShotError> {
    let Section { tree, folder, frames: [first, last], .. } = *section;
    let Some(pattern) = tree.text(key)? else { return Ok(None) };
    let pattern = Pattern::parse(&pattern).and_then(|pattern| {
        pattern.check_frames(first, last)?;
        Ok(pattern.below(folder))
    });
    pattern.map(Some).map_err(|e| pattern_error(tree, key, &e))
}
