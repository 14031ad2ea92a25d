//! Handles of objects that are nowhere: for checks that come before any call of Vulkan.

use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

/// A handle unlike all others; with one of them, any call of Vulkan would end the test.
pub fn handle<T: vk::Handle>() -> T {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    T::from_raw(NEXT.fetch_add(1, Ordering::Relaxed))
}
