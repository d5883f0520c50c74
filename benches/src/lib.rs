//! The runs on which the cost of a step is measured: through the public API, and the same runs
//! written by hand.
//!
//! `benches/step.rs` times each with criterion. `benches/ratios.rs` times the two of a pair in turn
//! and prints one table of ratios, which is less sensitive to load on the machine.

mod by_hand;
pub mod chain;
mod conservative;
mod pairs;
pub mod written;

pub use pairs::{Pair, Run, STEPS, Subject, pairs};
