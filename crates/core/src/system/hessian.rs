//! Second derivatives, for Newton's method in N dimensions.

use super::hamiltonian::System;
use crate::numbers::Scalar;
use crate::quantity::Block;

/// A system that knows its second derivatives.
pub trait Curvature<T: Scalar>: System<T> {
    /// Gives every entry of every block at (q, p) that is not zero everywhere, always the same ones in the same order.
    fn curvature(&self, q: &[T], p: &[T], put: impl FnMut(Block, usize, usize, T));

    /// Are the second derivatives the same at every state? H is then quadratic and D linear, constant forces allowed, and the
    /// flow is that of a matrix.
    #[inline(always)]
    fn is_linear(&self) -> bool {
        false
    }
}
