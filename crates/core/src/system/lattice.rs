//! Chains and rings of equal members.

use super::separable::Separable;
use crate::numbers::f64x8;

/// A chain or a ring ([`crate::Coupling`]) of equal members, of which eight can be advanced in SIMD
/// lanes.
///
/// Degree of freedom j depends on q_{j-1}, q_j and q_{j+1}; the ends of a chain are fixed, q_0 =
/// q_{n+1} = 0. Mass, partial derivative, divided difference and dissipation of every j are those
/// of the middle member of a chain of three at `q = [q_{j-1}, q_j, q_{j+1}]`.
/// [`crate::validate::uniform`] verifies this.
///
/// A lane gives the bits that its member gives alone if the formulas are free of `exp`, `exp_m1`
/// and `sin_cos`. Their last digits differ in lanes, so that a sweep in lanes and one member by
/// member then agree to roundings only.
pub trait Uniform: Separable<f64> {
    /// The system in lanes.
    type Lanes: Separable<f64x8>;

    /// The system with its parameters repeated in every lane.
    fn lanes(&self) -> Self::Lanes;
}
