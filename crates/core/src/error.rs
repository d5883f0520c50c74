//! Failures as values: each contains the place, the quantity and the numbers that are wrong.

mod input;
mod run;
mod step;

pub use input::InputError;
pub use run::{IntegrateError, RunError};
pub use step::StepFailure;
