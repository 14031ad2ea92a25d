//! Memory that is not there: the program says so and ends, instead of being aborted.
//!
//! Few of the many places that ask for memory can go on without it, and those are in other crates as often as here. So the
//! program's allocator ends it where the system has no more. Nothing is lost: files that were not finished are `.part`
//! files, which the next run removes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::{Cursor, Write};

use super::Failure;

thread_local! {
    /// What this thread does, and the number of the frame that it does it to.
    static DOING: Cell<(&'static str, Option<u32>)> = const { Cell::new(("", None)) };
}

/// From now on this thread is `what`: "rendering frame", and which one.
pub(super) fn doing(what: &'static str, frame: Option<u32>) {
    DOING.set((what, frame));
}

/// The system's allocator for a program that cannot go on without memory: where there is none, it says what it did and
/// ends with exit code 5, which also leaves the drivers as they are.
#[derive(Debug)]
pub struct Memory;

// SAFETY: the system's allocator does all of it. The program ends without unwinding and without asking for memory.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        or_end(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        or_end(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's.
        or_end(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's.
        unsafe { System.dealloc(memory, layout) }
    }
}

fn or_end(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() {
        end(bytes);
    }
    memory
}

#[cold]
fn end(bytes: usize) {
    let mut text = [0; 256];
    // A thread that is ending does nothing that has a name.
    let length = message(&mut text, DOING.try_with(Cell::get).unwrap_or_default(), bytes);
    #[cfg(unix)]
    // SAFETY: the text is as long as that, and ending at once needs nothing of the rest of the program.
    unsafe {
        libc::write(2, text.as_ptr().cast(), length);
        libc::_exit(i32::from(Failure::DEVICE));
    }
    #[cfg(not(unix))]
    {
        // Elsewhere the standard library says how many bytes there were none of, and aborts.
        let _ = (length, Failure::DEVICE);
    }
}

/// Writes what is said into `text`; returns how long it is.
fn message(text: &mut [u8], (what, frame): (&str, Option<u32>), bytes: usize) -> usize {
    let mut text = Cursor::new(text);
    let mut say = || -> std::io::Result<()> {
        write!(text, "celfx: out of memory")?;
        match (what, frame) {
            ("", _) => {}
            (what, None) => write!(text, " while {what}")?,
            (what, Some(frame)) => write!(text, " while {what} {frame}")?,
        }
        writeln!(text, ": {bytes} bytes could not be had; a smaller shot needs less, or allow more")
    };
    // What is too long is cut.
    let _ = say();
    text.position() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_said_what_there_was_no_memory_for() {
        let said = |doing, bytes| {
            let mut text = [0; 256];
            let length = message(&mut text, doing, bytes);
            String::from_utf8_lossy(&text[..length]).into_owned()
        };
        let rest = ": 7 bytes could not be had; a smaller shot needs less, or allow more\n";
        assert_eq!(said(("", None), 7), format!("celfx: out of memory{rest}"));
        assert_eq!(said(("reading the shot", None), 7), format!("celfx: out of memory while reading the shot{rest}"));
        assert_eq!(said(("writing frame", Some(3)), 7), format!("celfx: out of memory while writing frame 3{rest}"));
        assert!(said(("rendering frame", Some(u32::MAX)), usize::MAX).ends_with("allow more\n"), "it fits");
    }
}
