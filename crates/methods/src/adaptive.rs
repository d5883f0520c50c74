//! Step size control, shared by the adaptive methods: the error allowed of a step, the projection
//! onto K, and bounds of a system's frequencies.

mod budget;
mod projection;
mod rates;

pub(crate) use budget::{Budget, largest};
pub(crate) use projection::Projection;
pub(crate) use rates::Rates;
