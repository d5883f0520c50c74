//! Chains and rings of equal members.

use super::separable::Separable;
use crate::numbers::f64x8;

/// A chain or a ring ([`crate::Coupling`]) whose degrees of freedom all obey the same law, so that eight of them can be moved
/// side by side.
///
/// Degree of freedom j sees q_{j-1}, q_j and q_{j+1}; beyond the ends of a chain there is a wall, q_0 = q_{n+1} = 0. Its mass,
/// partial derivative, edge and drag are those of the middle of three, `q = [q_{j-1}, q_j, q_{j+1}]`, whatever j:
/// see [`crate::validate::uniform`].
pub trait Uniform: Separable<f64> {
    /// The same system in lanes.
    type Lanes: Separable<f64x8>;

    /// The same system, its parameters in every lane.
    fn lanes(&self) -> Self::Lanes;
}
