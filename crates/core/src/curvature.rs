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

/// Which degrees of freedom act on each other: i on j where a [`Block`] may have an entry (i, j).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// Neighbours in a row: |i - j| ≤ 1.
    Chain,
    /// Neighbours in a circle: the first and the last too.
    Ring,
    /// Every one on every other.
    Dense,
}

impl Coupling {
    /// The `n` degrees of freedom colour by colour, no two of a colour acting on each other: red-black for a chain and
    /// an even ring, a third colour for the last of an odd ring. What is dense stays in its natural order.
    pub fn coloured(&self, n: usize) -> Vec<usize> {
        let last = match self {
            Self::Dense => return (0..n).collect(),
            Self::Ring if n % 2 == 1 && n > 1 => n - 1,
            Self::Chain | Self::Ring => n,
        };
        (0..last).step_by(2).chain((1..last).step_by(2)).chain(last..n).collect()
    }
}

/// A system that knows its second derivatives.
pub trait Curvature<T: Scalar>: System<T> {
    /// Who acts on whom.
    fn coupling(&self) -> Coupling;

    /// Gives every entry of every block at (q, p) that is not zero everywhere, always the same ones in the same order.
    fn curvature(&self, q: &[T], p: &[T], put: impl FnMut(Block, usize, usize, T));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_keep_neighbours_apart() {
        assert_eq!(Coupling::Chain.coloured(5), [0, 2, 4, 1, 3]);
        assert_eq!(Coupling::Ring.coloured(6), [0, 2, 4, 1, 3, 5]);
        assert_eq!(Coupling::Ring.coloured(5), [0, 2, 1, 3, 4]);
        assert_eq!(Coupling::Dense.coloured(3), [0, 1, 2]);
        assert_eq!(Coupling::Ring.coloured(1), [0]);
    }
}
