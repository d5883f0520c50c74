//! The error estimate of a step, from the difference between the slopes and their polynomials at
//! both ends.
//!
//! Collocation leaves a defect `d = c P_K + ..`, where P_K is the polynomial that vanishes at the
//! nodes. The error at the end of the step is `h ∫ Φ(1, τ) d(τ) dτ = h c κ`, where κ is the K-th
//! coefficient of the flow Φ of the linearised system; lower coefficients are orthogonal to P_K. At
//! the ends |P_K| = √(2K+1), which determines c. κ is the largest of three:
//!
//! - Φ is as smooth as the solution: c divided by the slope.
//! - Φ also contains oscillations that are absent from the solution.
//! - A part of the force that is small beside the others may change within the step, as a friction
//!   where the velocity passes 0. Its coefficients decrease slowly, and so do those of Φ: they are
//!   taken to decrease alike.
//!
//! The last counts where c exceeds what roundings, and the change in the last sweep, may cause. It
//! does not count while steps are longer than a time of the system, whose fast components are not
//! resolved and need not be.

use super::engine::Engine;
use super::gauss::weighted;
use super::limits::Limits;
use crate::adaptive::size_of_first_or_nan;
use crate::kernels::reductions::{largest_if_finite, see_size};
use afterbay_core::{Curvature, Scalar, StepFailure, Vector, larger_or_nan};
use std::array::from_fn;
use std::ops::Range;

/// A defect that this many roundings of the slope, of q and of p may cause counts as noise. A
/// choice.
const SLOPE_DEFECT_ROUNDINGS: f64 = 16.0;

/// The defect of a slope in all degrees of freedom.
#[derive(Clone, Copy, Default)]
pub(super) struct Defect {
    /// The largest defect.
    pub(super) largest: f64,
    /// The size of the slope.
    size: f64,
    /// The largest product of a defect and κ, which follows from the decrease of the coefficients.
    unresolved: f64,
}

impl Defect {
    /// The defect relative to the size of the slope.
    #[inline(always)]
    pub(super) fn share(self) -> f64 {
        if self.largest > 0.0 { (self.largest / self.size).min(1.0) } else { 0.0 }
    }

    /// The larger of two defects.
    fn or(self, other: Self) -> Self {
        Self {
            largest: larger_or_nan(self.largest, other.largest),
            size: self.size.max(other.size),
            unresolved: self.unresolved.max(other.unresolved),
        }
    }

    /// The largest product of a defect and κ, where κ is at least `kernel`; NaN for a defect that
    /// is not finite.
    #[inline(always)]
    fn error(self, kernel: f64) -> f64 {
        larger_or_nan(self.unresolved, self.largest * kernel)
    }
}

impl<V: Vector, const K: usize> Engine<V, K> {
    /// The error estimate of the step relative to the allowed one. Across a kink the error is of
    /// the size of the defect.
    #[inline]
    pub(super) fn error(&self, limits: &Limits) -> Result<f64, StepFailure> {
        let Limits { scales, share, smooth, least_error, .. } = *limits;
        let [force, velocity, power] = self.defects();
        let length = self.h.to_f64().abs();
        // The factor from the defect to the error at the end: the relative error of the polynomial
        // of the slopes, or the response √(2K+1) j_K(h ω/2) of the fastest oscillation of frequency
        // ω, which need not be excited.
        let fastest = self.gauss.response(0.5 * length * self.fastest);
        let kernel = if smooth { force.share().max(velocity.share()).max(fastest) } else { 1.0 };
        let p = length * force.error(kernel);
        // The error of p is also an error of the velocities. Its effect on q grows over the step.
        let by_p = 0.5 * length * self.inverse_mass * p;
        let q = larger_or_nan(by_p, length * velocity.error(kernel));
        let w = length * power.error(kernel.max(power.share()));
        let value = largest_if_finite([q / scales[0], p / scales[1], w / scales[2]]);
        self.relative_error(value / share, least_error)
    }

    /// The error, at least `least`, or the failure of a step with numbers that are not finite.
    pub(super) fn relative_error(&self, error: f64, least: f64) -> Result<f64, StepFailure> {
        if error.is_finite() {
            Ok(error.max(least))
        } else {
            Err(self.trial.not_finite(&self.last))
        }
    }

    /// The defects of p', of q', and of the slopes of energies. That of q' vanishes if the
    /// velocities are the momenta.
    #[inline(always)]
    pub(super) fn defects(&self) -> [Defect; 3] {
        let Self { gauss, trial, start, end, last, unit_mass, free, .. } = self;
        let (n, free) = (V::LEN.unwrap_or(end.q.as_slice().len()), *free);
        let rounding = SLOPE_DEFECT_ROUNDINGS * V::Scalar::EPSILON;
        let noise = [
            rounding.mul_add(size_of_first_or_nan(&end.q, free), self.moved[0]),
            rounding.mul_add(size_of_first_or_nan(&end.p, free), self.moved[1]),
        ];
        // A rounding of the time, which is the coordinate of a motor, changes the force at the rate
        // at which it changes over the step.
        let time = end.q.as_slice()[free..].iter();
        let time = time.fold(0.0_f64, |most, t| most.max(t.to_f64().abs()));
        let pairs = start.f.as_slice()[..free].iter().zip(&last.f.as_slice()[..free]);
        let change = pairs.fold(0.0_f64, |most, (&a, &b)| most.max((b - a).to_f64().abs()));
        let of_time = rounding * time * change / self.h.to_f64().abs();
        let of_force = self.rates.force(noise) + of_time;
        let of_velocity = self.inverse_mass * noise[1];
        // |P_K| at the ends is 1 over this.
        let at_ends = ((2 * K + 1) as f64).sqrt().recip();
        // The difference between a slope and its polynomial at both ends, beside its noise.
        let miss = |x: &[V; K], ends: [&V; 2], noise: f64, entries: Range<usize>| -> Defect {
            let (mut defect, mut worst) = (Defect::default(), [0.0; 2]);
            // A constant number of entries lets the loop be unrolled.
            for d in (0..n).filter(|d| entries.contains(d)) {
                let at: [V::Scalar; K] = from_fn(|i| x[i].as_slice()[d]);
                let turned: [V::Scalar; K] = from_fn(|i| at[K - 1 - i]);
                let last = (ends[1].as_slice()[d] - weighted(&gauss.end, at)).to_f64().abs();
                let first = (ends[0].as_slice()[d] - weighted(&gauss.end, turned)).to_f64().abs();
                let most = last.max(first) * at_ends;
                let size = at.iter().fold(0.0_f64, |size, x| size.max(x.to_f64().abs()));
                worst = see_size(see_size(worst, last), first);
                defect.size = defect.size.max(size);
                if !self.stiff.uses_newton && most > rounding.mul_add(size, noise) {
                    let error = most * gauss.decay(at, most);
                    defect.unresolved = defect.unresolved.max(error);
                }
            }
            defect.largest = (worst[0] + worst[1]) * at_ends;
            defect
        };
        let forces = [&start.f, &last.f];
        let force = miss(&trial.f, forces, of_force, 0..free);
        let velocity = if *unit_mass {
            Defect::default()
        } else {
            miss(&trial.v, [&start.v, &last.v], of_velocity, 0..free)
        };
        let of_power = of_force * size_of_first_or_nan(&last.v, free);
        let loss = miss(&trial.loss, [&start.loss, &last.loss], of_power, 0..n);
        let power =
            if free < n { loss.or(miss(&trial.f, forces, of_power, free..n)) } else { loss };
        [force, velocity, power]
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
