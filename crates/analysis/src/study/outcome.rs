//! The ending of a run: one word for tables, and a sentence.

use crate::words::{Word, word as read_word};
use afterbay_core::{IntegrateError, StepFailure};
use serde::{Deserialize, Serialize};

/// The word of a run that reached its end.
pub const COMPLETED: &str = "completed";
/// The word of a run that was stopped.
pub const INTERRUPTED: &str = "interrupted";

/// The word of a motion that has come to rest.
pub const AT_REST: &str = "at-rest";

/// The outcome of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ending {
    /// One word.
    #[serde(deserialize_with = "read_word")]
    pub outcome: Word,
    /// The failure in words.
    pub failure: Option<String>,
}

impl Ending {
    /// The ending of a run of `steps` steps, of which `done` were done.
    pub fn of<T>(result: &Result<T, IntegrateError>, steps: u64, done: u64) -> Self {
        let outcome = if result.is_ok() && done < steps { INTERRUPTED } else { word(result) };
        Self { outcome, failure: result.as_ref().err().map(ToString::to_string) }
    }

    /// The ending of a run that was not begun because the user stopped.
    pub fn interrupted() -> Self {
        Self { outcome: INTERRUPTED, failure: None }
    }

    /// The ending of a run that reached its end.
    pub fn completed() -> Self {
        Self { outcome: COMPLETED, failure: None }
    }

    /// Whether the run reached its end.
    pub fn is_completed(&self) -> bool {
        self.outcome == COMPLETED
    }

    /// Whether the user stopped the run, or stopped before it began.
    pub fn is_interrupted(&self) -> bool {
        self.outcome == INTERRUPTED
    }

    /// The ending in words.
    pub fn describe(&self) -> String {
        self.failure.clone().unwrap_or_else(|| self.outcome.into())
    }
}

/// One word for the ending of a run.
pub fn word<T>(result: &Result<T, IntegrateError>) -> &'static str {
    match result {
        Ok(_) => COMPLETED,
        Err(IntegrateError::Input(_)) => "refused",
        Err(IntegrateError::Interrupted) => INTERRUPTED,
        Err(IntegrateError::Run(error)) => step_word(&error.failure),
    }
}

/// One word for the failure of a step.
pub(crate) fn step_word(failure: &StepFailure) -> &'static str {
    match failure {
        StepFailure::NonFinite { .. }
        | StepFailure::Undefined { .. }
        | StepFailure::LeftByEvent { .. } => "not-finite",
        StepFailure::NotContracting { .. } => "not-contracting",
        StepFailure::NewtonStalled { .. } => "newton-stalled",
        StepFailure::SeveralSolutions { .. } => "several-solutions",
        StepFailure::Singular { .. } => "singular",
        StepFailure::Pole { .. } => "pole",
        StepFailure::Unresolved { .. }
        | StepFailure::EdgeUnresolved { .. }
        | StepFailure::BalanceLost { .. }
        | StepFailure::PartsAccumulate { .. } => "unresolved",
        StepFailure::AcrossSingularity { .. } => "singularity",
        StepFailure::NotGradient { .. } | StepFailure::NotPartial { .. } => "not-gradient",
        StepFailure::TooLong { .. } => "too-long",
        StepFailure::NoRelaxationRoot { .. } => "no-relaxation-root",
        StepFailure::NoRebound { .. } => "no-rebound",
        StepFailure::ProjectionFailed { .. } => "projection-failed",
        StepFailure::TooLarge { .. } => "too-large",
        StepFailure::Vanishes { .. } => "vanishes",
        StepFailure::EventsAccumulate { .. } => "events-accumulate",
    }
}
