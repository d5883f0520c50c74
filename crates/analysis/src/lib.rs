//! What the methods are worth: orders, energy books, work against precision, stability, as tables,
//! charts and a report.
//!
//! A [`Model`] is a system with its parameters, a [`study`] runs methods on it and gives the rows
//! of one table, the [`paper`] puts studies together into the paper's experiment, and [`record`]
//! writes it all down.

pub mod chart;
pub mod claim;
pub mod experiment;
pub mod measured;
mod model;
pub mod paper;
pub mod progress;
pub mod record;
pub mod report;
pub mod scene;
mod series;
mod sheet;
mod solution;
pub mod statistics;
pub mod study;

pub use claim::Finding;
pub use measured::{Doubt, Measured};
pub use model::{Lanes, Model, ModelError};
pub use sheet::ReportError;
pub use solution::Solution;
