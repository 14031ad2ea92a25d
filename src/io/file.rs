//! Files as such: regular ones alone are opened; which one a path means, and whether it is still what it was.

use std::fs::{self, File, FileType, Metadata};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;

use xxhash_rust::xxh3::Xxh3;

use super::ReadError;

/// Opens a regular file for reading. A folder, pipe, socket or device is an error before it is opened: a pipe would wait
/// for somebody to write, and a device need never end.
pub(super) fn open(path: &Path) -> io::Result<File> {
    check(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    // It may have been replaced in between.
    check(&file.metadata()?)?;
    Ok(file)
}

/// The bytes of a regular file, at most `most` of them and no more than it has when it is opened.
pub(super) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let size = file.metadata()?.len().min(most);
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(size).map_err(io::Error::other)?)?;
    file.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn check(found: &Metadata) -> io::Result<()> {
    match found.is_file() {
        true => Ok(()),
        false => {
            Err(io::Error::new(io::ErrorKind::InvalidInput, format!("is {}, not a file", kind(found.file_type()))))
        }
    }
}

#[cfg(unix)]
fn kind(of: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if of.is_dir() => "a folder",
        () if of.is_fifo() => "a pipe",
        () if of.is_socket() => "a socket",
        () => "a device",
    }
}

#[cfg(not(unix))]
fn kind(of: FileType) -> &'static str {
    if of.is_dir() { "a folder" } else { "a device" }
}

/// Which file it is, whatever path leads to it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Identity(#[cfg(unix)] [u64; 2], #[cfg(not(unix))] PathBuf);

impl Identity {
    /// That of the file at `path`, links followed; none if there is no such file.
    pub fn of(path: &Path) -> Option<Identity> {
        Identity::new(path, &fs::metadata(path).ok()?).ok()
    }

    #[cfg(unix)]
    fn new(_: &Path, metadata: &Metadata) -> io::Result<Identity> {
        use std::os::unix::fs::MetadataExt;
        Ok(Identity([metadata.dev(), metadata.ino()]))
    }

    #[cfg(not(unix))]
    fn new(path: &Path, _: &Metadata) -> io::Result<Identity> {
        fs::canonicalize(path).map(Identity)
    }
}

/// The state of a file that changes when it is written or replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stamp {
    file: Identity,
    size: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    /// That of the file at `path` now.
    ///
    /// # Errors
    /// There is no such file.
    pub fn of(path: &Path) -> Result<Stamp, ReadError> {
        let stamp = || {
            let metadata = fs::metadata(path)?;
            let file = Identity::new(path, &metadata)?;
            io::Result::Ok(Stamp { file, size: metadata.len(), modified: metadata.modified().ok() })
        };
        stamp().map_err(|error| ReadError::file(path, error, "a file that can be read"))
    }

    /// An error if the file at `path` is not as it was.
    pub fn check(&self, path: &Path) -> Result<(), ReadError> {
        match Stamp::of(path)? == *self {
            true => Ok(()),
            false => {
                let expected = "a file that stays as it is while frames are made from it";
                Err(ReadError::file(path, "was written or replaced after it was first looked at", expected))
            }
        }
    }
}

