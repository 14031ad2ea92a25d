//! Reading a file's bytes in order; whatever is wrong names the byte.

use std::path::Path;

use bytemuck::{AnyBitPattern, NoUninit};

use crate::io::ReadError;

/// Most bytes of a name; real ones have a few dozen.
const LONGEST_NAME: u32 = 4096;

/// A place in a part of a file in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'f> {
    pub(super) path: &'f Path,
    /// What is left of it, and where in the file that begins.
    left: &'f [u8],
    at: u64,
}

impl<'f> Bytes<'f> {
    /// Of a part that begins at a byte of the file.
    pub(super) fn new(path: &'f Path, part: &'f [u8], at: u64) -> Bytes<'f> {
        Bytes { path, left: part, at }
    }

    /// The byte of the file that is read next.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// A fault of what is read next.
    pub(super) fn fault(&self, why: impl ToString, expected: impl Into<String>) -> ReadError {
        ReadError::at(self.path, format!("byte {}", self.at), why, expected)
    }

    pub(super) fn take(&mut self, count: usize, what: &str) -> Result<&'f [u8], ReadError> {
        let Some((taken, left)) = self.left.split_at_checked(count) else {
            let why = format!("ends after {} of {count} bytes of {what}", self.left.len());
            return Err(self.fault(why, "all of them: it is cut off, or damaged"));
        };
        (self.left, self.at) = (left, self.at + count as u64);
        Ok(taken)
    }

    /// A value as it stands; files are little-endian, and so is every machine that this runs on.
    pub(super) fn value<T: AnyBitPattern + NoUninit>(&mut self, what: &str) -> Result<T, ReadError> {
        Ok(bytemuck::pod_read_unaligned(self.take(size_of::<T>(), what)?))
    }

    /// Text: its length, then its bytes.
    pub(super) fn text(&mut self, what: &str) -> Result<String, ReadError> {
        let length: u32 = self.value(what)?;
        if length > LONGEST_NAME {
            return Err(self.fault(format!("{what} has {length} bytes"), format!("{LONGEST_NAME} at most")));
        }
        Ok(String::from_utf8_lossy(self.take(length as usize, what)?).into_owned())
    }
}
