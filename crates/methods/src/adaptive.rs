//! What methods with steps as long as a tolerance allows share: how much error a step may make, K
//! made exact, and how fast a system can move.

mod budget;
mod projection;
mod rates;

pub(crate) use budget::{Budget, largest};
pub(crate) use projection::Projection;
pub(crate) use rates::Rates;
