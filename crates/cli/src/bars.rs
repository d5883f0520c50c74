//! Progress bars on stderr, shown only if it is a terminal. A bar appears with its stage, and says
//! how much time is left, by the planned cost of its pieces, as soon as a part of the stage is
//! done.

use crate::interrupt;
use afterbay_analysis::progress::Progress;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The parts of a piece that a bar counts.
const PARTS: u64 = 1000;
/// The time between two pictures of a bar.
const TICK: Duration = Duration::from_millis(200);
/// The least share from which the time left is estimated.
const LEAST: f64 = 0.005;
/// The counts and the time come first: names of stages are cut where they do not fit.
const TEMPLATE: &str = "{bar:20} {done} {left}  {wide_msg}";

/// The bar of the current stage.
pub(crate) struct Bars {
    current: Mutex<Stage>,
}

struct Stage {
    bar: ProgressBar,
    name: String,
    /// The percentage of the reference shown in the bar; 0 without a reference.
    reference: Arc<AtomicU64>,
    /// The share of the cost of the stage that is done.
    work: Arc<Mutex<f64>>,
    /// The part of it that an earlier command has done.
    earlier: Arc<Mutex<f64>>,
}

impl Bars {
    /// Starts without a bar.
    pub(crate) fn new() -> Self {
        let (bar, name) = (ProgressBar::hidden(), String::new());
        Self {
            current: Mutex::new(Stage {
                bar,
                name,
                reference: Arc::default(),
                work: Arc::default(),
                earlier: Arc::default(),
            }),
        }
    }

    fn current(&self) -> MutexGuard<'_, Stage> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn finish(&self) {
        self.current().bar.finish_and_clear();
    }
}

impl Stage {
    /// The name of the stage, without a reference.
    fn pieces(&mut self) {
        if self.reference.swap(0, Ordering::Relaxed) > 0 {
            self.bar.set_message(self.name.clone());
        }
    }
}

/// A time in words.
fn in_words(time: Duration) -> String {
    match time.as_secs() {
        seconds @ 0..60 => format!("{seconds} s"),
        seconds @ 60..3600 => format!("{} min {} s", seconds / 60, seconds % 60),
        seconds => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

/// The pieces that are done, and all of them.
fn done(state: &ProgressState, text: &mut dyn Write) {
    // Nothing can be done about a bar that cannot be drawn.
    let _ = write!(text, "{}/{}", state.pos() / PARTS, state.len().unwrap_or(0) / PARTS);
}

/// The time left after a share of the work, once it can be estimated; the time taken until then.
/// What an earlier command has done took none of that time.
fn left(elapsed: Duration, share: f64, earlier: f64) -> String {
    let here = share - earlier;
    if here < LEAST {
        return format!("{} so far", in_words(elapsed));
    }
    let left = elapsed.mul_f64((1.0 - share).max(0.0) / here).as_secs_f64().ceil();
    format!("{} left", in_words(Duration::from_secs(left as u64)))
}

impl Progress for Bars {
    fn begin(&self, stage: &str, total: usize) {
        let bar = ProgressBar::new(PARTS * total as u64).with_message(stage.to_owned());
        let (reference, work) = (Arc::<AtomicU64>::default(), Arc::<Mutex<f64>>::default());
        let earlier = Arc::<Mutex<f64>>::default();
        // The template is a constant. If it were not valid, the plain bar would do.
        if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
            let (percent, work) = (Arc::clone(&reference), Arc::clone(&work));
            let before = Arc::clone(&earlier);
            let left = move |state: &ProgressState, text: &mut dyn Write| {
                let pieces = state.pos() as f64 / state.len().unwrap_or(0).max(1) as f64;
                let cost = *work.lock().unwrap_or_else(PoisonError::into_inner);
                let before = *before.lock().unwrap_or_else(PoisonError::into_inner);
                let (share, before) = match percent.load(Ordering::Relaxed) {
                    // Not every stage reports the cost of its pieces.
                    0 if cost > 0.0 => (cost, before),
                    0 => (pieces, 0.0),
                    percent => (percent as f64 / 100.0, 0.0),
                };
                let _ = text.write_str(&left(state.elapsed(), share, before));
            };
            bar.set_style(style.with_key("done", done).with_key("left", left));
        }
        let mut current = self.current();
        current.bar.finish_and_clear();
        if !bar.is_hidden() {
            bar.enable_steady_tick(TICK);
        }
        *current = Stage { bar, name: stage.to_owned(), reference, work, earlier };
    }

    fn advance(&self) {
        let mut current = self.current();
        current.pieces();
        current.bar.inc(PARTS);
    }

    fn part(&self, share: f64) {
        let mut current = self.current();
        current.pieces();
        let parts = (PARTS as f64 * share.abs()).round() as u64;
        if share > 0.0 { current.bar.inc(parts) } else { current.bar.dec(parts) }
    }

    fn work(&self, share: f64) {
        *self.current().work.lock().unwrap_or_else(PoisonError::into_inner) += share;
    }

    fn earlier(&self, share: f64) {
        *self.current().earlier.lock().unwrap_or_else(PoisonError::into_inner) += share;
    }

    fn reference(&self, share: f64) {
        let current = self.current();
        if current.bar.position() == 0 && !current.bar.is_hidden() && share > 0.0 {
            let percent = (100.0 * share.min(1.0)).round() as u64;
            current.reference.store(percent, Ordering::Relaxed);
            let name = &current.name;
            let of = if name == "reference" { String::new() } else { format!("{name}, ") };
            current.bar.set_message(format!("{of}reference at {percent} %"));
        }
    }

    fn stopped(&self) -> bool {
        interrupt::stopped()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_in_seconds_minutes_and_hours() {
        for (seconds, words) in [(0, "0 s"), (59, "59 s"), (200, "3 min 20 s"), (7260, "2 h 1 min")]
        {
            assert_eq!(in_words(Duration::from_secs(seconds)), words);
        }
        let resumed = |seconds, share, earlier| left(Duration::from_secs(seconds), share, earlier);
        let after = |seconds, share| resumed(seconds, share, 0.0);
        assert_eq!(after(3, 0.0), "3 s so far");
        assert_eq!(after(10, 0.25), "30 s left");
        assert_eq!(after(100, 0.5), "1 min 40 s left");
        assert_eq!(after(7, 1.0), "0 s left");
        // An eighth of the work took 10 s, and a quarter is left.
        assert_eq!(resumed(10, 0.75, 0.625), "20 s left");
        assert_eq!(resumed(1, 0.625, 0.625), "1 s so far");
    }

    #[test]
    fn a_bar_counts_parts_until_the_piece_is_counted() {
        let bars = Bars::new();
        bars.begin("runs", 3);
        let position = || bars.current().bar.position();
        bars.reference(0.5);
        bars.part(0.25);
        bars.part(0.5);
        assert_eq!(position(), 750);
        bars.part(-0.75);
        bars.advance();
        assert_eq!(position(), 1000);
        bars.part(0.5);
        assert_eq!(position(), 1500);
        bars.work(0.25);
        bars.earlier(0.125);
        assert_eq!(*bars.current().earlier.lock().expect("a share"), 0.125);
        let work = || *bars.current().work.lock().expect("a share");
        assert_eq!(work(), 0.25);
        bars.begin("charts", 1);
        assert_eq!((position(), work()), (0, 0.0));
        assert_eq!(*bars.current().earlier.lock().expect("a share"), 0.0);
    }
}
