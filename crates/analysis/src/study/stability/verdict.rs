//! How a run ended.

use super::alone::Ending;
use super::measure::{KEPT, MOST_LOOKS, MOST_STATIONS};
use super::reference::{Reference, Standing};
use afterbay_core::{Passive, StepFailure};
use serde::Serialize;

/// How a run behaved beside the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Bounded; every q_j, p_j and w_j within [`SHARE`] of its own size at each of up to
    /// [`MOST_STATIONS`](super::MOST_STATIONS) times along the run; over the second half as large
    /// as the exact solution ([`TOLERANCE`]) and at the same place; and K kept
    /// ([`KEPT`](super::KEPT)) where the method claims it.
    Right,
    /// Off at some of these times, but right in all that does not depend on the phase: as large
    /// and at the same place, the mean of every q_j, p_j and w_j and the root of the mean square
    /// about it within [`SHARE`] of its own size over each half of the run, and K where it is
    /// claimed.
    Late,
    /// Bounded, and neither; or where the exact solution leaves the numbers.
    Wrong,
    /// Bounded, but a step violates passivity ([`Passive::violated`]). Methods that may do so are
    /// watched step by step, those that claim passivity from look to look.
    PassivityViolated,
    /// Bounded, and no reference tells whether it is right: RK4 at its shortest step does not
    /// settle.
    Unjudged,
    /// The motion has grown beyond [`GROWTH`] times the largest the exact solution has, in energy.
    Growing,
    /// A number was not finite.
    NotFinite,
    /// The solver of the step found no solution.
    NoConvergence,
    /// The equation of the step has several solutions, and the one that continues from h = 0 ends
    /// on the way.
    SeveralSolutions,
    /// δ met its pole, or the step equation was singular.
    Pole,
}

impl Verdict {
    /// Every verdict, from good to bad.
    pub const ALL: [Self; 10] = [
        Self::Right,
        Self::Late,
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
            Self::Late => "right but late",
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

    /// The verdict of a run. `owed` is where the system is passive, `keeps_k` whether the method
    /// claims to keep K.
    pub(super) fn of(ending: &Ending, exact: &Reference, owed: Passive, keeps_k: bool) -> Self {
        let seen = &ending.seen;
        match ending.failure {
            Some(failure) => Self::of_failure(&failure),
            None if !(seen.size.is_finite() && seen.largest <= GROWTH) => Self::Growing,
            None if seen.robbed(owed) => Self::PassivityViolated,
            None => match exact.standing {
                Standing::Leaves => Self::Wrong,
                _ if keeps_k && !seen.keeps_k() => Self::Wrong,
                Standing::Unsettled => Self::Unjudged,
                Standing::Resolved if !exact.is_as_large(seen) => Self::Wrong,
                Standing::Resolved if !exact.followed => Self::Unjudged,
                Standing::Resolved if seen.follows() => Self::Right,
                Standing::Resolved => {
                    let late = exact.halves.agree(&seen.halves, &exact.scales.track.allowed());
                    if late { Self::Late } else { Self::Wrong }
                }
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
            | StepFailure::ProjectionFailed { .. }
            | StepFailure::TooLarge { .. }
            | StepFailure::Vanishes { .. } => Self::NoConvergence,
        }
    }
}

/// The size of the motion A is right if |ln(A/A_exact)| ≤ TOLERANCE (1 + |ln A_exact|), in units of
/// the largest of the exact solution: 10 % of the decay in logarithm, and 10 % of the size where
/// there is none. What has decayed below 1e-300, or below the rounding of the place where it rests,
/// counts as that.
pub const TOLERANCE: f64 = 0.1;

/// Each number is right within this share of its own size: half of what q_j or p_j sweeps along
/// the exact solution, or the largest |w_j|, but no less than a hundredth of the largest such size
/// among the degrees of freedom. A coordinate on a circle, see
/// [`Model::periods`](crate::Model::periods), is judged as a point in the plane. The place of the
/// motion is right if its mean is within this share of the largest |q| of the exact solution.
pub const SHARE: f64 = 0.1;

/// A motion of more than so many times the largest energy of the exact solution (more exactly, A
/// beyond it) is growing.
pub const GROWTH: f64 = 1e3;

/// What the verdicts mean, in words, once A, c and Q are known.
pub fn rules() -> String {
    format!(
        "\"Right\" is a bounded run with every q_j, p_j and w_j within {SHARE} of its own size at \
         each of up to {MOST_STATIONS} times (half of what q_j or p_j sweeps along the reference, \
         the largest |w_j|, and no less than a hundredth of the largest of its kind); with the \
         size of the reference, |ln(A/A_ref)| ≤ {TOLERANCE} (1 + |ln A_ref|) for the means of A \
         over the second half, and its place, a mean q within {SHARE} Q of c; and with K kept to \
         {KEPT:e} of its terms where the method claims to keep it. \"Right but late\" is right in \
         all but the phase: the mean of every q_j, p_j and w_j over each half of the run and the \
         root of the mean square about it are within {SHARE} of its size. A coordinate in which \
         the system recurs is a point of a circle. \"Growing\" is an A beyond {GROWTH}. Run and \
         reference are compared after the same {MOST_LOOKS} steps at most."
    )
}
