//! Budget of a file: bounds of memory and work that follow from its size, for a small file can ask for anything.

use std::cell::Cell;
use std::path::Path;

use crate::io::ReadError;

/// Memory that any file may take, in bytes.
const FLOOR: u64 = 1 << 28;

/// Times its own size that a larger file may take.
const TIMES: u64 = 24;

/// Times the memory's limit that may be read and made on the way.
const WORK: u64 = 4;

/// An account of what a file becomes.
pub(super) struct Budget<'a> {
    path: &'a Path,
    /// Bytes of the file and of those that it names, each once.
    size: Cell<u64>,
    kept: Cell<u64>,
    worked: Cell<u64>,
}

impl<'a> Budget<'a> {
    pub(super) fn new(path: &'a Path, size: usize) -> Budget<'a> {
        Budget { path, size: Cell::new(size as u64), kept: Cell::new(0), worked: Cell::new(0) }
    }

    /// Another file of so many bytes belongs to it.
    pub(super) fn extend(&self, bytes: u64) {
        self.size.set(self.size.get().saturating_add(bytes));
    }

    fn limit(&self) -> u64 {
        self.size.get().saturating_mul(TIMES).max(FLOOR)
    }

    /// Accounts for bytes that stay; asked before they are allocated. `what` is what takes them, for the error.
    pub(super) fn keep(&self, place: &str, what: &str, bytes: u64) -> Result<(), ReadError> {
        let total = self.kept.get().saturating_add(bytes);
        self.check(place, &format!("{what} would bring what is in memory"), total, self.limit())?;
        self.kept.set(total);
        Ok(())
    }

    /// Accounts for bytes that are looked at or made on the way and go again; asked before they are allocated.
    pub(super) fn work(&self, place: &str, what: &str, bytes: u64) -> Result<(), ReadError> {
        let at_once = self.kept.get().saturating_add(bytes);
        self.check(place, &format!("{what} would bring what is in memory"), at_once, self.limit())?;
        let total = self.worked.get().saturating_add(bytes);
        self.check(
            place,
            &format!("{what} would bring what is read and made"),
            total,
            self.limit().saturating_mul(WORK),
        )?;
        self.worked.set(total);
        Ok(())
    }

    fn check(&self, place: &str, why: &str, total: u64, limit: u64) -> Result<(), ReadError> {
        if total <= limit {
            return Ok(());
        }
        let expected = format!("{limit} bytes at most of files that have {}", self.size.get());
        Err(ReadError::at(self.path, place, format!("{why} to {total} bytes"), expected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_follows_the_size_of_the_files() {
        let budget = Budget::new(Path::new("a.gltf"), 1000);
        budget.keep("a", "b", FLOOR).unwrap();
        let error = budget.keep("node 3", "5 weights", 40).unwrap_err().to_string();
        let expected = "a.gltf: node 3: 5 weights would bring what is in memory to 268435496 bytes; \
            expected 268435456 bytes at most of files that have 1000";
        assert_eq!(error, expected);
        assert!(budget.work("a", "b", 1).is_err(), "what goes again has to fit beside what stays");
        budget.extend(FLOOR);
        budget.keep("a", "b", (TIMES - 1) * FLOOR).unwrap();
        budget.keep("a", "b", u64::MAX).unwrap_err();
    }

    #[test]
    fn work_has_a_limit_of_its_own() {
        let budget = Budget::new(Path::new("a.gltf"), 1);
        (0..WORK).for_each(|_| budget.work("a", "b", FLOOR).unwrap());
        let error = budget.work("accessor 1", "2 values", 48).unwrap_err().to_string();
        assert!(error.contains("accessor 1: 2 values would bring what is read and made to"), "{error}");
        budget.keep("a", "b", FLOOR).unwrap();
    }
}
