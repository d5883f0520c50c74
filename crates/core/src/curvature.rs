//! Second derivatives, for Newton's method in N dimensions.

use crate::{Scalar, System};

/// A matrix of derivatives by degree of freedom i (row) and j (column).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// ∂²H/∂q_i∂q_j
    Hqq,
    /// ∂²H/∂q_i∂p_j
    Hqp,
    /// ∂²H/∂p_i∂p_j
    Hpp,
    /// ∂D_i/∂q_j
    Dq,
    /// ∂D_i/∂p_j
    Dp,
}

impl Block {
    /// Its entry in this row and column, both counted from 0 here and from 1 in the name.
    pub(crate) fn of(self, row: usize, column: usize) -> String {
        let (i, j) = (row.saturating_add(1), column.saturating_add(1));
        match self {
            Self::Hqq => format!("∂²H/∂q{i}∂q{j}"),
            Self::Hqp => format!("∂²H/∂q{i}∂p{j}"),
            Self::Hpp => format!("∂²H/∂p{i}∂p{j}"),
            Self::Dq => format!("∂D{i}/∂q{j}"),
            Self::Dp => format!("∂D{i}/∂p{j}"),
        }
    }
}

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
