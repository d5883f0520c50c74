//! Runs that end before their time.

use super::input::InputError;
use super::step::StepFailure;
use thiserror::Error;

/// A run that ended before its time. The state is that of the last good step.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("step {step} (from t = {t:?}): {failure}")]
pub struct RunError {
    /// The step that failed, counted from 1.
    pub step: u64,
    /// The time it started from.
    pub t: f64,
    /// Why.
    #[source]
    pub failure: StepFailure,
}

/// Why [`crate::integrate`] did not reach the end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IntegrateError {
    /// Nothing was computed.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A step failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// It was asked to stop.
    #[error("interrupted")]
    Interrupted,
}
