//! Measures integration methods: orders, energy balance, work against precision and stability, as
//! tables, charts and a report.
//!
//! A [`Model`] is a system with its parameters. A [`study`] runs methods on it and returns the rows
//! of one table. The [`paper`] module repeats the paper's experiment from these studies, and
//! [`record`] writes the results to files.

pub mod chart;
pub mod claim;
pub mod compare;
pub mod data;
pub mod experiment;
mod findings;
pub mod journal;
pub mod measured;
mod model;
mod observable;
pub mod paper;
pub mod progress;
pub mod record;
pub mod report;
pub mod scene;
mod series;
mod sheet;
mod solution;
mod spacing;
pub mod statistics;
pub mod study;
mod units;
mod variable;
pub mod words;

pub use claim::Finding;
pub use measured::{Doubt, Measured};
pub use model::{Lanes, Model, ModelError};
pub use observable::Observable;
pub use sheet::ReportError;
pub use solution::Solution;
pub use spacing::Spacing;
pub use units::UnitsTable;
pub use variable::Variable;
