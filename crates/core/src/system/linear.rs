//! Linear systems.

use super::separable::Separable;
use crate::numbers::Scalar;

/// A system with V = ½ Σ k_ij q_i q_j, m_j = 1 and D_j = b_j p_j. Its flow is linear, and an
/// implicit step has a closed form.
pub trait Linear<T: Scalar>: Separable<T> {
    /// The stiffness k_ij = k_ji.
    fn stiffness(&self, i: usize, j: usize) -> T;
    /// The coefficient b_j of D_j = b_j p_j.
    fn dissipation_rate(&self, j: usize) -> T;
}
