//! What a run shows of its motion beside the states that are kept.

use super::attractor::SizeHistory;
use super::metric::Metric;
use super::outcome::Ending;
use super::ranges::Ranges;

/// The growth and the ranges of a run whose states on a section are kept after a transient.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// Returns that are not kept.
    transient: u64,
    /// The last return.
    last: u64,
    growth: SizeHistory,
    /// The ranges of the whole run.
    run: Ranges,
    /// Those after the transient.
    settled: Ranges,
}

impl Motion {
    /// A run that has not begun, of so many degrees of freedom.
    pub(super) fn new(dof: usize, transient: u64, points: u64) -> Self {
        let (last, nothing) = (transient + points, Ranges::nothing(dof));
        let growth = SizeHistory::new(dof, last);
        Self { transient, last, growth, run: nothing.clone(), settled: nothing }
    }

    /// Adds the state (q, p) of return n, counted from 1, and the ranges since the return before.
    pub(super) fn see(&mut self, n: u64, at: &[Vec<f64>; 2], path: &Ranges) {
        self.growth.see(n, at, path);
        self.run.join(path);
        if self.keeps(n) {
            self.settled.join(path);
        }
    }

    /// Whether the state of return n is kept.
    pub(super) fn keeps(&self, n: u64) -> bool {
        n > self.transient
    }

    /// Whether return n is the last one.
    pub(super) fn ends(&self, n: u64) -> bool {
        n >= self.last
    }

    /// The distance of states of the motion that has settled.
    pub(super) fn metric(&self, periods: &[Option<f64>]) -> Metric {
        Metric::of(periods, &self.settled, &self.run)
    }

    /// The outcome of the run, which is another one if it grows.
    pub(super) fn ending(&self, ending: Ending) -> Ending {
        self.growth.ending(ending)
    }
}
