//! Systems whose energy is a sum of kinetic and potential energy.

use super::dissipation::Dissipation;
use super::hamiltonian::System;
use crate::numbers::{Line, Scalar, divided};

/// H = Σ p_j²/(2 m_j) + V(q), and D_j depending on no momentum but p_j unless [`crate::DissipationForm::coupled`] is said.
pub trait Separable<T: Scalar>: System<T> {
    /// m_j > 0
    #[inline(always)]
    fn mass(&self, _j: usize) -> T {
        T::one()
    }

    /// ∂V/∂q_j at the point q with its coordinate j moved to `at`.
    fn partial(&self, q: &[T], j: usize, at: T) -> T;

    /// The mean of ∂V/∂q_j along the edge from q to the point with coordinate j moved to `to`,
    /// `[V(.., to, ..) - V(q)] / (to - q_j)` without its cancellation, and its derivative by `to`.
    ///
    /// The default integrates [`Separable::partial`] by Gauss-Legendre quadrature ([`divided::by_quadrature`]), on
    /// parts of the edge where it must, and is NaN where these do not resolve it. Where V is written for
    /// every scalar, [`divided::of_potential`] is exact and faster, and [`crate::FromFormulas`] uses it
    /// unasked. Give that or a closed form where there is one, and say so in [`Separable::has_exact_divided_differences`].
    #[inline]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        divided::by_quadrature(q[j], to, |at| self.partial(q, j, at))
    }

    /// Is [`Separable::divided_difference`] exact to roundings on every edge? Where it is not, as by default, the
    /// methods that rest on it compare K before and after each step: give the energy without cancellation.
    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        false
    }

    /// Can V be singular where q is finite? What [`Separable::is_singular_along`] says is asked only then.
    #[inline(always)]
    fn may_be_singular(&self) -> bool {
        false
    }

    /// Is V singular between q and the point with coordinate j moved to `to`? An exact mean keeps K even
    /// across a pole, so that a step that leads there is refused by this alone.
    #[inline(always)]
    fn is_singular_along(&self, _q: &[T], _j: usize, _to: T) -> bool {
        false
    }

    /// D_j at (q, p) with its derivatives by q_j and p_j. The derivatives steer Newton's iteration and need not be exact,
    /// but for `by_p` where [`crate::DissipationForm::linear`] is claimed: it then stands for D itself.
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T>;
}
