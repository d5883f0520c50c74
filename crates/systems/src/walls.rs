//! The structure of a chain between two walls: neighbours, and the second derivatives of its bonds.
//!
//! V = Σ_{i=0..n} u(q_{i+1} - q_i) with q_0 = q_{n+1} = 0, unit masses and D_j = c p_j.

use afterbay_core::{Block, Scalar};

/// The neighbours of q_j. Those of the first and the last mass are walls, at 0.
#[inline(always)]
pub(crate) fn beside<T: Scalar>(q: &[T], j: usize) -> (T, T) {
    let left = if j == 0 { T::zero() } else { q[j - 1] };
    let right = if j + 1 == q.len() { T::zero() } else { q[j + 1] };
    (left, right)
}

/// Puts the second derivatives of H and the derivatives of D, from the stiffness u''(r) of a bond.
#[inline(always)]
pub(crate) fn curvature<T: Scalar>(
    q: &[T],
    stiffness: impl Fn(T) -> T,
    c: T,
    mut put: impl FnMut(Block, usize, usize, T),
) {
    let last = q.len() - 1;
    let mut left = stiffness(q[0]);
    for j in 0..=last {
        let right = stiffness(if j == last { -q[j] } else { q[j + 1] - q[j] });
        if j > 0 {
            put(Block::Hqq, j, j - 1, -left);
        }
        put(Block::Hqq, j, j, left + right);
        if j < last {
            put(Block::Hqq, j, j + 1, -right);
        }
        put(Block::Hpp, j, j, T::one());
        put(Block::Dp, j, j, c);
        left = right;
    }
}
