//! Runs that end before their time.

use super::input::InputError;
use super::step::StepFailure;
use thiserror::Error;

/// A run that failed before its end. The state is that of the last successful step, or an earlier
/// one if w overflows.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("step {step} (from t = {t:?}): {failure}")]
pub struct RunError {
    /// The step that failed, counted from 1.
    pub step: u64,
    /// The time it started from.
    pub t: f64,
    /// The reason. The message contains it, so that it is not a source, too.
    pub failure: StepFailure,
}

/// The reason why [`crate::integrate`] did not reach the end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IntegrateError {
    /// An invalid input. Nothing was computed.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A step failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The run was interrupted by its caller.
    #[error("interrupted")]
    Interrupted,
}
