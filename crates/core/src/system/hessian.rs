//! Second derivatives, for Newton's method in N dimensions.

use super::hamiltonian::System;
use crate::numbers::Scalar;
use crate::quantity::Block;

/// A system with second derivatives of H and first derivatives of D.
pub trait Curvature<T: Scalar>: System<T> {
    /// Passes every entry of every block at (q, p) to `put`: block, row, column, value. Entries
    /// that are zero at all states are left out. Which entries are passed, and in which order, must
    /// not depend on the state.
    fn curvature(&self, q: &[T], p: &[T], put: impl FnMut(Block, usize, usize, T));

    /// Whether the second derivatives are the same at every state. H is then quadratic and D
    /// linear, apart from constant forces, and the flow is a matrix exponential.
    #[inline(always)]
    fn is_linear(&self) -> bool {
        false
    }
}
