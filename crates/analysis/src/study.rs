//! The studies: each runs methods on a problem and gives the rows of one table.
//!
//! Errors are computed in parallel over (method, step) and collected by index, so that a table is the same to the bit
//! for any number of threads. Times are taken one run after the other.

pub mod energy;
pub mod global_order;
pub mod local_order;
pub mod outcome;
pub mod stability;
pub mod work_precision;

use crate::{Model, OneState};
use afterbay_core::{InputError, IntegrateError, Quad, Scalar, State};
use serde::Serialize;

/// The names of the three variables, in the order the studies keep.
pub const VARIABLES: [&str; 3] = ["q", "p", "w"];

/// A system, where it starts and when it ends.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Problem {
    /// The system.
    #[serde(rename = "system")]
    pub model: Model,
    /// q at t = 0.
    pub q: f64,
    /// p at t = 0.
    pub p: f64,
    /// The end of time.
    pub end: f64,
}

impl Problem {
    /// The initial state.
    ///
    /// # Errors
    /// [`InputError::NotFinite`]
    pub fn start<T: Scalar>(&self) -> Result<OneState<T>, InputError> {
        State::new([T::from_f64(self.q)], [T::from_f64(self.p)])
    }

    /// (q, p, w) of the exact solution at the times `i h`, i = 0..=count, computed in [`Quad`] and rounded.
    ///
    /// # Errors
    /// Those of the input, and of a solution that leaves the numbers.
    pub fn solution(&self, h: f64, count: usize) -> Result<Vec<[f64; 3]>, IntegrateError> {
        let subject = self.model.subject::<Quad>()?;
        let states = subject.solution(&self.start()?, Quad::from_f64(h), count)?;
        Ok(states.iter().map(values).collect())
    }
}

/// (q, p, w) in `f64`.
fn values<T: Scalar>(state: &OneState<T>) -> [f64; 3] {
    [state.q[0], state.p[0], state.w[0]].map(Scalar::to_f64)
}