/// A hash of what is in the file at `path`: the same on every machine, XXH3 of 128 bits.
///
/// # Errors
/// There is no such file, it is a pipe or the like, or it cannot be read.
pub fn digest(path: &Path) -> Result<u128, ReadError> {
    let read = || {
        let mut file = open(path)?;
        let mut hash = Xxh3::new();
        let mut block = vec![0; 1 << 18];
        loop {
            match file.read(&mut block) {
                Ok(0) => return Ok(hash.digest128()),
                Ok(count) => hash.update(&block[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    };
    read().map_err(|error| ReadError::file(path, error, "a file that can be read"))
}

/// The path of a folder without links, `.` and `..`; what of it is not there yet is taken as it is written.
pub fn resolved(folder: &Path) -> PathBuf {
    let mut found = std::env::current_dir().unwrap_or_default();
    for component in folder.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                found.pop();
            }
            Component::Prefix(_) | Component::RootDir => found.push(component),
            Component::Normal(name) => {
                found.push(name);
                found = fs::canonicalize(&found).unwrap_or(found);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;

    #[cfg(unix)]
    #[test]
    fn a_file_is_one_by_all_of_its_names() {
        let folder = Folder::new();
        let path = |name: &str| folder.0.join(name);
        fs::create_dir(path("a")).unwrap();
        fs::write(path("a/file"), "x").unwrap();
        fs::write(path("a/other"), "x").unwrap();
        fs::hard_link(path("a/file"), path("hard")).unwrap();
        std::os::unix::fs::symlink("a/file", path("soft")).unwrap();
        let file = Identity::of(&path("a/file"));
        assert!(file.is_some());
        for name in ["hard", "soft", "a/../a/./file"] {
            assert_eq!(Identity::of(&path(name)), file, "{name}");
        }
        assert_ne!(Identity::of(&path("a/other")), file);
        assert_eq!(Identity::of(&path("none")), None);
    }

    #[cfg(unix)]
    #[test]
    fn folders_are_found_whether_they_are_there_or_not() {
        let folder = Folder::new();
        let real = fs::canonicalize(&folder.0).unwrap();
        fs::create_dir_all(folder.0.join("a/b")).unwrap();
        std::os::unix::fs::symlink("a/b", folder.0.join("link")).unwrap();
        for (name, found) in [
            ("a/./b", "a/b"),
            ("link", "a/b"),
            // The folder above what the link leads to.
            ("link/..", "a"),
            ("link/new/sub", "a/b/new/sub"),
            ("new/../a", "a"),
            ("new/./sub/..", "new"),
        ] {
            assert_eq!(resolved(&folder.0.join(name)), real.join(found), "{name}");
        }
        assert_eq!(resolved(Path::new("")), fs::canonicalize(".").unwrap());
        assert_eq!(resolved(Path::new("new")), fs::canonicalize(".").unwrap().join("new"));
    }

    #[test]
    fn contents_have_one_hash_wherever_they_are() {
        let folder = Folder::new();
        let path = folder.0.join("file");
        fs::write(&path, "").unwrap();
        // The reference implementation's hash of nothing.
        assert_eq!(digest(&path).unwrap(), 0x99aa_06d3_0147_98d8_6001_c324_468d_497f);
        let hash_of = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            digest(&path).unwrap()
        };
        let mut bytes = vec![7; 600_000];
        let whole = hash_of(&bytes);
        assert_eq!(hash_of(&bytes), whole);
        bytes[599_999] = 8;
        assert_ne!(hash_of(&bytes), whole);
        for wrong in [folder.0.join("none"), folder.0.clone()] {
            assert!(digest(&wrong).unwrap_err().to_string().contains("expected a file that can be read"));
        }
    }

    #[test]
    fn a_file_that_changes_is_noticed() {
        let folder = Folder::new();
        let path = folder.0.join("file");
        fs::write(&path, "one").unwrap();
        let stamp = Stamp::of(&path).unwrap();
        assert!(stamp.check(&path).is_ok());
        fs::write(&path, "three").unwrap();
        let error = stamp.check(&path).unwrap_err().to_string();
        assert!(error.contains("file: was written or replaced"), "{error}");
        fs::remove_file(&path).unwrap();
        assert!(stamp.check(&path).is_err() && Stamp::of(&path).is_err());
    }

    #[test]
    fn a_file_is_read_as_far_as_is_asked() {
        let folder = Folder::new();
        let path = folder.0.join("a.bin");
        fs::write(&path, b"abcdef").unwrap();
        assert_eq!(read(&path, u64::MAX).unwrap(), b"abcdef");
        assert_eq!(read(&path, 2).unwrap(), b"ab");
        assert_eq!(open(&folder.0.join("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn what_is_no_file_is_named() {
        let folder = Folder::new();
        let says = |path: &Path, what: &str| {
            let error = open(path).unwrap_err().to_string();
            assert!(error.contains(what) && error.contains("not a file"), "{error}");
        };
        says(&folder.0, "a folder");
        #[cfg(unix)]
        {
            says(Path::new("/dev/zero"), "a device");
            let link = folder.0.join("link");
            std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
            says(&link, "a device");
            let socket = folder.0.join("socket");
            let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
            says(&socket, "a socket");
        }
    }
}
