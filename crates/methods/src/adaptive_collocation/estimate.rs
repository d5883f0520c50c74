//! The error estimate of a step, from the difference between the slopes and their polynomials at
//! both ends.
//!
//! Collocation leaves a defect `d = c P_K + ..`, where P_K is the polynomial that vanishes at the
//! nodes. The error at the end of the step is `h ∫ Φ(1, τ) d(τ) dτ = h c κ`, where κ is the K-th
//! coefficient of the flow Φ of the linearised system; lower coefficients are orthogonal to P_K. At
//! the ends |P_K| = √(2K+1), which determines c. Φ is as smooth as the solution, in which case κ is
//! c divided by the slope; but Φ also contains oscillations that are absent from the solution.

use super::engine::Engine;
use super::stages::weighted;
use crate::kernels::reductions::largest_if_finite;
use afterbay_core::{Curvature, Scalar, StepFailure, Vector};
use std::array::from_fn;

/// A defect relative to the size of the slope.
#[inline(always)]
pub(super) fn share([miss, size]: [f64; 2]) -> f64 {
    if miss > 0.0 { (miss / size).min(1.0) } else { 0.0 }
}

impl<V: Vector, const K: usize> Engine<V, K> {
    /// The error estimate of the step relative to the error allowed for the whole run. Across a
    /// kink the error is of the size of the defect.
    #[inline]
    pub(super) fn error(
        &self,
        n: usize,
        scales: [f64; 3],
        smooth: bool,
    ) -> Result<f64, StepFailure> {
        let [force, velocity, loss] = self.defects(n);
        let length = self.h.to_f64().abs();
        // The factor from the defect to the error at the end: the relative error of the polynomial
        // of the slopes, or the response √(2K+1) j_K(h ω/2) of the fastest oscillation of frequency
        // ω, which need not be excited.
        let fastest = self.gauss.response(0.5 * length * self.fastest);
        let kernel = if smooth { share(force).max(share(velocity)).max(fastest) } else { 1.0 };
        let p = length * force[0] * kernel;
        // The error of p is also an error of the velocities. Its effect on q grows over the step.
        let by_p = 0.5 * length * self.inverse_mass * p;
        let q = (length * velocity[0] * kernel).max(by_p);
        let errors = [q / scales[0], p / scales[1]];
        let w = length * loss[0] * kernel.max(share(loss)) / scales[2];
        let value = largest_if_finite([errors[0], errors[1], w]);
        if value.is_finite() { Ok(value) } else { Err(self.trial.not_finite()) }
    }

    /// The defects of p', q' and w', each with the size of the slope. The defect of q' vanishes if
    /// the velocities are the momenta.
    #[inline(always)]
    pub(super) fn defects(&self, n: usize) -> [[f64; 2]; 3] {
        let Self { gauss, trial, start, end, unit_mass, .. } = self;
        // The difference between a slope and its polynomial at both ends, and the size of the
        // slope.
        let miss = |x: &[V; K], ends: [&V; 2]| -> [f64; 2] {
            let (mut most, mut size) = (0.0_f64, 0.0_f64);
            for d in 0..n {
                let at: [V::Scalar; K] = from_fn(|i| x[i].as_slice()[d]);
                let turned: [V::Scalar; K] = from_fn(|i| at[K - 1 - i]);
                let last = (ends[1].as_slice()[d] - weighted(&gauss.end, at)).to_f64().abs();
                let first = (ends[0].as_slice()[d] - weighted(&gauss.end, turned)).to_f64().abs();
                most = most.max(last).max(first) + 0.0 * (last + first);
                size = at.iter().fold(size, |size, x| size.max(x.to_f64().abs()));
            }
            [most / ((2 * K + 1) as f64).sqrt(), size]
        };
        let force = miss(&trial.f, [&start.f, &end.f]);
        let velocity = if *unit_mass { [0.0; 2] } else { miss(&trial.v, [&start.v, &end.v]) };
        let loss = miss(&trial.loss, [&start.loss, &end.loss]);
        [force, velocity, loss]
    }

    /// Estimates the frequencies at the end of the step, an upper bound if H is separable, and the
    /// largest ∂v/∂p.
    #[inline]
    pub(super) fn see_fastest<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S) {
        let Self { end, rates, .. } = self;
        let bounds = rates.bounds(system, &end.q, &end.p);
        (self.fastest, self.inverse_mass) = (bounds.frequency, bounds.velocity);
    }
}
