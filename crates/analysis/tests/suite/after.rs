//! A computation that is asked to stop.

use afterbay_analysis::progress::Progress;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Counts the pieces done, and asks to stop after a number of them.
pub(crate) struct After(pub(crate) AtomicUsize, pub(crate) usize);

impl Progress for After {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
    fn stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed) >= self.1
    }
}

/// Asks to stop once it was asked this number of times.
pub(crate) struct AfterAsked(pub(crate) AtomicU64);

impl Progress for AfterAsked {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
    fn stopped(&self) -> bool {
        self.0.fetch_sub(1, Ordering::Relaxed) == 0
    }
}
