//! Readers and writers of the files that users have.
//!
//! Every writer is atomic: a file appears whole or not at all (see [`write_atomic`]).

use std::borrow::Cow;
use std::collections::HashMap;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use xxhash_rust::xxh3::xxh3_64;

pub mod array;
pub mod display;
pub mod file;
pub mod image;
pub mod overlap;
mod palette;
pub mod particles;
pub mod passes;
pub mod pattern;
pub mod picture;
pub mod scene;
pub mod sequence;
pub mod shot;
pub mod vdb;
pub mod volume;

/// A file that could not be read (exit code 3).
#[derive(Debug, thiserror::Error)]
#[error("{}: {}{why}; expected {expected}", path.display(), if place.is_empty() { String::new() } else { format!("{place}: ") })]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Where in it: the array, byte or row; empty where it is the file as a whole.
    pub place: String,
    /// The fault.
    pub why: String,
    /// The expected content.
    pub expected: String,
}

impl ReadError {
    /// A fault of the file as a whole.
    pub fn file(path: &Path, why: impl ToString, expected: impl Into<String>) -> ReadError {
        ReadError { path: path.into(), place: String::new(), why: why.to_string(), expected: expected.into() }
    }

    /// A fault at one place (array, byte or row) of the file.
    pub fn at(path: &Path, place: impl Into<String>, why: impl ToString, expected: impl Into<String>) -> ReadError {
        ReadError { path: path.into(), place: place.into(), why: why.to_string(), expected: expected.into() }
    }
}

/// A file that could not be written (exit code 6). Nothing of it is left.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// The error.
    pub source: io::Error,
}

/// Writes `path` so that it appears whole or not at all: into a hidden file `.NAME.UNIQUE.PID.part` beside it, synced, then
/// renamed; where NAME is long, that of the hidden file has a hash of it in its place. Folders that are missing are made, a
/// file of that name is replaced, and a `.part` that a killed run left behind does not disturb (see [`remove_stale_parts`]). On an error the `.part` is removed and what was at `path` stays.
pub fn write_atomic(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), WriteError> {
    make_atomic(path, |part| fill(part, write))
}

/// As [`write_atomic`], of a file that somebody else writes at the path that `make` is given.
pub fn make_atomic(path: &Path, make: impl FnOnce(&Path) -> io::Result<()>) -> Result<(), WriteError> {
    make_atomic_io(path, make).map_err(|source| WriteError { path: path.into(), source })
}

fn make_atomic_io(path: &Path, make: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    let part = begin(path)?;
    let result = make(&part).and_then(|()| fs::rename(&part, path));
    if result.is_err() {
        // The first error is the one to report, whether or not there was anything to remove.
        let _ = fs::remove_file(&part);
        return result;
    }
    // Makes the rename durable too; not every file system can sync a folder, and the file itself is safe by now.
    let _ = File::open(folder_of(path)).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Whether [`write_atomic`] could write `path`: its folder is made, and a file beside it is written and removed.
pub fn probe(path: &Path) -> Result<(), WriteError> {
    let probe = || {
        let part = begin(path)?;
        // The folder is there: all that may be missing is the file. Anything else would show only after the rendering,
        // such as a name that is too long, or a folder that may not be looked into.
        match fs::symlink_metadata(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let written = fill(&part, |_| Ok(()));
        // The first error is the one to report.
        let removed = fs::remove_file(&part);
        written.and(removed)
    };
    probe().map_err(|source| WriteError { path: path.into(), source })
}

/// Makes the folder of `path` and returns the `.part` beside it; an error where there is no room for a plain file.
fn begin(path: &Path) -> io::Result<PathBuf> {
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path does not end in a file name"));
    };
    // A rename would put a plain file in the place of a device or pipe such as /dev/null.
    if fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, "there is something of that name that is not a file"));
    }
    fs::create_dir_all(folder_of(path))?;
    // Other machines may have a process of the same number.
    static UNIQUE: LazyLock<u64> = LazyLock::new(|| RandomState::new().hash_one(0));
    let process = std::process::id();
    Ok(beside(path, name, &format!("{:08x}.{process}.part", *UNIQUE as u32)))
}

