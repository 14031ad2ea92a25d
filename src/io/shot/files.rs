//! The files that a shot is made from.

use std::path::Path;

use super::tree::Tree;
use super::{Shot, ShotError};
use crate::io::overlap::Files;
use crate::io::pattern::Pattern;
use crate::io::scene;

/// A key whose value may be the name of a file.
struct Key {
    name: &'static str,
    /// Values that are words.
    words: &'static [&'static str],
    /// Whether there may be a file a frame.
    is_pattern: bool,
}

const fn key(name: &'static str, words: &'static [&'static str], is_pattern: bool) -> Key {
    Key { name, words, is_pattern }
}

/// Every such key. A value that begins with `builtin:` is no file either.
const KEYS: [Key; 9] = [
    key("background", &["none"], false),
    key("camera.file", &[], false),
    key("smoke.volume", &[], true),
    key("smoke.tones", &[], false),
    key("flame.particles", &[], true),
    key("flame.colour", &["physical", "displayable"], false),
    key("blur.scene", &[], false),
    key("blur.images", &[], true),
    key("blur.toon.tones", &[], false),
];

/// What a shot's keys name.
pub(super) fn named(tree: &Tree, folder: &Path) -> Result<Vec<Files>, ShotError> {
    let mut files = Vec::new();
    for Key { name, words, is_pattern } in KEYS {
        let Some(value) = tree.word(name) else { continue };
        if value.is_empty() || value.starts_with("builtin:") || words.contains(&value) {
            continue;
        }
        let pattern = match is_pattern {
            true => Pattern::parse(value).map_err(|e| super::pattern_error(tree, name, &e))?.below(folder),
            false => Pattern::single(folder.join(value)),
        };
        files.push(Files::new(format!("{name} = \"{value}\""), pattern));
    }
    Ok(files)
}

impl Shot {
    /// All files that the shot is made from: its own, those that its keys name, and those that these refer to. They need
    /// not be there.
    pub fn inputs(&self) -> Vec<Files> {
        let own = (!self.name.starts_with("builtin:"))
            .then(|| Files::new(format!("the shot {}", self.name), Pattern::single(&self.name)));
        let mut inputs: Vec<Files> = own.into_iter().chain(self.files.iter().cloned()).collect();
        for file in self.files.iter().filter(|file| !file.pattern.has_number()) {
            let path = file.pattern.path(0);
            let referred = scene::references(&path);
            let what = format!("a part of {}", path.display());
            inputs.extend(referred.into_iter().map(|part| Files::new(what.clone(), Pattern::single(part))));
        }
        inputs
    }
}

#[cfg(test)]
mod tests {
    use super::super::keys;
    use super::*;

    #[test]
    fn every_key_that_takes_a_file_is_known() {
        // These say what of another key's file they are about.
        let about = ["camera.name", "camera.animation", "smoke.density_grid", "smoke.velocity_grid", "blur.animation"];
        let take: Vec<&str> =
            keys::KEYS.iter().filter(|dial| dial.allowed.contains("file")).map(|dial| dial.key.as_str()).collect();
        let take: Vec<&str> = take.into_iter().filter(|key| !about.contains(key)).collect();
        assert_eq!(take, KEYS.map(|key| key.name));
    }
}
