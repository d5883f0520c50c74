//! Systems with a known solution.

use super::hamiltonian::System;
use super::state::State;
use crate::numbers::{Scalar, Vector};

/// A system with a closed form of its solution.
pub trait ExactFlow<T: Scalar>: System<T> {
    /// Moves `state`, w included, along the exact flow for the time `h`, which may be negative.
    fn flow<V: Vector<Scalar = T>>(&self, h: T, state: &mut State<V>);
}
