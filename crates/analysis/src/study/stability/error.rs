//! The errors of a study of many runs.

use crate::ModelError;
use afterbay_core::InputError;
use thiserror::Error;

/// An error that prevents a study of many runs. The failure of a run is a result of the study.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MapError {
    /// The system has no such parameter, or the value is not valid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A step or a state is not valid, or a method does not apply.
    #[error(transparent)]
    Input(#[from] InputError),
}
