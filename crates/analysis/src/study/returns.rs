//! The returns of a run to a section: which are kept, their distance, and whether they grow.

use super::attractor::Traits;
use super::growing::SizeHistory;
use super::metric::Metric;
use super::motion::Motion;
use super::outcome::Ending;
use super::ranges::Ranges;
use super::section::point;
use afterbay_core::StateRef;
use std::ops::ControlFlow;

/// A run whose states on a section are kept after a transient.
#[derive(Clone, Debug)]
pub(super) struct Returns {
    /// The periods of the coordinates that have one; one entry for each degree of freedom.
    periods: Vec<Option<f64>>,
    /// Returns that are not kept.
    transient: u64,
    /// The last return.
    last: u64,
    growth: SizeHistory,
    motion: Motion,
    /// Whether no friction has taken or given energy.
    conservative: bool,
}

impl Returns {
    /// A run that has not begun. One period, or none, for each degree of freedom.
    pub(super) fn new(periods: Vec<Option<f64>>, transient: u64, points: u64) -> Self {
        let (dof, last) = (periods.len(), transient + points);
        let (growth, motion) = (SizeHistory::new(dof, last), Motion::new(dof));
        Self { periods, transient, last, growth, motion, conservative: true }
    }

    /// The number of degrees of freedom, without motors.
    pub(super) fn dof(&self) -> usize {
        self.periods.len()
    }

    /// Adds the state of return n, counted from 1, and the ranges since the return before. Returns
    /// [q, p] if the state is kept.
    pub(super) fn see(
        &mut self,
        n: u64,
        state: StateRef<'_, f64>,
        path: &Ranges,
    ) -> Option<[Vec<f64>; 2]> {
        self.growth.see(n, path);
        self.conservative &= state.w[..self.dof()].iter().all(|w| *w == 0.0);
        self.motion.join(path);
        if n == self.transient {
            self.motion.settle();
        }
        (n > self.transient).then(|| point(&self.periods, self.dof(), state))
    }

    /// `Break` after the last return.
    pub(super) fn go_on(&self, n: u64) -> ControlFlow<()> {
        if n >= self.last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The outcome of the run, which is another one if it grows.
    pub(super) fn ending(&self, ending: Ending) -> Ending {
        self.growth.ending(ending, &self.periods)
    }

    /// The ranges of all of the run.
    pub(super) fn run(&self) -> &Ranges {
        self.motion.run()
    }

    /// Properties of the motion. The run is at rest if its settled motion is small compared with a
    /// motion of the given ranges.
    pub(super) fn traits(&self, whole: &Ranges) -> Traits {
        Traits { rests: self.motion.is_rest_beside(whole), conservative: self.conservative }
    }

    /// The distance of the states that are kept.
    pub(super) fn metric(&self) -> Metric {
        self.motion.metric(&self.periods)
    }
}