/// The hidden file beside `path`, which ends in a file name, that ends in `.KIND`.
pub fn hidden(path: &Path, kind: &str) -> PathBuf {
    beside(path, path.file_name().unwrap_or_default(), kind)
}

fn beside(path: &Path, name: &OsStr, end: &str) -> PathBuf {
    let mut file = OsString::from(".");
    file.push(stem(name));
    file.push(".");
    file.push(end);
    folder_of(path).join(file)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Stand-in for a file's name in that of its `.part`, which is longer and must not be too long where the name is not.
fn stem(name: &OsStr) -> Cow<'_, OsStr> {
    const LONGEST: usize = 100;
    match name.as_encoded_bytes() {
        bytes if bytes.len() > LONGEST => Cow::Owned(format!("{:016x}", xxh3_64(bytes)).into()),
        _ => Cow::Borrowed(name),
    }
}

fn fill(part: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    match fs::remove_file(part) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut writer = BufWriter::with_capacity(1 << 18, File::create_new(part)?);
    write(&mut writer)?;
    writer.flush()?;
    writer.get_ref().sync_all()
}

/// Removes what killed runs left of [`write_atomic`] to any of `paths`: every `.NAME.UNIQUE.PID.part` whose process is gone.
/// Other processes that write the same files keep theirs. Nothing is removed where processes cannot be looked up (no
/// `/proc`), and what cannot be removed stays.
pub fn remove_stale_parts(paths: impl IntoIterator<Item = PathBuf>) {
    if !Path::new("/proc/self").exists() {
        return;
    }
    let mut folders: HashMap<PathBuf, Parts> = HashMap::new();
    for path in paths {
        let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { continue };
        let parts = match folders.get_mut(folder) {
            Some(parts) => parts,
            None => folders.entry(folder.into()).or_insert_with(|| stale_parts(folder)),
        };
        for part in parts.remove(stem(name).as_encoded_bytes()).unwrap_or_default() {
            // It was half a file that nobody will finish; the next run tries again.
            let _ = fs::remove_file(part);
        }
    }
}

/// Parts by the [`stem`] of the file that they were to become.
type Parts = HashMap<Vec<u8>, Vec<PathBuf>>;

/// The parts in a folder whose process is gone.
fn stale_parts(folder: &Path) -> Parts {
    let mut parts = Parts::new();
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let file = entry.file_name();
        let Some((stem, process)) = part_of(file.as_encoded_bytes()) else { continue };
        if !Path::new(&format!("/proc/{process}")).exists() {
            parts.entry(stem.to_owned()).or_default().push(entry.path());
        }
    }
    parts
}

