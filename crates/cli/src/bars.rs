//! Progress bars on stderr, shown only if it is a terminal.

use crate::interrupt;
use afterbay_analysis::progress::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;

/// The bar of the current stage.
pub(crate) struct Bars {
    bar: Mutex<ProgressBar>,
}

impl Bars {
    /// Starts without a bar.
    pub(crate) fn new() -> Self {
        Self { bar: Mutex::new(ProgressBar::hidden()) }
    }

    fn current(&self) -> ProgressBar {
        self.bar.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone()
    }

    pub(crate) fn finish(&self) {
        self.current().finish_and_clear();
    }
}

impl Progress for Bars {
    fn begin(&self, stage: &str, total: usize) {
        let next = ProgressBar::new(total as u64).with_message(stage.to_owned());
        // The template is a constant. If it were not valid, the plain bar would do.
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} ({eta})") {
            next.set_style(style);
        }
        let mut bar = self.bar.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        bar.finish_and_clear();
        *bar = next;
    }

    fn advance(&self) {
        self.current().inc(1);
    }

    fn stopped(&self) -> bool {
        interrupt::stopped()
    }
}
