//! Reasons why no cycle is found.

use crate::ModelError;
use crate::study::outcome::{AT_REST, Ending, word};
use crate::study::stability::MapError;
use afterbay_core::{InputError, IntegrateError};
use thiserror::Error;

/// The reason why no cycle is found.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CycleFailure {
    /// A run fails, or is interrupted.
    #[error(transparent)]
    Run(#[from] IntegrateError),
    /// The system is not valid with a value of the parameter.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The motion comes to rest, and rest is not a cycle.
    #[error("the motion comes to rest at q = {q:?}, p = {p:?}: rest is not a cycle")]
    AtRest {
        /// Coordinates of the state at rest.
        q: Vec<f64>,
        /// Its momenta.
        p: Vec<f64>,
    },
    /// The states do not come back.
    #[error(
        "after the transient the motion comes back to no nearer than {nearest:.1e} of its extent \
         within t = {time:?}: take a longer transient, or another initial state; the motion may \
         also be without a period"
    )]
    NoReturn {
        /// The least distance of a return: the largest difference of an entry, relative to its
        /// extent in the motion.
        nearest: f64,
        /// The time of the search.
        time: f64,
    },
    /// The states at the periods in time of the system do not repeat.
    #[error(
        "after the transient the states do not repeat within {periods} periods of the system in \
         time: take a longer transient, or give the number of periods in the cycle; the motion may \
         also be without a period"
    )]
    NoPeriod {
        /// The periods compared.
        periods: u64,
    },
    /// The period in time of the system is not known.
    #[error(
        "no period of the forces in time is known at this value of the parameter: give the period \
         of the drive, or end the branch before"
    )]
    NoPeriodInTime,
    /// Newton's method does not converge.
    #[error(
        "Newton's method does not converge to a cycle (last correction {correction:.1e} of its \
         size after {iterations} iterations): take a longer transient, or another initial state"
    )]
    NotConverged {
        /// The last correction, relative to the size of the cycle.
        correction: f64,
        /// The number of corrections.
        iterations: usize,
    },
    /// Newton's method leads to another period.
    #[error(
        "Newton's method leads from a period of about {guess:?} to {period:?}: take a longer \
         transient, or another initial state"
    )]
    PeriodLost {
        /// The period of the first guess.
        guess: f64,
        /// The period it came to.
        period: f64,
    },
    /// The cycle is one of a family, as in a conservative system or where parts do not act on each
    /// other.
    #[error(
        "the cycle is one of a family (its equations are singular to {ratio:.1e}), and no limit \
         cycle: so are closed orbits of a conservative system, and of parts that do not act on \
         each other"
    )]
    NotIsolated {
        /// The least singular value of the equations over the largest.
        ratio: f64,
    },
    /// The cycles of a branch shrink to a state of rest.
    #[error(
        "the cycle shrinks to a state of rest at {value:?}, where the branch ends, as at a Hopf \
         bifurcation: end it before"
    )]
    ShrinksToRest {
        /// The value of the parameter.
        value: f64,
    },
    /// The period of a branch grows on while its parameter hardly changes.
    #[error(
        "the period grows on and on ({period:?} at {value:?}) while the parameter hardly changes, \
         as near a homoclinic orbit: end the branch before"
    )]
    PeriodGrows {
        /// The value of the parameter.
        value: f64,
        /// The last period.
        period: f64,
    },
    /// The branch does not end.
    #[error("the branch does not end within {limit} cycles: end it at a nearer value")]
    TooManyCycles {
        /// The most cycles of a branch.
        limit: usize,
    },
    /// The singular values of the equations cannot be computed.
    #[error("the equations of the cycle cannot be solved: their matrix is not finite")]
    NotFinite,
    /// The eigenvalues of the matrix of the cycle cannot be computed.
    #[error("the multipliers cannot be computed: the matrix of the cycle is not finite")]
    NoMultipliers,
}

impl From<InputError> for CycleFailure {
    fn from(error: InputError) -> Self {
        Self::Run(error.into())
    }
}

impl CycleFailure {
    /// The failure as an ending, or as an error where the input is not valid.
    ///
    /// # Errors
    /// Invalid input.
    pub(super) fn ending(self) -> Result<Ending, MapError> {
        let outcome = match &self {
            Self::Run(IntegrateError::Input(error)) => return Err(error.clone().into()),
            Self::Model(error) => return Err(error.clone().into()),
            Self::Run(error) => word(&Err::<(), _>(error.clone())),
            Self::AtRest { .. } => AT_REST,
            Self::NoReturn { .. } | Self::NoPeriod { .. } => "no-return",
            Self::NoPeriodInTime => "no-period-in-time",
            Self::NotConverged { .. } | Self::PeriodLost { .. } | Self::NotFinite => {
                "not-converged"
            }
            Self::NotIsolated { .. } => "not-isolated",
            Self::ShrinksToRest { .. } => "shrinks-to-rest",
            Self::PeriodGrows { .. } => "period-grows",
            Self::TooManyCycles { .. } => "too-many-cycles",
            Self::NoMultipliers => "no-multipliers",
        };
        Ok(Ending { outcome, failure: Some(self.to_string()) })
    }
}
