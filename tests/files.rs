//! Picture files and archives that lie, are damaged, or are written as others write them.
#![cfg(feature = "cli")]

#[path = "files/peak.rs"]
mod peak;
#[path = "files/pictures.rs"]
mod pictures;
#[path = "files/windows.rs"]
mod windows;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use celfx::io::array::Archive;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A file of a test's own, removed at its end.
pub struct Temporary(PathBuf);

impl Temporary {
    /// One of that kind.
    pub fn new(extension: &str) -> Temporary {
        use std::sync::atomic::{AtomicU32, Ordering};
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Temporary(std::env::temp_dir().join(format!("celfx-files-{}-{number}.{extension}", std::process::id())))
    }

    /// Its path, as it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Its path, with these bytes in it.
    pub fn with(&self, bytes: &[u8]) -> &Path {
        fs::write(&self.0, bytes).expect("temporary folder");
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// An archive of few bytes whose array has many is looked through in little memory.
#[test]
fn an_array_that_unpacks_to_much_is_streamed() {
    let file = Temporary::new("npz");
    let mut npz = ZipWriter::new(fs::File::create(&file.0).expect("temporary folder"));
    npz.start_file("a.npy", SimpleFileOptions::DEFAULT).expect("an entry");
    let count = 64 << 20;
    let header = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({count},), }}\n");
    let mut entry = b"\x93NUMPY\x01\x00".to_vec();
    entry.extend((header.len() as u16).to_le_bytes());
    entry.extend(header.as_bytes());
    npz.write_all(&entry).expect("a header");
    let zeros = vec![0; 1 << 20];
    (0..count >> 20).for_each(|_| npz.write_all(&zeros).expect("data"));
    npz.finish().expect("an archive");
    let mut archive = Archive::open(&file.0).expect("an archive");
    let (peak, sum) = peak::of(|| {
        let (mut sum, mut seen) = (0.0, 0);
        archive.each("a", |value: f64| (sum, seen) = (sum + value, seen + 1)).expect("an array");
        (sum, seen)
    });
    assert_eq!(sum, (0.0, count));
    // A buffer, and what the decoder of the archive needs.
    assert!(peak < 1 << 20, "{peak} bytes");
}
