//! How a run ended.

use super::alone::Ending;
use super::reference::{Reference, Standing};
use afterbay_core::{Passive, StepFailure};
use serde::Serialize;

/// How a run behaved beside the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Bounded, and over its second half as large as the exact solution ([`TOLERANCE`]), at the same place ([`SHARE`]).
    Right,
    /// Bounded, and not so; or where the exact solution leaves the numbers.
    Wrong,
    /// Bounded, but an entry of w (or their sum) has fallen, beyond rounding, where friction owes that it does not. Methods that may do
    /// so are watched step by step, those that claim passivity from look to look.
    PassivityViolated,
    /// Bounded, and no reference tells whether it is right: RK4 at its shortest step does not settle.
    Unjudged,
    /// The motion has grown beyond [`GROWTH`] times the largest the exact solution has, in energy.
    Growing,
    /// A number was not finite.
    NotFinite,
    /// The solver of the step found no solution.
    NoConvergence,
    /// The equation of the step has several solutions, and the one that continues from h = 0 ends on the way.
    SeveralSolutions,
    /// δ met its pole, or the step equation was singular.
    Pole,
}

impl Verdict {
    /// Every verdict, from good to bad.
    pub const ALL: [Self; 9] = [
        Self::Right,
        Self::Wrong,
        Self::Growing,
        Self::NotFinite,
        Self::NoConvergence,
        Self::Pole,
        Self::SeveralSolutions,
        Self::PassivityViolated,
        Self::Unjudged,
    ];

    /// In words, for a legend.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Right => "bounded and right",
            Self::Wrong => "bounded, wrong",
            Self::PassivityViolated => "passivity violated",
            Self::Unjudged => "bounded, no reference",
            Self::Growing => "growing",
            Self::NotFinite => "not finite",
            Self::NoConvergence => "solver did not converge",
            Self::SeveralSolutions => "several solutions",
            Self::Pole => "pole or singular",
        }
    }

    /// The verdict of a run. `owed` is where the system owes Δw ≥ 0.
    pub(super) fn of(ending: &Ending, exact: &Reference, owed: Passive) -> Self {
        let seen = &ending.seen;
        match ending.failure {
            Some(failure) => Self::of_failure(&failure),
            None if !(seen.size.is_finite() && seen.largest <= GROWTH) => Self::Growing,
            None if seen.robbed(owed) => Self::PassivityViolated,
            None => match exact.standing {
                Standing::Resolved if exact.agrees(seen.size, &seen.mean, [TOLERANCE, SHARE]) => Self::Right,
                Standing::Resolved | Standing::Leaves => Self::Wrong,
                Standing::Unsettled => Self::Unjudged,
            },
        }
    }

    fn of_failure(failure: &StepFailure) -> Self {
        match failure {
            StepFailure::NonFinite { .. } => Self::NotFinite,
            StepFailure::Pole { .. } | StepFailure::Singular { .. } => Self::Pole,
            StepFailure::SeveralSolutions { .. } => Self::SeveralSolutions,
            StepFailure::NotContracting { .. }
            | StepFailure::NewtonStalled { .. }
            | StepFailure::Unresolved { .. }
            | StepFailure::AcrossSingularity { .. }
            | StepFailure::EdgeUnresolved { .. }
            | StepFailure::BalanceLost { .. }
            | StepFailure::TooLong { .. }
            | StepFailure::NoRelaxationRoot { .. }
            | StepFailure::Vanishes { .. } => Self::NoConvergence,
        }
    }
}

/// The size of the motion A is right if |ln(A/A_exact)| ≤ TOLERANCE (1 + |ln A_exact|), in units of the largest of the exact solution: 10 % of the decay
/// in logarithm, and 10 % of the size where there is none. What has decayed below 1e-300, or below the rounding of the
/// place where it rests, counts as that.
pub const TOLERANCE: f64 = 0.1;

/// The place of the motion is right if its mean is within this share of the largest |q| of the exact solution.
pub const SHARE: f64 = 0.1;

/// A motion of more than so many times the largest energy of the exact solution (more exactly, A beyond it) is growing.
pub const GROWTH: f64 = 1e3;
