//! The error of a step, from how far the polynomials of the slopes are from the slopes at both
//! ends.
//!
//! Collocation leaves a defect `d = c P_K + ..`, P_K the polynomial that vanishes at the nodes, and
//! at the end of the step the error `h ∫ Φ(1, τ) d(τ) dτ = h c κ`, κ the K-th coefficient of the
//! flow Φ of the linearised system: all lower ones are orthogonal to P_K. At the ends |P_K| =
//! √(2K+1), so that c is seen there. Φ is as smooth as the solution, κ the share that c has of the
//! slope; but Φ also has oscillations that the solution does not show.

use super::engine::Engine;
use super::stages::weighted;
use afterbay_core::{Curvature, Scalar, StepFailure, Vector};
use std::array::from_fn;

impl<V: Vector, const K: usize> Engine<V, K> {
    /// The error of the step over what is allowed of the whole run.
    #[inline]
    pub(super) fn error(&self, n: usize, scales: [f64; 3]) -> Result<f64, StepFailure> {
        let Self { gauss, trial, start, end, h, unit_mass, .. } = self;
        // How far the polynomial of a slope is from it at both ends, and the size of the slope.
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
        let share = |[miss, size]: [f64; 2]| if miss > 0.0 { (miss / size).min(1.0) } else { 0.0 };
        let force = miss(&trial.f, [&start.f, &end.f]);
        let velocity = if *unit_mass { [0.0; 2] } else { miss(&trial.v, [&start.v, &end.v]) };
        let loss = miss(&trial.loss, [&start.loss, &end.loss]);
        let length = h.to_f64().abs();
        // How much of a defect is felt at the end: as the slopes themselves are told by their
        // polynomial, or as the fastest oscillation there is, which need not be excited: of
        // frequency ω, √(2K+1) j_K(h ω/2).
        let fastest = if self.stiff.on { 0.0 } else { gauss.response(0.5 * length * self.fastest) };
        let kernel = share(force).max(share(velocity)).max(fastest);
        // A stiff system forgets: what a defect leaves is what it is over the Jacobian.
        let forgets = if self.stiff.on {
            1.0 + self.spare.as_ref().map_or(0.0, |spare| spare.gain())
        } else {
            1.0
        };
        let p = length * force[0] * kernel / forgets;
        let q = (length * velocity[0] * kernel / forgets).max(0.5 * length * p);
        let errors = [q / scales[0], p / scales[1]];
        let w = length * loss[0] * kernel.max(share(loss)) / forgets / scales[2];
        let value = errors[0].max(errors[1]).max(w) + 0.0 * (q + w);
        if value.is_finite() { Ok(value) } else { Err(self.trial.not_finite()) }
    }

    /// An estimate of the frequencies at the end of the step, a bound of them where H is separable.
    #[inline]
    pub(super) fn see_fastest<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S) {
        let Self { end, rates, .. } = self;
        [self.fastest, _] = rates.see(system, &end.q, &end.p);
    }
}
