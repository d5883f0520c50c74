//! H in the plane of one q_j and p_j, with all other coordinates and momenta fixed.

use super::hamiltonian::System;
use crate::numbers::{Scalar, quadrature};

/// A system, separable or not, with derivatives and divided differences of H along one coordinate
/// or one momentum at a time. D_j depends on no velocity but that of j, unless
/// [`crate::DissipationForm::coupled`] is set.
///
/// `at` is a point (q_j, p_j) of the plane of `j`. The entries j of the slices `q` and `p` are
/// ignored. Each function costs O(1) if the coupling is local.
pub trait PhasePlane<T: Scalar>: System<T> {
    /// The first and second derivatives of H in the plane.
    fn slopes(&self, q: &[T], p: &[T], j: usize, at: [T; 2]) -> Slopes<T>;

    /// The divided difference ΔH/Δq_j between two values of q_j at a fixed `p_j`, computed without
    /// cancellation. It is the mean of ∂H/∂q_j along the edge.
    ///
    /// The default integrates [`PhasePlane::slopes`] by Gauss-Legendre quadrature
    /// ([`quadrature::mean`]). It subdivides the edge where needed and is NaN where the subdivision
    /// does not resolve the integrand.
    #[inline]
    fn along_q(&self, q: &[T], p: &[T], j: usize, [from, to]: [T; 2], p_j: T) -> Mean<T> {
        let [value, by_end, by_other] = quadrature::mean(from, to, |at, share| {
            let Slopes { hq, hqq, hqp, .. } = self.slopes(q, p, j, [at, p_j]);
            [hq, share * hqq, hqp]
        });
        Mean { value, by_end, by_other }
    }

    /// The divided difference ΔH/Δp_j between two values of p_j at a fixed `q_j`, with default and
    /// accuracy as for [`PhasePlane::along_q`].
    #[inline]
    fn along_p(&self, q: &[T], p: &[T], j: usize, q_j: T, [from, to]: [T; 2]) -> Mean<T> {
        let [value, by_end, by_other] = quadrature::mean(from, to, |at, share| {
            let Slopes { hp, hpp, hqp, .. } = self.slopes(q, p, j, [q_j, at]);
            [hp, share * hpp, hqp]
        });
        Mean { value, by_end, by_other }
    }

    /// D_j at `at`, given the velocity `v` of j. Newton's method uses the derivatives, which need
    /// not be exact.
    fn plane_dissipation(
        &self,
        q: &[T],
        p: &[T],
        j: usize,
        at: [T; 2],
        v: T,
    ) -> PlaneDissipation<T>;
}

/// First and second derivatives of H by q_j and p_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes<T> {
    /// ∂H/∂q_j
    pub hq: T,
    /// ∂H/∂p_j
    pub hp: T,
    /// ∂²H/∂q_j²
    pub hqq: T,
    /// ∂²H/∂q_j∂p_j
    pub hqp: T,
    /// ∂²H/∂p_j²
    pub hpp: T,
}

/// A divided difference of H along an edge of the plane. Newton's method uses the derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean<T> {
    /// The divided difference.
    pub value: T,
    /// Its derivative by the end of the edge.
    pub by_end: T,
    /// Its derivative by the fixed variable: p_j along q_j, q_j along p_j.
    pub by_other: T,
}

/// The dissipative force on one degree of freedom and its derivatives by q_j, p_j and the velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneDissipation<T> {
    /// D_j
    pub value: T,
    /// ∂D_j/∂q_j at a given velocity
    pub by_q: T,
    /// ∂D_j/∂p_j at a given velocity
    pub by_p: T,
    /// ∂D_j/∂v_j
    pub by_v: T,
}
