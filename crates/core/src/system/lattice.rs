//! Chains and rings of equal members.

use super::separable::Separable;
use crate::error::InputError;
use crate::numbers::f64x8;
use std::sync::Arc;

/// The first and the last member of a chain, each as the middle of three ([`Uniform::ends`]).
pub type EndMembers = [Arc<dyn Separable<f64>>; 2];

/// A chain or a ring ([`crate::Coupling`]) of equal members, of which eight can be advanced in SIMD
/// lanes.
///
/// Degree of freedom j depends on q_{j-1}, q_j and q_{j+1}; beyond the ends of a chain, q_0 =
/// q_{n+1} = 0. Mass, partial derivative, divided difference and dissipation of every j, except of
/// [`ends`](Uniform::ends) that differ, are those of the middle member of a chain of three at `q =
/// [q_{j-1}, q_j, q_{j+1}]`. [`crate::validate::uniform`] verifies this.
///
/// A lane gives the bits that its member gives alone if the formulas are free of `exp`, `exp_m1`
/// and `sin_cos`. Their last digits differ in lanes, so that a sweep in lanes and one member by
/// member then agree to roundings only.
pub trait Uniform: Separable<f64> {
    /// A member in lanes.
    type Lanes: Separable<f64x8> + 'static;

    /// A member in lanes, as the middle of three: the parameters are repeated in every lane.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the members of this system are not equal.
    fn lanes(&self) -> Result<Self::Lanes, InputError>;

    /// The first and the last member of a chain, each as the middle of three, if they obey other
    /// laws than the members between them.
    fn ends(&self) -> Option<EndMembers> {
        None
    }
}
