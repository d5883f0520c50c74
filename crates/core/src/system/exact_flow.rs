//! Systems whose solution is known.

use super::hamiltonian::System;
use super::state::State;
use crate::numbers::{Scalar, Vector};

/// A system that can be solved exactly.
pub trait ExactFlow<T: Scalar>: System<T> {
    /// Carries `state` along the exact flow, w included, over the time `h` (of either sign).
    fn flow<V: Vector<Scalar = T>>(&self, h: T, state: &mut State<V>);
}
