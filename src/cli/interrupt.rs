//! Ctrl-C: the frame that is being written is finished, then the program ends.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the program to stop; a second one ends it at once.
pub(super) fn install() -> Result<(), Failure> {
    static INSTALLED: OnceLock<Result<(), String>> = OnceLock::new();
    let install = || {
        ctrlc::set_handler(|| {
            if INTERRUPTED.swap(true, Ordering::SeqCst) {
                std::process::exit(i32::from(Failure::INTERRUPTED));
            }
        })
        .map_err(|e| e.to_string())
    };
    let installed = INSTALLED.get_or_init(install).clone();
    installed.map_err(|e| Failure::new(1, format!("cannot listen for Ctrl-C: {e}")))
}

/// Fails once the program was asked to stop.
pub(super) fn check() -> Result<(), Failure> {
    match INTERRUPTED.load(Ordering::SeqCst) {
        true => Err(Failure::new(Failure::INTERRUPTED, "interrupted; frames that were begun are whole")),
        false => Ok(()),
    }
}
