//! A method with its step or its tolerance, and what lies beside it.

use super::super::work_precision;
use crate::progress::Progress;
use crate::study::Problem;
use afterbay_core::{Grid, InputError, IntegrateError, Scalar, Tolerance};
use afterbay_methods::registry::{Row, Setting};
use std::time::Duration;

/// What a run is made by, found by searching.
#[derive(Clone, Copy, Debug)]
pub(super) enum Choice {
    /// So many equal steps.
    Steps(&'static Row, u64),
    /// Steps that follow from a tolerance.
    Tolerance(&'static Row, f64),
}

/// The neighbours of a step within 5 %, the longest first, as they are the first to fail.
const NEAR: [f64; 10] = [1.05, 1.04, 1.03, 1.02, 1.01, 0.99, 0.98, 0.97, 0.96, 0.95];
/// The neighbours of a tolerance.
const LOOSER: [f64; 6] = [2.0, 1.25, 1.05, 0.95, 0.8, 0.5];
/// What follows where a neighbour fails: more steps, a tighter tolerance.
const MORE_STEPS: f64 = 1.06;
const TIGHTER: f64 = 0.7;
/// No tolerance is tighter than this.
pub(super) const TIGHTEST: f64 = 64.0 * <f64 as Scalar>::EPSILON;

impl Choice {
    /// What tells this setting from others of its method.
    pub(super) fn key(self) -> u64 {
        match self {
            Self::Steps(_, steps) => steps,
            Self::Tolerance(_, tolerance) => tolerance.to_bits(),
        }
    }

    /// Steps within 5 % that divide the end, and the next ones where none is so near; tolerances
    /// up to twice and down to half as large.
    pub(super) fn neighbours(self) -> Vec<Self> {
        match self {
            Self::Steps(row, steps) => {
                let near = NEAR.map(|factor| (steps as f64 / factor).round() as u64);
                let mut counts: Vec<u64> = near.into_iter().chain([steps - 1, steps + 1]).collect();
                counts.sort_unstable();
                counts.dedup();
                let others = counts.into_iter().filter(|&count| count > 0 && count != steps);
                others.map(|count| Self::Steps(row, count)).collect()
            }
            Self::Tolerance(row, tolerance) => {
                let near = LOOSER.map(|factor| tolerance * factor);
                let possible = near.into_iter().filter(|&near| near >= TIGHTEST);
                possible.map(|near| Self::Tolerance(row, near)).collect()
            }
        }
    }

    /// Twice as many steps, or a quarter of the tolerance where that is possible.
    pub(super) fn finer(self) -> Option<Self> {
        match self {
            Self::Steps(row, steps) => Some(Self::Steps(row, 2 * steps)),
            Self::Tolerance(row, tolerance) => (tolerance > TIGHTEST)
                .then(|| Self::Tolerance(row, (0.25 * tolerance).max(TIGHTEST))),
        }
    }

    /// What is tried where a neighbour fails.
    pub(super) fn safer(self) -> Option<Self> {
        match self {
            Self::Steps(row, steps) => {
                Some(Self::Steps(row, ((steps as f64 * MORE_STEPS) as u64).max(steps + 1)))
            }
            Self::Tolerance(row, tolerance) => {
                let tighter = tolerance * TIGHTER;
                (tighter >= TIGHTEST).then_some(Self::Tolerance(row, tighter))
            }
        }
    }

    /// The time of a run that no one looks at, the fastest of several.
    pub(super) fn time(
        self,
        problem: &Problem,
        progress: &dyn Progress,
    ) -> Result<Duration, IntegrateError> {
        work_precision::time(problem, self.row(), self.setting(problem.end)?, progress)
    }

    /// The method.
    pub(super) fn row(self) -> &'static Row {
        match self {
            Self::Steps(row, _) | Self::Tolerance(row, _) => row,
        }
    }

    /// What sets the steps of a run to the end.
    pub(super) fn setting(self, end: f64) -> Result<Setting<f64>, InputError> {
        Ok(match self {
            Self::Steps(_, steps) => Setting::Step(Grid::of(end / steps as f64, steps)?),
            Self::Tolerance(_, tolerance) => Setting::Tolerance(Tolerance::all(tolerance), end),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_methods::registry::find;

    #[test]
    fn neighbours_are_within_five_per_cent_or_next() {
        let row = find("rk4").expect("a method");
        let of = |steps| {
            Choice::Steps(row, steps).neighbours().into_iter().map(Choice::key).collect::<Vec<_>>()
        };
        assert_eq!(of(1), [2]);
        assert_eq!(of(7), [6, 8]);
        assert_eq!(of(1000), [952, 962, 971, 980, 990, 999, 1001, 1010, 1020, 1031, 1042, 1053]);
    }
}
