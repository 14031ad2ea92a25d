//! A folder of what frames go on from: a process that renders a later one begins there, and not at the shot's first.
//!
//! Files are named by the hash of all that went before, so that those of any shots lie side by side, and none is ever wrong: at worst
//! it is not asked for again. The folder may be emptied at any time.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::xxh3_128;

use crate::io::{WriteError, remove_stale_parts, write_atomic};

/// Frames from one that is kept to the next.
const EVERY: u32 = 8;
/// The first bytes of a file.
const HEAD: &[u8] = b"celfx past 1\n";

/// The folder.
#[derive(Clone, Debug)]
pub(super) struct Cache {
    folder: PathBuf,
}

impl Cache {
    pub(super) fn new(folder: &Path) -> Cache {
        Cache { folder: folder.into() }
    }

    /// Whether what the n-th frame leaves, from 1, is kept.
    pub(super) fn keeps(n: u32) -> bool {
        n.is_multiple_of(EVERY)
    }

    fn path(&self, key: u128) -> PathBuf {
        self.folder.join(format!("{key:032x}.past"))
    }

    /// What a frame left; none if it is not there or damaged.
    pub(super) fn read(&self, key: u128) -> Option<Vec<u8>> {
        let bytes = fs::read(self.path(key)).ok()?;
        let (hash, past) = bytes.strip_prefix(HEAD)?.split_first_chunk::<16>()?;
        (u128::from_le_bytes(*hash) == xxh3_128(past)).then(|| past.to_vec())
    }

    /// Keeps what a frame left.
    pub(super) fn write(&self, key: u128, past: &[u8]) -> Result<(), WriteError> {
        let (path, hash) = (self.path(key), xxh3_128(past).to_le_bytes());
        remove_stale_parts([path.clone()]);
        write_atomic(&path, |file| [HEAD, &hash, past].into_iter().try_for_each(|part| file.write_all(part)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;

    #[test]
    fn what_is_damaged_is_not_there() {
        let folder = Folder::new();
        let cache = Cache::new(&folder.0.join("cache"));
        assert_eq!(cache.read(7), None);
        let past: Vec<u8> = (0..=255).collect();
        cache.write(7, &past).expect("written");
        assert_eq!(cache.read(7), Some(past));
        let path = cache.path(7);
        let whole = fs::read(&path).expect("written");
        for length in 0..whole.len() {
            fs::write(&path, &whole[..length]).expect("temporary folder");
            assert_eq!(cache.read(7), None, "{length} bytes");
        }
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            fs::write(&path, changed).expect("temporary folder");
            assert_eq!(cache.read(7), None, "byte {at}");
        }
    }
}
