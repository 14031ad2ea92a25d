//! Memory that is not there: the program says so and ends, instead of being aborted.
//!
//! Few of the many places that ask for memory can go on without it, and those are in other crates as often as here. So the
//! program's allocator ends it where the system has no more. Nothing is lost: files that were not finished are `.part`
//! files, which the next run removes.
//!
//! Drivers are less careful: some abort where there is no memory, or use what they did not get. Where the address space is
//! limited, that is taken for what it most likely is.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::{Cursor, Write};

#[cfg(unix)]
use super::Failure;

thread_local! {
    /// The work of this thread, and the number of the frame that it does it to.
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
    let why = Why::NoMemory { bytes };
    #[cfg(unix)]
    limit::end(why);
    // Elsewhere the standard library says how many bytes there were none of, and aborts.
    #[cfg(not(unix))]
    let _ = why;
}

/// The limit of the address space, in MiB, if there is one (`ulimit -v`).
pub(super) fn limit() -> Option<u64> {
    #[cfg(unix)]
    return limit::mebibytes();
    #[cfg(not(unix))]
    None
}

/// From now on the program ends with a word and an exit code where a driver aborts under a limit of the address space.
pub(super) fn name_aborts() {
    #[cfg(unix)]
    limit::name_aborts();
}

#[cfg(unix)]
mod limit {
    use super::{Cell, DOING, Failure, Why, message};

    pub(super) fn mebibytes() -> Option<u64> {
        let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
        // SAFETY: it is written to and not kept.
        let found = unsafe { libc::getrlimit(libc::RLIMIT_AS, &mut limit) } == 0;
        (found && limit.rlim_cur != libc::RLIM_INFINITY).then_some(limit.rlim_cur >> 20)
    }

    pub(super) fn name_aborts() {
        if mebibytes().is_none() {
            return;
        }
        let handler: extern "C" fn(libc::c_int) = aborted;
        for signal in [libc::SIGABRT, libc::SIGSEGV, libc::SIGBUS] {
            // SAFETY: the handler calls nothing that a handler must not.
            unsafe { libc::signal(signal, handler as libc::sighandler_t) };
        }
    }

    extern "C" fn aborted(signal: libc::c_int) {
        end(Why::Aborted { signal, mebibytes: mebibytes().unwrap_or(0) });
    }

    /// Says why and ends at once.
    pub(super) fn end(why: Why) {
        let mut text = [0; 320];
        // A thread that is ending does nothing that has a name.
        let length = message(&mut text, DOING.try_with(Cell::get).unwrap_or_default(), why);
        // SAFETY: the text is as long as that, and ending at once needs nothing of the rest of the program.
        unsafe {
            libc::write(2, text.as_ptr().cast(), length);
            libc::_exit(i32::from(Failure::DEVICE));
        }
    }
}

/// Why the program ends.
#[derive(Clone, Copy)]
enum Why {
    /// There are not so many bytes.
    NoMemory { bytes: usize },
    /// A driver or a library gave up.
    #[cfg_attr(not(unix), expect(dead_code))]
    Aborted { signal: i32, mebibytes: u64 },
}

/// Writes what is said into `text`, without asking for memory; returns how long it is.
fn message(text: &mut [u8], (what, frame): (&str, Option<u32>), why: Why) -> usize {
    let mut text = Cursor::new(text);
    let mut say = || -> std::io::Result<()> {
        write!(text, "celfx: out of memory")?;
        match (what, frame) {
            ("", _) => {}
            (what, None) => write!(text, " while {what}")?,
            (what, Some(frame)) => write!(text, " while {what} {frame}")?,
        }
        match why {
            Why::NoMemory { bytes } => write!(text, ": {bytes} bytes could not be had")?,
            Why::Aborted { signal, mebibytes } => write!(
                text,
                ", as it seems: signal {signal} of a driver or a library, and the address space is limited to \
                 {mebibytes} MiB (ulimit -v)"
            )?,
        }
        writeln!(text, "; a smaller shot needs less, or allow more")
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
        let say = |doing, why| {
            let mut text = [0; 320];
            let length = message(&mut text, doing, why);
            String::from_utf8_lossy(&text[..length]).into_owned()
        };
        let said = |doing, bytes| say(doing, Why::NoMemory { bytes });
        let rest = ": 7 bytes could not be had; a smaller shot needs less, or allow more\n";
        assert_eq!(said(("", None), 7), format!("celfx: out of memory{rest}"));
        assert_eq!(said(("reading the shot", None), 7), format!("celfx: out of memory while reading the shot{rest}"));
        assert_eq!(said(("writing frame", Some(3)), 7), format!("celfx: out of memory while writing frame 3{rest}"));
        let longest = ("reading the input of frame", Some(u32::MAX));
        for why in [Why::NoMemory { bytes: usize::MAX }, Why::Aborted { signal: i32::MIN, mebibytes: u64::MAX }] {
            assert!(say(longest, why).ends_with("allow more\n"), "it fits");
        }
        assert!(say(longest, Why::Aborted { signal: 11, mebibytes: 500 }).contains("signal 11"));
    }
}
