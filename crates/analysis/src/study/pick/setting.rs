//! A method with its step or its tolerance, and the neighbouring settings.

use super::super::work_precision;
use crate::progress::Progress;
use crate::study::Problem;
use afterbay_core::{Grid, InputError, IntegrateError, Scalar, Tolerance};
use afterbay_methods::registry::{Row, Setting};
use std::time::Duration;

/// The setting of a run.
#[derive(Clone, Copy, Debug)]
pub(super) enum Choice {
    /// This many equal steps.
    Steps(&'static Row, u64),
    /// Steps that follow from a tolerance.
    Tolerance(&'static Row, f64),
}

/// Ratios of a step's neighbours within 5 %. The longest comes first, since it is the first to
/// fail.
const NEAR: [f64; 10] = [1.05, 1.04, 1.03, 1.02, 1.01, 0.99, 0.98, 0.97, 0.96, 0.95];
/// Ratios of a tolerance's neighbours.
const LOOSER: [f64; 6] = [2.0, 1.25, 1.05, 0.95, 0.8, 0.5];
/// The factors of the number of steps and of the tolerance after a neighbour fails.
const MORE_STEPS: f64 = 1.06;
const TIGHTER: f64 = 0.7;
/// The tightest tolerance, some 64 roundings.
pub(super) const TIGHTEST: f64 = 1.5e-14;
const _: () = assert!(TIGHTEST >= 64.0 * <f64 as Scalar>::EPSILON);

/// The largest number of two digits that is not above this one.
pub(super) fn two_digits(x: f64) -> f64 {
    let rounded = format!("{x:.1e}");
    let parts = rounded.split_once('e').and_then(|(digits, exponent)| {
        Some((digits.replace('.', "").parse::<u32>().ok()?, exponent.parse::<i32>().ok()?))
    });
    let Some((digits, exponent)) = parts else { return x };
    let number = |digits: u32, exponent: i32| format!("{digits}e{}", exponent - 1).parse();
    let below = if digits > 10 { (digits - 1, exponent) } else { (99, exponent - 1) };
    [(digits, exponent), below]
        .into_iter()
        .filter_map(|(digits, exponent)| number(digits, exponent).ok())
        .find(|&number| number <= x)
        .unwrap_or(x)
}

impl Choice {
    /// A key that identifies the setting among those of its method.
    pub(super) fn key(self) -> u64 {
        match self {
            Self::Steps(_, steps) => steps,
            Self::Tolerance(_, tolerance) => tolerance.to_bits(),
        }
    }

    /// The neighbours: steps within 5 % that divide the end, or the nearest ones if none is that
    /// near; tolerances from half to twice.
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

    /// The setting to try after a neighbour fails.
    pub(super) fn safer(self) -> Option<Self> {
        match self {
            Self::Steps(row, steps) => {
                Some(Self::Steps(row, ((steps as f64 * MORE_STEPS) as u64).max(steps + 1)))
            }
            Self::Tolerance(row, tolerance) => {
                let tighter = two_digits(tolerance * TIGHTER);
                (tighter >= TIGHTEST).then_some(Self::Tolerance(row, tighter))
            }
        }
    }

    /// The time of the fastest of several unobserved runs.
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

    /// The setting of a run to the end.
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
    fn tolerances_have_two_digits_and_are_not_loosened() {
        for (x, expected) in [
            (9.8765e-7, 9.8e-7),
            (9.96e-7, 9.9e-7),
            (1.0e-6, 1.0e-6),
            (1.5e-14, 1.5e-14),
            (0.099_999, 0.099),
            (4.9e-7, 4.9e-7),
            (2.46e-3, 2.4e-3),
            (0.1, 0.1),
        ] {
            let found = two_digits(x);
            assert!(found == expected && found <= x, "{x:e}: {found:e}");
        }
        for i in 1..2000 {
            let x = 1e-9 * 1.017_f64.powi(i);
            let found = two_digits(x);
            assert!(found <= x && found > 0.89 * x, "{x:e}: {found:e}");
            assert!(format!("{found:e}").len() <= "1.1e-10".len(), "{found:e}");
        }
    }

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
