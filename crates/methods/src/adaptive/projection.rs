//! The projection of (q, p) onto a given value of H, which makes K exact. The motors of a drive are
//! not moved: their coordinate is the time, and their momentum the energy supplied.

use crate::kernels::reductions::{max_norm, sum, terms};
use crate::rounding::{RESTORED_ROUNDINGS, SMALL_ROUNDINGS, rounding};
use afterbay_core::{Mask, Scalar, System};

/// A projection that changes H by more than this share of its target is long. A choice.
const LONG_PROJECTION: f64 = 0.25;

/// The smallest error, relative to the allowed one, assigned to a step that is rejected because its
/// projection fails; above 1. A choice.
pub(crate) const REFUSED_ERROR: f64 = 2.0;

/// The largest change of (q, p) by which a step solved to rounding restores K: its Euclidean norm
/// as a share of the largest |q_j| or |p_j|. A choice.
pub(crate) const LARGEST_PROJECTION: f64 = 1e-8;

/// The projection of (q, p) along ∇H, scaled by the tolerances of q and p.
pub(crate) struct Projection<'a, T> {
    /// ∂H/∂q and ∂H/∂p, at (q, p) or near it
    pub(crate) slope: [&'a [T]; 2],
    /// The target value of H.
    pub(crate) target: T,
    /// The sum of the absolute terms of the target, whose rounding the projection allows.
    pub(crate) size: f64,
    /// The errors of q and p allowed in the whole run.
    pub(crate) scales: [f64; 2],
    /// The share of them allowed for this step.
    pub(crate) share: f64,
}

impl<'a, T: Scalar> Projection<'a, T> {
    /// The projection of the end (q, p) of a step that is solved to rounding. The Euclidean norm of
    /// the change is at most `relative` times the largest |q_j| or |p_j|. q and p are without
    /// motors.
    pub(crate) fn short(
        slope: [&'a [T]; 2],
        target: T,
        size: f64,
        relative: f64,
        [q, p]: [&[T]; 2],
    ) -> Self {
        let share = relative * max_norm(q).max(max_norm(p));
        Self { slope, target, size, scales: [1.0; 2], share }
    }

    /// Moves (q, p), at which H is `energy`, onto the target by the smallest change in the scaled
    /// norm. Returns whether (q, p) moved. If the change exceeds the allowed one, returns the ratio
    /// of the two as the error.
    ///
    /// Inlined: a call passes numbers through memory, which would cost an eighth of an explicit
    /// step with one degree of freedom.
    #[inline(always)]
    pub(crate) fn apply<S: System<T> + ?Sized>(
        &self,
        system: &S,
        [q, p]: [&mut [T]; 2],
        energy: &mut T,
    ) -> Result<bool, f64> {
        let [hq, hp] = self.slope;
        let n = q.len() - system.motors();
        let zero = T::zero();
        // In units of the larger scale, so that squares stay within the range of the scalar.
        let unit = self.scales[0].max(self.scales[1]);
        let squares = self.scales.map(|s| T::from_f64((s / unit) * (s / unit)));
        let [hq_free, hp_free] = [&hq[..n], &hp[..n]];
        let steep =
            sum([hq_free, hp_free], |[hq, hp]| squares[0] * (hq * hq) + squares[1] * (hp * hp));
        let mut rounding = self.rounding(n, self.slope, [q, p], *energy);
        let first = (*energy - self.target).abs().to_f64();
        let length = steep.to_f64().sqrt() / unit;
        let (mut distance, mut before) = (0.0, f64::INFINITY);
        // The derivative of H along the line: first by the given slope, then by the secant, as far
        // as the two agree.
        let (mut slope, bounds) = (steep, [steep.half(), steep + steep]);
        let (mut lambda, mut last) = (zero, zero);
        loop {
            let missing = *energy - self.target;
            let size = missing.abs().to_f64();
            // If the error no longer shrinks, it is due to the rounding of q and p.
            if size <= SMALL_ROUNDINGS * rounding
                || (size <= RESTORED_ROUNDINGS * rounding && size > 0.5 * before)
            {
                let is_long = first > LONG_PROJECTION * (self.size + self.target.abs().to_f64());
                let moved = distance > 0.0;
                let here = if moved && is_long { self.rounding_at(system, q, p) } else { rounding };
                if size <= RESTORED_ROUNDINGS * here {
                    return Ok(moved);
                }
                rounding = here;
            }
            if before.is_finite() {
                let secant = (last - missing) / lambda;
                let near = bounds[0].le(secant).all() && secant.le(bounds[1]).all();
                slope = if near { secant } else { slope };
            }
            (lambda, last) = (missing / slope, missing);
            distance += lambda.abs().to_f64() * length;
            // NaN counts as too large.
            if !(distance <= self.share && size <= 0.5 * before) {
                return Err(distance / self.share);
            }
            before = size;
            for j in 0..n {
                q[j] -= lambda * squares[0] * hq[j];
                p[j] -= lambda * squares[1] * hp[j];
            }
            *energy = system.energy(q, p);
        }
    }

    /// The rounding of H at (q, p), whose entries from n on belong to motors.
    #[inline(always)]
    fn rounding(&self, n: usize, [hq, hp]: [&[T]; 2], [q, p]: [&[T]; 2], energy: T) -> f64 {
        let supplied = p[n..].iter().fold(T::zero(), |sum, p| sum + p.abs());
        let terms = terms(&hq[..n], &q[..n]) + terms(&hp[..n], &p[..n]);
        rounding::<T>(self.size + (energy.abs() + (supplied + terms)).to_f64())
    }

    /// The rounding of H where a long projection ends: its terms may be far smaller than at the
    /// start.
    #[cold]
    fn rounding_at<S: System<T> + ?Sized>(&self, system: &S, q: &[T], p: &[T]) -> f64 {
        let [mut hq, mut hp] = [(); 2].map(|()| vec![T::zero(); q.len()]);
        system.gradient(q, p, &mut hq, &mut hp);
        self.rounding(q.len() - system.motors(), [&hq, &hp], [q, p], system.energy(q, p))
    }
}
