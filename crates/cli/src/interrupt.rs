//! Ctrl-C and SIGTERM end the computation early, and the results so far are written. A second
//! signal ends the command at once.

use crate::exit_code::SIGNAL;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// The signal received; 0 before the first.
static RECEIVED: OnceLock<Arc<AtomicUsize>> = OnceLock::new();
/// Whether the user has been told that the command is stopping.
static TOLD: AtomicBool = AtomicBool::new(false);

/// Installs the handlers. From here on the first signal stops the computation and not the command.
pub(crate) fn listen() {
    let received = RECEIVED.get_or_init(Arc::default);
    let armed = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The conditional shutdown is registered first: the first signal arms it, and the second
        // one triggers it. If a handler cannot be installed, the signal ends the command as it does
        // by default.
        let _ = flag::register_conditional_shutdown(
            signal,
            i32::from(SIGNAL) + signal,
            Arc::clone(&armed),
        );
        let _ = flag::register(signal, Arc::clone(&armed));
        let _ = flag::register_usize(signal, Arc::clone(received), signal as usize);
    }
}

/// Whether a signal has been received.
pub(crate) fn stopped() -> bool {
    let stopped = signal().is_some();
    if stopped && !TOLD.swap(true, Ordering::Relaxed) {
        crate::table::message("Stopping; interrupt once more to stop at once.");
    }
    stopped
}

/// The exit code of a command that received a signal.
pub(crate) fn exit_code() -> Option<ExitCode> {
    signal().map(|signal| ExitCode::from(SIGNAL + signal))
}

/// The number of the first signal received, if any.
fn signal() -> Option<u8> {
    let received = RECEIVED.get()?.load(Ordering::Relaxed);
    u8::try_from(received).ok().filter(|&signal| signal != 0)
}
