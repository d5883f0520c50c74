//! Systems whose energy is a sum of kinetic and potential energy.

use super::dissipation::Dissipation;
use super::hamiltonian::System;
use crate::error::InputError;
use crate::numbers::{Line, Mask, Scalar, divided};

/// A system with H = Σ p_j²/(2 m_j) + V(q). D_j depends on no momentum but p_j, unless
/// [`crate::DissipationForm::coupled`] is set.
pub trait Separable<T: Scalar>: System<T> {
    /// The mass m_j > 0, the ratio p_j/v_j of momentum and velocity.
    #[inline(always)]
    fn mass(&self, _j: usize) -> T {
        T::one()
    }

    /// ∂V/∂q_j, in the units of ∂H/∂q_j, at the point q with its coordinate j moved to `at`.
    fn partial(&self, q: &[T], j: usize, at: T) -> T;

    /// The divided difference `[V(.., to, ..) - V(q)] / (to - q_j)` of V over the edge from q to
    /// the point with coordinate j moved to `to`, computed without cancellation, and its derivative
    /// by `to`. It is the mean of ∂V/∂q_j along the edge.
    ///
    /// The default integrates [`Separable::partial`] by Gauss-Legendre quadrature
    /// ([`divided::by_quadrature`]). It subdivides the edge where needed and is NaN where the
    /// subdivision does not resolve the integrand. Where V is written for every scalar,
    /// [`divided::of_potential`] is exact and faster; [`crate::FromFormulas`] uses it. Systems with
    /// an exact form state so in [`Separable::has_exact_divided_differences`].
    #[inline]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        divided::by_quadrature(q[j], to, |at| self.partial(q, j, at))
    }

    /// Whether [`Separable::divided_difference`] is exact to roundings on every edge. If not, which
    /// is the default, methods that use it compare K before and after each step.
    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        false
    }

    /// Whether V is singular between q and the point with coordinate j moved to `to`. An exact
    /// divided difference keeps K even across a pole, so only this refuses a step that leads there.
    /// It is called if [`System::may_be_singular`].
    #[inline(always)]
    fn is_singular_along(&self, _q: &[T], _j: usize, _to: T) -> bool {
        false
    }

    /// D_j at (q, p) with its derivatives by q_j and p_j. Newton's method uses the derivatives,
    /// which need not be exact. Only `by_p` must be where [`crate::DissipationForm::linear`] is
    /// set: D_j is then computed as `by_p` times p_j. For a motor all are 0: methods count the work
    /// of its force by [`Separable::supply`].
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T>;

    /// D_j without the force of a drive, as [`Separable::dissipation_of`].
    #[inline(always)]
    fn friction_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        self.dissipation_of(q, p, j)
    }

    /// The force of the drive on degree of freedom j at q, if j is driven.
    /// [`Separable::dissipation_of`] is then D_j - F_j, and [`Separable::friction_of`] is D_j.
    #[inline(always)]
    fn supply(&self, _q: &[T], _j: usize) -> Option<Supply<T>> {
        None
    }
}

/// Checks that every mass is positive and finite. The cost is O(N).
///
/// # Errors
/// [`InputError::Mass`], with the first that is not.
pub fn masses<T: Scalar>(system: &(impl Separable<T> + ?Sized)) -> Result<(), InputError> {
    for dof in 0..system.dof() {
        let mass = system.mass(dof);
        if !T::zero().lt(mass).and(mass.is_finite()).all() {
            return Err(InputError::Mass { dof, value: mass.to_f64() });
        }
    }
    Ok(())
}

/// The force of a drive on a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply<T> {
    /// The motor.
    pub motor: usize,
    /// F_j
    pub force: T,
    /// Whether F_j depends on q_j.
    pub depends_on_own: bool,
}
