//! Ctrl-C: what is done is written down; twice, and nothing is.

use crate::experiment::INTERRUPTED;
use std::sync::atomic::{AtomicBool, Ordering};

static STOPPED: AtomicBool = AtomicBool::new(false);

/// Listens from now on.
pub(crate) fn listen() {
    // Where no handler can be set, Ctrl-C ends the command as it always does.
    let _ = ctrlc::set_handler(|| {
        if STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        eprintln!("stopping; once more to stop at once");
    });
}

/// Was it pressed?
pub(crate) fn stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
}
