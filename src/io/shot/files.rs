//! The files that a shot is made from.

use std::path::Path;

use super::tree::Tree;
use super::{OCIO, Shot, ShotError, Table};
use crate::io::overlap::Files;
use crate::io::pattern::Pattern;
use crate::io::scene;

/// A key whose value may be the name of a file. A value that begins with `builtin:` or `ocio://` is none.
#[derive(Clone, Copy, Debug)]
pub struct FileKey {
    name: &'static str,
    /// Values that are words.
    words: &'static [&'static str],
    /// Whether there may be a file a frame.
    is_pattern: bool,
}

impl FileKey {
    /// One file.
    pub const fn one(name: &'static str) -> FileKey {
        FileKey { name, words: &[], is_pattern: false }
    }

    /// One file, or one of these words.
    pub const fn or_words(name: &'static str, words: &'static [&'static str]) -> FileKey {
        FileKey { name, words, is_pattern: false }
    }

    /// One file, or one a frame.
    pub const fn sequence(name: &'static str) -> FileKey {
        FileKey { name, words: &[], is_pattern: true }
    }
}

/// Those of the shot itself.
const KEYS: [FileKey; 3] =
    [FileKey::or_words("background", &["none"]), FileKey::one("camera.file"), FileKey::one("output.config")];
/// What values begin with that are no names of files.
const BUILT_IN: [&str; 2] = ["builtin:", OCIO];

/// Every such key.
fn keys<'a>(tables: &'a [&'static Table]) -> impl Iterator<Item = FileKey> + 'a {
    KEYS.into_iter().chain(tables.iter().flat_map(|table| table.files).copied())
}

/// Files that a shot's keys name.
pub(super) fn named(tree: &Tree, folder: &Path, tables: &[&'static Table]) -> Result<Vec<Files>, ShotError> {
    let mut files = Vec::new();
    for FileKey { name, words, is_pattern } in keys(tables) {
        let Some(value) = tree.word(name) else { continue };
        if value.is_empty() || BUILT_IN.iter().any(|start| value.starts_with(start)) || words.contains(&value) {
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
    use super::super::keys::Keys;

    #[test]
    fn every_key_that_takes_a_file_is_known() {
        // These say what of another key's file they are about.
        let about = ["camera.name", "camera.animation", "smoke.density_grid", "smoke.velocity_grid", "blur.animation"];
        let keys = Keys::new(&crate::program::tables());
        let take: Vec<&str> =
            keys.all().iter().filter(|dial| dial.allowed.contains("file")).map(|dial| dial.key.as_str()).collect();
        let take: Vec<&str> = take.into_iter().filter(|key| !about.contains(key)).collect();
        let mut known: Vec<&str> = super::keys(&crate::program::tables()).map(|key| key.name).collect();
        let mut take = take;
        known.sort_unstable();
        take.sort_unstable();
        assert_eq!(take, known);
    }
}
