//! Decoders of others, which are made for good files and panic on some bad ones.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread is within [`contained`].
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder. A panic in it, which is a fault of the file that it does not expect, becomes an error, and prints
/// nothing. Sizes are to be checked before: an allocation that fails cannot be caught.
pub(in crate::io) fn contained<T>(decode: impl FnOnce() -> T) -> Result<T, &'static str> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !CONTAINED.get() {
                usual(panic);
            }
        }));
    });
    CONTAINED.set(true);
    // Whatever a panic leaves half done is dropped with the decoder.
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    CONTAINED.set(false);
    result.map_err(|_| "is damaged in a way that its decoder does not expect")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_and_the_thread_goes_on() {
        assert_eq!(contained(|| 3), Ok(3));
        assert!(contained(|| -> u32 { panic!("never seen") }).is_err());
        assert!(!CONTAINED.get());
    }
}
