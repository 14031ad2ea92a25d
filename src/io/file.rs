//! Opening the files that users name: regular ones only.

use std::fs::{self, File, FileType, Metadata};
use std::io::{self, Read};
use std::path::Path;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;

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
