//! Ctrl-C: frames that are rendered are written, the one that the device works on is not waited for, and the program ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The program was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted; the frames that were written are whole")]
pub struct Interrupted;

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the program to stop; a second one ends it at once, with this code.
pub(crate) fn install(code: u8) {
    // Where it fails, the system ends the program at once, and files are still whole or not there.
    let _ = ctrlc::set_handler(move || {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            leave(code);
        }
    });
}

/// Ends the program at once. Drivers are not taken down: their threads may still work on what nobody waited for.
pub(crate) fn leave(code: u8) -> ! {
    #[cfg(unix)]
    // SAFETY: it does not return, and touches nothing of the program's.
    unsafe {
        libc::_exit(i32::from(code))
    }
    #[cfg(not(unix))]
    std::process::exit(i32::from(code))
}

/// Items until the program is asked to stop; [`check`] says whether these are all.
pub(crate) fn until<T>(items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    items.into_iter().take_while(|_| go_on(Duration::ZERO))
}

/// Whether to go on: what waits for the device asks for it ([`crate::gpu::headless::Options::go_on`]).
pub(crate) fn go_on(_: Duration) -> bool {
    !INTERRUPTED.load(Ordering::SeqCst)
}

/// Fails once the program was asked to stop.
pub(crate) fn check() -> Result<(), Interrupted> {
    if INTERRUPTED.load(Ordering::SeqCst) { Err(Interrupted) } else { Ok(()) }
}
