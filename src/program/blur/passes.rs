//! `[blur.passes]`: what a renderer writes beside its pictures, instead of a scene.

use super::shot::sequence;
use crate::io::passes::{Passes, Vectors};
use crate::io::pattern::Pattern;
use crate::io::shot::{Section, ShotError};

/// Largest factor of vectors.
const MOST_SCALE: f64 = 1000.0;

/// Keys, each with what is allowed.
pub(super) const INPUTS: [(&str, &str); 7] = [
    ("blur.passes", "a table with colour, depth, motion and maybe id, instead of blur.scene and blur.images"),
    ("blur.passes.colour", "a pattern of image files, one a frame (\"beauty.####.exr\", .png, .jpg)"),
    ("blur.passes.depth", "a pattern of EXR files, one a frame (\"z.####.exr\")"),
    ("blur.passes.motion", "a pattern of EXR files, one a frame (\"vector.####.exr\")"),
    ("blur.passes.id", "a pattern of EXR files, one a frame (\"id.####.exr\")"),
    ("blur.passes.vectors", "\"blender\", \"arnold\" or \"unreal\""),
    ("blur.passes.scale", "a number, -1000 to 1000"),
];

/// Keys that have the place of a scene.
const FILES: [&str; 4] = ["blur.passes.colour", "blur.passes.depth", "blur.passes.motion", "blur.passes.id"];
/// Keys that they have the place of.
const OTHERS: [&str; 3] = ["blur.scene", "blur.animation", "blur.images"];

/// The passes of a shot and its pictures, if it has them.
///
/// # Errors
/// One of them without the others, or with a scene.
pub(super) fn read(section: &Section) -> Result<Option<(Pattern, Passes)>, ShotError> {
    let tree = section.tree;
    let vectors = match tree.word("blur.passes.vectors") {
        None if tree.get("blur.passes.vectors").is_none() => Vectors::default(),
        Some("blender") => Vectors::Blender,
        Some("arnold") => Vectors::Arnold,
        Some("unreal") => Vectors::Unreal,
        _ => return Err(tree.not_allowed("blur.passes.vectors")),
    };
    let scale = tree.plain_number("blur.passes.scale", 1.0, -MOST_SCALE..=MOST_SCALE)? as f32;
    let Some(given) = FILES.into_iter().find(|key| tree.get(key).is_some()) else { return Ok(None) };
    if let Some(other) = OTHERS.into_iter().find(|key| tree.get(key).is_some()) {
        let message =
            format!("{other}: allowed: not together with {given}: passes have the place of a scene and its images");
        return Err(tree.wrong(other, message));
    }
    let needed = |key: &str| {
        let message = || format!("{given}: allowed: blur.passes.colour, depth and motion together; {key} is missing");
        sequence(section, key)?.ok_or_else(|| tree.wrong(given, message()))
    };
    let [colour, depth, motion] = [needed(FILES[0])?, needed(FILES[1])?, needed(FILES[2])?];
    let id = sequence(section, FILES[3])?;
    Ok(Some((colour, Passes { depth, motion, id, vectors, scale })))
}
