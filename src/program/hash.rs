//! Hashes of what frames are made from.

use std::collections::HashMap;
use std::fmt::Debug;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::Xxh3;

use crate::io::ReadError;
use crate::io::file::{Stamp, digest};
use crate::io::sequence::{self, Sequence};

/// Files whose contents are known. Each is read once.
#[derive(Default)]
pub(crate) struct Files {
    files: HashMap<PathBuf, (Stamp, u128)>,
    /// Those that were asked for since the last check.
    recent: Vec<PathBuf>,
}

impl Files {
    /// A hash of what is in a file.
    pub(crate) fn digest(&mut self, path: &Path) -> Result<u128, ReadError> {
        self.recent.push(path.to_owned());
        if let Some((_, digest)) = self.files.get(path) {
            return Ok(*digest);
        }
        // Before the contents, so that what is written meanwhile shows.
        let stamp = Stamp::of(path)?;
        let digest = digest(path)?;
        self.files.insert(path.to_owned(), (stamp, digest));
        Ok(digest)
    }

    /// The same of a frame's input; none where it is built in.
    pub(crate) fn digest_of<I: sequence::Input>(
        &mut self,
        sequence: &Sequence<I>,
        frame: u32,
    ) -> Result<Option<u128>, ReadError> {
        sequence.file(frame)?.map(|file| self.digest(&file)).transpose()
    }

    /// An error if a file that was asked for since the last check is no longer what it was.
    pub(crate) fn check(&mut self) -> Result<(), ReadError> {
        let Files { files, recent } = self;
        recent.drain(..).try_for_each(|path| files.get(&path).map_or(Ok(()), |(stamp, _)| stamp.check(&path)))
    }
}

/// Adds a value by its text, which has every digit of every number and ends where the next begins.
pub(crate) fn add(hash: &mut Xxh3, value: impl Debug) {
    hash.update(format!("{value:?}\n").as_bytes());
}

/// The name of a built-in input; a file is known by what is in it.
pub(super) fn builtin(name: &str) -> Option<&str> {
    name.starts_with("builtin:").then_some(name)
}
