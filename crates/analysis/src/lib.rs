//! Measures integration methods: orders, energy balance, work against precision, stability,
//! attractors and chaos.
//!
//! A [`Model`] is a system with its parameters, a [`study::Problem`] a model with its initial
//! state. A [`study`] runs methods on it and returns the rows of one table.
//! `afterbay-experiments` reads what to study from a scene and makes tables, charts and a report
//! of the rows.

pub mod columns;
pub mod digits;
mod finite_or_none;
pub mod measured;
mod model;
mod observable;
pub mod progress;
pub mod rows;
mod series;
mod solution;
mod spacing;
pub mod statistics;
pub mod study;
mod variable;
pub mod words;

pub use measured::{Doubt, Measured};
pub use model::{Lanes, Model, ModelError, is_linear};
pub use observable::Observable;
pub use solution::Solution;
pub use spacing::Spacing;
pub use variable::Variable;
