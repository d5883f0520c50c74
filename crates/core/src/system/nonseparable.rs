//! H as one degree of freedom sees it: in the plane of its q_j and p_j, the others held.

use super::hamiltonian::System;
use crate::numbers::{Scalar, quadrature};

/// A system whose H may be followed along one coordinate or one momentum at a time, separable or not, with D_j depending on
/// no velocity but that of j unless [`crate::DissipationForm::coupled`] is said.
///
/// `at` is a point (q_j, p_j) of the plane of `j`; the entries j of the slices `q` and `p` are not looked at. Where the coupling
/// is local each of these costs O(1).
pub trait PhasePlane<T: Scalar>: System<T> {
    /// The first and second derivatives of H in the plane.
    fn slopes(&self, q: &[T], p: &[T], j: usize, at: [T; 2]) -> Slopes<T>;

    /// The mean of ∂H/∂q_j as q_j goes from one end to the other at a fixed `p_j`: ΔH/Δq_j without its cancellation.
    ///
    /// The default integrates [`PhasePlane::slopes`] by Gauss-Legendre quadrature ([`quadrature::mean`]), on parts of
    /// the edge where it must, and is NaN where these do not resolve it. Give the closed form where
    /// there is one, and say so in [`PhasePlane::has_exact_means`].
    #[inline]
    fn along_q(&self, q: &[T], p: &[T], j: usize, [from, to]: [T; 2], p_j: T) -> Mean<T> {
        let [value, by_end, by_other] = quadrature::mean(from, to, |at, share| {
            let Slopes { hq, hqq, hqp, .. } = self.slopes(q, p, j, [at, p_j]);
            [hq, share * hqq, hqp]
        });
        Mean { value, by_end, by_other }
    }

    /// The mean of ∂H/∂p_j as p_j goes from one end to the other at a fixed `q_j`; default and accuracy as for
    /// [`PhasePlane::along_q`].
    #[inline]
    fn along_p(&self, q: &[T], p: &[T], j: usize, q_j: T, [from, to]: [T; 2]) -> Mean<T> {
        let [value, by_end, by_other] = quadrature::mean(from, to, |at, share| {
            let Slopes { hp, hpp, hqp, .. } = self.slopes(q, p, j, [q_j, at]);
            [hp, share * hpp, hqp]
        });
        Mean { value, by_end, by_other }
    }

    /// Are the means exact to roundings on every edge? Where they are not, as by default, K is compared
    /// before and after each step.
    #[inline(always)]
    fn has_exact_means(&self) -> bool {
        false
    }

    /// D_j at `at`, given the velocity `v` of j. The derivatives steer Newton's iteration and need not be exact.
    fn plane_dissipation(&self, q: &[T], p: &[T], j: usize, at: [T; 2], v: T) -> PlaneDissipation<T>;
}

/// Derivatives of H by q_j and p_j.
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

/// The mean of a slope of H along an edge of the plane. The derivatives steer Newton's iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean<T> {
    /// The mean.
    pub value: T,
    /// Its derivative by the end of the edge.
    pub by_end: T,
    /// Its derivative by the variable held: p_j along q_j, q_j along p_j.
    pub by_other: T,
}

/// The dissipative force on one degree of freedom, and how it changes with that degree of freedom.
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
