//! The most bytes of heap that a piece of work holds at once.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Measuring;

thread_local! {
    /// Bytes of this thread now, and the most there were.
    static HELD: Cell<[isize; 2]> = const { Cell::new([0; 2]) };
}

/// The most bytes that this thread held during `work`, beyond those before, and what it gives.
pub fn of<T>(work: impl FnOnce() -> T) -> (isize, T) {
    let before = HELD.get()[0];
    HELD.set([before; 2]);
    let result = work();
    (HELD.get()[1] - before, result)
}

fn add(bytes: isize) {
    // Nothing is measured while a thread ends.
    let _ = HELD.try_with(|held| {
        let [now, most] = held.get();
        held.set([now + bytes, most.max(now + bytes)]);
    });
}

// SAFETY: the system's allocator does all of it.
unsafe impl GlobalAlloc for Measuring {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as isize);
        // SAFETY: the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as isize);
        // SAFETY: the caller's.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size as isize - layout.size() as isize);
        // SAFETY: the caller's.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        add(-(layout.size() as isize));
        // SAFETY: the caller's.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Measuring = Measuring;
