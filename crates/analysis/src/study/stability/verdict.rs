//! Verdicts on runs.

use super::alone::Ending;
use super::measure::{MOST_OBSERVATIONS, MOST_STATIONS};
use super::reference::{Reference, Standing};
use super::thresholds::{GROWTH, KEPT_ON_MAPS, SHARE, TOLERANCE};
use afterbay_core::{Passive, StepFailure};
use serde::{Deserialize, Serialize};

/// The behaviour of a run compared with the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Bounded. Every q_j, p_j and w_j is within [`SHARE`] of its own size at each of up to
    /// `MOST_STATIONS` times along the run. Over the second half the motion
    /// has the size ([`TOLERANCE`]) and the place of the exact solution. K is kept
    /// ([`KEPT_ON_MAPS`](super::KEPT_ON_MAPS)) if the method claims to keep it.
    Right,
    /// Off at some of these times, but right in everything that does not depend on the phase: size
    /// and place over the second half; over each half the mean and the root mean square about it of
    /// every q_j, p_j and w_j, within [`SHARE`] of its own size; and K if the method claims to keep
    /// it.
    Late,
    /// Bounded, but neither right nor late; or the exact solution ceases to be finite.
    Wrong,
    /// Bounded, but a step violates passivity ([`Passive::violated`]). Methods that may violate it
    /// are checked after every step, methods that claim passivity only where a run is observed.
    PassivityViolated,
    /// Bounded, but without a reference: RK4 at its shortest step does not settle.
    Unjudged,
    /// The energy grows beyond [`GROWTH`] times the largest of the exact solution.
    Growing,
    /// A number was not finite.
    NotFinite,
    /// The solver of the step found no solution.
    NoConvergence,
    /// The equation of the step has several solutions, and the one continued from h = 0 ends on the
    /// way.
    SeveralSolutions,
    /// δ met its pole, the equation of the step was singular, or a step would cross a singularity.
    Pole,
}

impl Verdict {
    /// All verdicts, from good to bad.
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

    /// The place of the verdict in [`Verdict::ALL`].
    pub fn badness(self) -> usize {
        Self::ALL.iter().position(|&verdict| verdict == self).unwrap_or(0)
    }

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

    /// The verdict on a run. `passivity` is that of the system, and `keeps_k` is whether
    /// the method claims to keep K.
    pub(super) fn of(
        ending: &Ending,
        exact: &Reference,
        passivity: Passive,
        keeps_k: bool,
    ) -> Self {
        let statistics = &ending.statistics;
        match ending.failure {
            Some(failure) => Self::of_failure(&failure),
            None if statistics.grows() => Self::Growing,
            None if statistics.violates_passivity(passivity) => Self::PassivityViolated,
            None => match exact.standing {
                Standing::Leaves => Self::Wrong,
                _ if keeps_k && !statistics.keeps_k() => Self::Wrong,
                Standing::Unsettled => Self::Unjudged,
                Standing::Resolved if !exact.is_as_large(statistics) => Self::Wrong,
                Standing::Resolved if !exact.followed => Self::Unjudged,
                Standing::Resolved if statistics.follows() => Self::Right,
                Standing::Resolved => {
                    let late =
                        exact.halves.agree(&statistics.halves, &exact.scales.track.allowed());
                    if late { Self::Late } else { Self::Wrong }
                }
            },
        }
    }

    fn of_failure(failure: &StepFailure) -> Self {
        match failure {
            StepFailure::NonFinite { .. }
            | StepFailure::Undefined { .. }
            | StepFailure::LeftByEvent { .. } => Self::NotFinite,
            StepFailure::Pole { .. }
            | StepFailure::Singular { .. }
            | StepFailure::AcrossSingularity { .. } => Self::Pole,
            StepFailure::SeveralSolutions { .. } => Self::SeveralSolutions,
            StepFailure::NotContracting { .. }
            | StepFailure::NewtonStalled { .. }
            | StepFailure::Unresolved { .. }
            | StepFailure::NotGradient { .. }
            | StepFailure::NotPartial { .. }
            | StepFailure::EdgeUnresolved { .. }
            | StepFailure::BalanceLost { .. }
            | StepFailure::TooLong { .. }
            | StepFailure::NoRelaxationRoot { .. }
            | StepFailure::NoRebound { .. }
            | StepFailure::ProjectionFailed { .. }
            | StepFailure::TooLarge { .. }
            | StepFailure::Vanishes { .. }
            | StepFailure::EventsAccumulate { .. }
            | StepFailure::PartsAccumulate { .. } => Self::NoConvergence,
        }
    }
}

/// The meaning of the verdicts in words, where A, c and Q are known.
pub fn rules() -> String {
    format!(
        "\"Right\" means that the run is bounded and meets three conditions. Every q_j, p_j and \
         w_j is within {SHARE} of its own size at each of up to {MOST_STATIONS} times. This size \
         is half the range of q_j or p_j along the reference, or the largest |w_j|, and at least a \
         hundredth of the largest of its kind. Over the second half the means of A satisfy \
         |ln(A/A_ref)| ≤ {TOLERANCE} (1 + |ln A_ref|), and the mean of q is within {SHARE} Q of c. \
         K is kept to {KEPT_ON_MAPS:e} of its terms if the method claims to keep it. \"Right but \
         late\" means right in all but the phase: over each half of the run the mean of every q_j, \
         p_j and w_j, and the root mean square about it, are within {SHARE} of its size. A \
         periodic coordinate is compared as a point of a circle. \"Growing\" means that A \
         exceeds {GROWTH} by a rise of H. Run and reference are compared after the same steps, \
         at most {MOST_OBSERVATIONS} of them."
    )
}
