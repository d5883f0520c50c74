//! Bounds of the change of K that is due to rounding over a step.

use super::iteration::{Problem, ROUNDINGS_A_TERM, Workspace};
use super::nodes::extent;
use crate::kernels::reductions::max_norm;
use crate::rounding::{KEPT_ROUNDINGS, RESTORED_ROUNDINGS, rounding};
use crate::second_derivatives::{SecondDerivatives, second_order};
use afterbay_core::{Curvature, Scalar, Vector};
use std::array::from_fn;

/// The largest change of the coefficients, in roundings, that may be noise.
const COEFFICIENT_ROUNDINGS: f64 = 64.0;
/// The largest change relative to p at which the rounding of H is measured. As a motion decays, the
/// first changes that are noise are small; a measurement takes 300 gradients. A choice.
const LARGEST_FIRST_NOISE: f64 = 1e-3;

impl<V: Vector> Workspace<V> {
    /// The scale of the rounding error of K over the step: the measured rounding of H, and at both
    /// ends `|H| + Σ |w_j| + Σ |∂H/∂q_j + D_j| |δq| + Σ |∂H/∂p_j| |δp|`, in which the second
    /// derivatives amplify the roundings δq and δp of q and p over the step. A rounding of the
    /// forces changes K by no more than a rounding of one of these terms. A larger change is due to
    /// a quadrature that does not resolve H.
    #[cold]
    pub(super) fn terms<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> f64 {
        let Problem { system, h, state, .. } = *problem;
        let energy_roundings = self.energy_roundings(problem);
        let Self { slopes, q, p, w, .. } = self;
        let ([hq, d, ..], [hp, ..]) = (&mut slopes.hq, &mut slopes.hp);
        let (hq, hp, d) = (hq.as_mut_slice(), hp.as_mut_slice(), d.as_mut_slice());
        let total = |x: &[V::Scalar]| x.iter().map(|x| x.to_f64().abs()).sum::<f64>();
        let mut terms = energy_roundings[0] + energy_roundings[1];
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

    /// Whether the defect is the rounding of the terms of H at the ends. A move of (q, p) along ∇H
    /// does not reduce it: where ∇H is small, near a state of rest, it would make the motion larger.
    #[cold]
    pub(super) fn is_energy_rounding<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> bool {
        let defect = self.defect * rounding::<V::Scalar>(self.scale);
        if defect <= rounding::<V::Scalar>(2.0 * self.energy_rounding.largest()) {
            return true;
        }
        let [start, end] = self.energy_roundings(problem);
        defect <= rounding::<V::Scalar>(start + end)
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
        let energy_roundings = self.energy_roundings(problem);
        let second_order = |q: &V, p: &V| second_order(system, q.as_slice(), p.as_slice());
        let second_order = second_order(&state.q, &state.p) + second_order(&self.q, &self.p);
        let ends = kept * rounding::<V::Scalar>(V::Scalar::EPSILON * second_order);
        let measured = energy_roundings[0] + energy_roundings[1];
        let measured = RESTORED_ROUNDINGS * rounding::<V::Scalar>(measured);
        self.defect * rounding::<V::Scalar>(self.scale) <= ends.max(measured)
    }

    /// The rounding of H at both ends. A measurement takes 300 gradients, so the next step uses the
    /// value at the end again. The value is kept when K is restored, which moves the end by at most
    /// 1e-8 of z. If the gradient is wrong, nothing is measured and the largest value so far is
    /// returned; the failing step reports the gradient.
    fn energy_roundings<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        &Problem { system, state, .. }: &Problem<'_, V, S>,
    ) -> [f64; 2] {
        let [start, end] = self.energy_roundings;
        let rounding = &mut self.energy_rounding;
        let mut measure = |q: &V, p: &V| {
            let measured = rounding.measure(system, q.as_slice(), p.as_slice());
            measured.unwrap_or(rounding.largest())
        };
        let start = start.unwrap_or_else(|| measure(&state.q, &state.p));
        let end = end.unwrap_or_else(|| measure(&self.q, &self.p));
        self.energy_roundings = [Some(start), Some(end)];
        [start, end]
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
