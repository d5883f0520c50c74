//! Experiments: what a scene or the paper asks for, and the tables, charts and report of its
//! results.
//!
//! A [`scene`] is read from TOML. An [`experiment`] runs its studies, whose computations are those
//! of `afterbay-analysis`, and keeps finished cells in a [`journal`]. The [`paper`] module repeats
//! the paper's experiment, [`compare`] joins the results of two runs, and [`record`] writes all
//! results to files.

pub mod artifact;
pub mod chart;
pub mod claim;
pub mod compare;
pub mod data;
pub mod experiment;
mod findings;
pub mod journal;
pub mod manifest;
pub mod paper;
pub mod record;
pub mod report;
pub mod scene;
mod sheet;
mod units;

pub use claim::{Finding, counted, in_full, in_short};
pub use sheet::ReportError;
pub use units::UnitsTable;