/// Stem and process of a `.STEM.UNIQUE.PID.part`.
fn part_of(file: &[u8]) -> Option<(&[u8], u32)> {
    let mut parts = file.strip_prefix(b".")?.strip_suffix(b".part")?.rsplitn(3, |byte| *byte == b'.');
    let process = std::str::from_utf8(parts.next()?).ok()?.parse().ok()?;
    let _unique = parts.next()?;
    Some((parts.next()?, process))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// An empty folder of a test's own, removed at its end.
    pub(crate) struct Folder(pub PathBuf);

    impl Folder {
        pub(crate) fn new() -> Folder {
            static COUNT: AtomicU32 = AtomicU32::new(0);
            let name = format!("celfx-test-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
            let path = std::env::temp_dir().join(name);
            fs::create_dir_all(&path).unwrap();
            Folder(path)
        }

        pub(crate) fn names(&self) -> Vec<String> {
            let mut names: Vec<_> =
                fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_written_file_is_whole_and_alone() {
        let folder = Folder::new();
        let path = folder.0.join("a/b/frame.bin");
        write_atomic(&path, |w| w.write_all(b"one")).unwrap();
        write_atomic(&path, |w| w.write_all(b"two")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_failing_write_leaves_what_was_there() {
        let folder = Folder::new();
        let path = folder.0.join("frame.bin");
        let fails = |w: &mut BufWriter<File>| {
            w.write_all(&[7; 1 << 20])?;
            Err(io::Error::other("disk on fire"))
        };
        let error = write_atomic(&path, fails).unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write {}: disk on fire", path.display()));
        assert!(folder.names().is_empty(), "{:?}", folder.names());
        fs::write(&path, b"old").unwrap();
        write_atomic(&path, fails).unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(folder.names(), ["frame.bin"]);
    }

    #[test]
    fn stale_parts_do_not_disturb() {
        let folder = Folder::new();
        let own = begin(&folder.0.join("frame.bin")).unwrap();
        let stale = folder.0.join(".frame.bin.0.1.part");
        for stale in [&stale, &own] {
            fs::write(stale, b"half a frame, longer than the new one").unwrap();
        }
        write_atomic(&folder.0.join("frame.bin"), |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(folder.0.join("frame.bin")).unwrap(), b"new");
        assert_eq!(folder.names(), [".frame.bin.0.1.part", "frame.bin"]);
    }

    #[test]
    fn parts_of_processes_that_are_gone_are_removed() {
        if !Path::new("/proc/self").exists() {
            return;
        }
        let folder = Folder::new();
        let mut ended = std::process::Command::new("true").spawn().unwrap();
        ended.wait().unwrap();
        let (gone, own) = (ended.id(), std::process::id());
        let kept = [
            format!(".1.png.0.{own}.part"),
            ".1.png.part".into(),
            ".1.png.0.x.part".into(),
            format!(".10.png.0.{gone}.part"),
            "1.png".into(),
            format!("1.png.0.{gone}.part"),
        ];
        let long = "long".repeat(60);
        let stem = stem(OsStr::new(&long)).into_owned().into_string().unwrap();
        let removed = [".1.png.", ".2.png.", &format!(".{stem}.")].map(|part| format!("{part}0.{gone}.part"));
        kept.iter().chain(&removed).for_each(|name| fs::write(folder.0.join(name), b"half").unwrap());
        remove_stale_parts(["1.png", "2.png", "3.png", &long, "no folder/1.png"].map(|name| folder.0.join(name)));
        let mut kept = kept;
        kept.sort();
        assert_eq!(folder.names(), kept);
    }

    #[test]
    fn a_name_may_be_as_long_as_the_file_system_allows() {
        let folder = Folder::new();
        // What most file systems take, in bytes.
        let longest = "n".repeat(251) + ".png";
        for name in [&longest[..], &longest[150..]] {
            probe(&folder.0.join(name)).unwrap();
            assert!(folder.names().is_empty());
            write_atomic(&folder.0.join(name), |w| w.write_all(b"x")).unwrap();
            assert_eq!(folder.names(), [name]);
            fs::remove_file(folder.0.join(name)).unwrap();
        }
        // Also where its folder is not there yet.
        for name in [format!("a{longest}"), format!("new/a{longest}")] {
            let error = probe(&folder.0.join(&name)).unwrap_err().to_string();
            assert!(error.contains(&name), "{error}");
        }
        assert_eq!(folder.names(), ["new"]);
    }

    #[test]
    fn impossible_targets_are_named() {
        let folder = Folder::new();
        let target = folder.0.join("taken");
        fs::create_dir(&target).unwrap();
        let error = write_atomic(&target, |w| w.write_all(b"x")).unwrap_err();
        assert!(error.to_string().contains("taken"), "{error}");
        fs::write(folder.0.join("file"), b"").unwrap();
        let error = write_atomic(&folder.0.join("file/inside.png"), |w| w.write_all(b"x")).unwrap_err();
        assert!(error.to_string().contains("inside.png"), "{error}");
        assert!(write_atomic(Path::new("/"), |w| w.write_all(b"x")).is_err());
        assert_eq!(folder.names(), ["file", "taken"]);
    }
}
