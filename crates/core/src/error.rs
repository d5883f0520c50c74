//! Failures are values that say where, what and how much.

mod input;
mod run;
mod step;

pub use input::InputError;
pub use run::{IntegrateError, RunError};
pub use step::StepFailure;
