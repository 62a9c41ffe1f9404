//! Ctrl-C: the pass under way ends at its next frame, what is written stays marked as incomplete.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::fault::{Cause, Fault};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C only asks, and [`check`] answers; the second ends the program at once.
pub fn listen() {
    // Without a handler Ctrl-C ends the process at once, which is harmless: results are marked until complete.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(Cause::Interrupted as i32);
        }
    });
}

/// Whether Ctrl-C was pressed.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// An error once Ctrl-C was pressed.
pub fn check() -> Result<(), Fault> {
    match is_asked() {
        true => Err(Fault::new(
            Cause::Interrupted,
            "interrupted; the result folder stays marked INCOMPLETE, and bench --resume goes on with it",
        )),
        false => Ok(()),
    }
}
