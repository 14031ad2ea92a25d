//! Ctrl-C: frames that are rendered are written, the one that the device works on is not waited for, and the program ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::Failure;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the program to stop; a second one ends it at once.
pub(super) fn install() {
    // Where it fails, the system ends the program at once, and files are still whole or not there.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(Failure::INTERRUPTED));
        }
    });
}

/// Items until the program is asked to stop; [`check`] says whether these are all.
pub(super) fn until<T>(items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    items.into_iter().take_while(|_| go_on(Duration::ZERO))
}

/// Whether to go on: what waits for the device asks for it ([`crate::gpu::headless::Options::go_on`]).
pub(super) fn go_on(_: Duration) -> bool {
    !INTERRUPTED.load(Ordering::SeqCst)
}

/// Fails once the program was asked to stop.
pub(super) fn check() -> Result<(), Failure> {
    match INTERRUPTED.load(Ordering::SeqCst) {
        true => Err(Failure::new(Failure::INTERRUPTED, "interrupted; the frames that were written are whole")),
        false => Ok(()),
    }
}
