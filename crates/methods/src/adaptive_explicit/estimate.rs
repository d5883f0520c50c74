//! The error estimate of an explicit step, from the differences of its weights and embedded ones.

use super::Workspace;
use crate::kernels::reductions::largest_if_finite;
use crate::runge_kutta::{Embedded, P, Q, Terms, W};
use afterbay_core::{Vector, larger_or_nan};

/// The weight of the squared ratio of two error estimates in their combination (Hairer, Nørsett,
/// Wanner, II.10).
const RATIO_WEIGHT: f64 = 0.01;
/// The factor of an estimate across a kink, of which the stages may see too little: at one place of
/// a hundred, between two stages, the error is more than ten times the estimate. A choice.
pub(super) const KINK_CAUTION: f64 = 10.0;

impl<V: Vector> Workspace<V> {
    /// The errors of q, p and energies over h by each estimate of the tableau. With one estimate,
    /// as near a kink, the second is 0.
    #[inline(always)]
    pub(super) fn estimates<B: Embedded>(&self) -> [[f64; 3]; 2] {
        if self.near_kink {
            return [self.estimate_at_kinks::<B>(), [0.0; 3]];
        }
        let second = B::DIFFERENCES.get(1).map_or([0.0; 3], |terms| self.difference(terms));
        [self.difference(B::DIFFERENCES[0]), second]
    }

    /// The largest errors over h by the estimates that see kinks.
    #[cold]
    #[inline(never)]
    fn estimate_at_kinks<B: Embedded>(&self) -> [f64; 3] {
        let fine = self.difference(B::DIFFERENCES[0]);
        let Some(terms) = B::DIFFERENCES_AT_KINKS else { return fine };
        let other = self.difference(terms);
        [0, 1, 2].map(|part| larger_or_nan(fine[part], other[part]))
    }

    /// The distances in q, p and energies of two ends of the step with these differences of
    /// weights, over h. NaN for those that are not finite.
    #[inline(always)]
    fn difference(&self, terms: Terms) -> [f64; 3] {
        let (stages, all) = (&self.stages, V::LEN.unwrap_or(self.end.q.as_slice().len()));
        let w = if stages.is_dissipative() { stages.largest_sum::<W>(terms, 0..all) } else { 0.0 };
        if self.free < all {
            return self.difference_of_driven(terms, w);
        }
        [stages.largest_sum::<Q>(terms, 0..all), stages.largest_sum::<P>(terms, 0..all), w]
    }

    /// Computes [`Self::difference`] for a system with motors, whose momenta are energies.
    #[inline(never)]
    fn difference_of_driven(&self, terms: Terms, w: f64) -> [f64; 3] {
        let Self { stages, free, .. } = self;
        let q = stages.largest_sum::<Q>(terms, 0..*free);
        let p = stages.largest_sum::<P>(terms, 0..*free);
        let supplied = stages.largest_sum::<P>(terms, *free..self.end.p.as_slice().len());
        [q, p, larger_or_nan(w, supplied)]
    }

    /// The error of the step relative to the errors allowed, given its estimates. NaN if a number
    /// is not finite. Two estimates are combined to one of higher order only where the solution is
    /// smooth.
    #[inline(always)]
    pub(super) fn relative_error(&self, estimates: [[f64; 3]; 2], errors_allowed: [f64; 3]) -> f64 {
        let shares = errors_allowed.map(|allowed| allowed.recip().min(f64::MAX));
        let [fine, coarse] = estimates
            .map(|[q, p, w]| largest_if_finite([q * shares[0], p * shares[1], w * shares[2]]));
        if !self.smooth {
            return KINK_CAUTION * self.length * fine;
        }
        if coarse == 0.0 || fine == 0.0 {
            return self.length * fine;
        }
        let ratio = coarse / fine;
        self.length * fine / (1.0 + RATIO_WEIGHT * ratio * ratio).sqrt()
    }
}
