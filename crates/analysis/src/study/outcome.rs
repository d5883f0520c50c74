//! How a run ended, in one word for the tables and in a sentence for people.

use afterbay_core::{IntegrateError, StepFailure};

/// The word of a run that reached its end.
pub const COMPLETED: &str = "completed";

/// One word for the ending of a run.
pub fn word<T>(result: &Result<T, IntegrateError>) -> &'static str {
    match result {
        Ok(_) => COMPLETED,
        Err(IntegrateError::Input(_)) => "refused",
        Err(IntegrateError::Run(error)) => step_word(&error.failure),
    }
}

/// One word for the failure of a step.
pub fn step_word(failure: &StepFailure) -> &'static str {
    match failure {
        StepFailure::NonFinite { .. } => "not-finite",
        StepFailure::NotContracting { .. } => "not-contracting",
        StepFailure::NewtonStalled { .. } => "newton-stalled",
        StepFailure::SeveralSolutions { .. } => "several-solutions",
        StepFailure::Singular { .. } => "singular",
        StepFailure::Pole { .. } => "pole",
        StepFailure::Unresolved { .. } => "unresolved",
        StepFailure::TooLong { .. } => "too-long",
        StepFailure::NoRelaxationRoot { .. } => "no-relaxation-root",
        StepFailure::Vanishes { .. } => "vanishes",
    }
}
