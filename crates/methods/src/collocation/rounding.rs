//! Bounds of the change of K that is due to rounding over a step.

use super::iteration::{Problem, ROUNDINGS_A_TERM, Workspace};
use super::nodes::extent;
use crate::kernels::reductions::max_norm;
use crate::rounding::{KEPT_ROUNDINGS, RESTORED_ROUNDINGS, rounding};
use crate::second_derivatives::{SecondDerivatives, second_order};
use afterbay_core::{Curvature, Scalar, Vector};
use std::array::from_fn;

/// The error of K, in roundings of z times their effect on K, that is attributed to rounding: the
/// new state is rounded once more after the iteration.
const END_ROUNDINGS: f64 = 8.0;
/// The largest change of the coefficients, in roundings, that may be noise.
const COEFFICIENT_ROUNDINGS: f64 = 64.0;
/// The largest change relative to p at which the rounding of H is measured. As a motion decays, the
/// first changes that are noise are small; a measurement takes about 700 gradients. A choice.
const LARGEST_FIRST_NOISE: f64 = 1e-3;

impl<V: Vector> Workspace<V> {
    /// Whether the defect is a rounding of K over the step. The scale of that rounding is the
    /// measured rounding of H and [`Self::terms`].
    #[cold]
    pub(super) fn is_rounding<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> bool {
        let (terms, defect) = (self.terms(problem), self.defect * self.scale);
        self.allows(problem, |measured| defect <= END_ROUNDINGS * (terms + measured))
    }

    /// The scale of the rounding error of K over the step beside the measured rounding of H: at
    /// both ends `|H| + Σ |w_j| + Σ |∂H/∂q_j + D_j| |δq| + Σ |∂H/∂p_j| |δp|`, in which the second
    /// derivatives amplify the roundings δq and δp of q and p over the step. A rounding of the
    /// forces changes K by no more than a rounding of one of these terms. A larger change is due to
    /// a quadrature that does not resolve H.
    fn terms<S: Curvature<V::Scalar> + ?Sized>(&mut self, problem: &Problem<'_, V, S>) -> f64 {
        let Problem { system, h, state, .. } = *problem;
        let Self { slopes, q, p, w, .. } = self;
        let ([hq, d, ..], [hp, ..]) = (&mut slopes.hq, &mut slopes.hp);
        let (hq, hp, d) = (hq.as_mut_slice(), hp.as_mut_slice(), d.as_mut_slice());
        let total = |x: &[V::Scalar]| x.iter().map(|x| x.to_f64().abs()).sum::<f64>();
        let mut terms = 0.0;
        for (q, p, w) in [(&state.q, &state.p, &state.w), (&*q, &*p, &*w)] {
            let (q, p) = (q.as_slice(), p.as_slice());
            system.gradient(q, p, hq, hp);
            system.dissipation(q, p, hp, d);
            let sizes = [max_norm(q), max_norm(p)];
            let rates = SecondDerivatives::at(system, q, p).rounded(sizes);
            let reach: [f64; 2] = from_fn(|i| sizes[i] + h.to_f64().abs() * rates[i]);
            let slopes = reach[0] * (total(hq) + total(d)) + reach[1] * total(hp);
            // At an equilibrium the slopes vanish, and a rounding of z changes H in second order.
            let square = V::Scalar::EPSILON * second_order(system, q, p);
            terms += system.energy(q, p).to_f64().abs() + total(w.as_slice()) + slopes + square;
        }
        terms
    }

    /// Whether the defect is the rounding of the terms of H at the ends. Near rest ∇H
    /// is small, and a move of (q, p) along ∇H that corrects it is longer than the motion.
    #[cold]
    pub(super) fn is_energy_rounding<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> bool {
        let defect = self.defect * rounding::<V::Scalar>(self.scale);
        self.allows(problem, |measured| defect <= rounding::<V::Scalar>(measured))
    }

    /// Whether the defect is the rounding of K at the ends. On a step so long that a rounding of z
    /// grows by many powers of ten, [`Self::terms`] is too large to be a useful bound.
    #[cold]
    pub(super) fn keeps_k<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> bool {
        let Problem { system, state, .. } = *problem;
        let kept = KEPT_ROUNDINGS.max(ROUNDINGS_A_TERM * state.dof() as f64);
        if self.defect <= kept {
            return true;
        }
        let second_order = |q: &V, p: &V| second_order(system, q.as_slice(), p.as_slice());
        let second_order = second_order(&state.q, &state.p) + second_order(&self.q, &self.p);
        let ends = kept * rounding::<V::Scalar>(V::Scalar::EPSILON * second_order);
        let defect = self.defect * rounding::<V::Scalar>(self.scale);
        let is_rounding = |measured| defect <= RESTORED_ROUNDINGS * rounding::<V::Scalar>(measured);
        defect <= ends || self.allows(problem, is_rounding)
    }

    /// Whether `accepts` holds for the roundings of H at both ends together: for twice the largest
    /// so far or, since a measurement takes about 700 gradients, only then for those measured at
    /// the ends. If the gradient is wrong, nothing is measured; the failing step reports it.
    fn allows<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        &Problem { system, state, .. }: &Problem<'_, V, S>,
        accepts: impl Fn(f64) -> bool,
    ) -> bool {
        let Self { energy_rounding, q, p, measured_at, .. } = self;
        let ends = [(&state.q, &state.p), (&*q, &*p)];
        for (is_measured, (q, p)) in measured_at.iter_mut().zip(ends) {
            if accepts(2.0 * energy_rounding.largest()) {
                return true;
            }
            if !std::mem::replace(is_measured, true) {
                energy_rounding.measure(system, q.as_slice(), p.as_slice()).unwrap_or_default();
            }
        }
        accepts(2.0 * energy_rounding.largest())
    }

    /// Whether changes that no longer shrink, of the given share of p, are the rounding of the
    /// forces. Near an equilibrium the forces are differences of large terms, and p is small
    /// compared with the effect of their rounding: `ε h |∂²H/∂q∂q| |q|` away from the origin, and
    /// the rounding of these terms ([`EnergyRounding::of_forces`]).
    #[cold]
    pub(super) fn is_noise<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
        change: f64,
    ) -> bool {
        let Problem { system, h, state, start, .. } = *problem;
        let (q, p) = (state.q.as_slice(), state.p.as_slice());
        let length = h.to_f64().abs();
        let size = extent(&state.p, &self.p_modes, length);
        let second = SecondDerivatives::at(system, q, p);
        let [_, moved] = second.rounded([max_norm(q), max_norm(p)]);
        let is_within = |forces: f64| {
            let terms = size + length * (moved + forces);
            change * size <= COEFFICIENT_ROUNDINGS * rounding::<V::Scalar>(terms)
        };
        let energy = start.to_f64();
        if is_within(self.energy_rounding.of_forces(energy, second.of_potential())) {
            return true;
        }
        if change > LARGEST_FIRST_NOISE {
            return false;
        }
        if self.energy_rounding.measure(system, q, p).is_err() {
            return false;
        }
        is_within(self.energy_rounding.of_forces(energy, second.of_potential()))
    }
}
