//! Radau IIA methods, one idea a file: their tables, the stages, the linear equations, Newton's
//! method, the error estimate, the share of a step in the error of the run, the restoration of K,
//! and the step.

mod balance;
mod component;
mod engine;
mod equations;
mod estimate;
mod share;
mod solve;
mod stages;
mod tables;

pub(crate) use engine::Engine;
pub(crate) use tables::Tables;

#[cfg(test)]
mod tests;
