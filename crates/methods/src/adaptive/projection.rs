//! K made exact by a small change of (q, p).

use afterbay_core::{Scalar, System};

/// Roundings of K that are not corrected, and those that are left where corrections change nothing.
const ROUNDINGS: [f64; 2] = [2.0, 16.0];

/// A change of (q, p) along ∇H, scaled by what is allowed of q and p.
pub(crate) struct Projection<'a, T> {
    /// ∂H/∂q and ∂H/∂p, at (q, p) or next to it
    pub(crate) slope: [&'a [T]; 2],
    /// What H should be.
    pub(crate) target: T,
    /// The largest number among those that the target is made of.
    pub(crate) size: f64,
    /// What is allowed of q and p in the whole run, and how much of that in this step.
    pub(crate) scales: [f64; 2],
    pub(crate) allowed: f64,
}

impl<T: Scalar> Projection<'_, T> {
    /// Moves (q, p), where H is `energy`, by the smallest change that makes it the target, in units
    /// of what is allowed, and tells whether they moved. Where it would be more than allowed, how
    /// much more.
    #[inline]
    pub(crate) fn apply<S: System<T> + ?Sized>(
        &self,
        system: &S,
        [q, p]: [&mut [T]; 2],
        energy: &mut T,
    ) -> Result<bool, f64> {
        let [hq, hp] = self.slope;
        let n = q.len();
        let zero = T::zero();
        let (mut steep, mut terms) = (zero, zero);
        let squares = self.scales.map(|s| T::from_f64(s * s));
        for j in 0..n {
            steep += squares[0] * (hq[j] * hq[j]) + squares[1] * (hp[j] * hp[j]);
            terms += (hq[j] * q[j]).abs() + (hp[j] * p[j]).abs();
        }
        let rounding = T::EPSILON * (self.size + (energy.abs() + terms).to_f64());
        let (mut way, mut before) = (0.0, f64::INFINITY);
        loop {
            let missing = *energy - self.target;
            let size = missing.abs().to_f64();
            // What no longer shrinks is as good as q and p can be told.
            if size <= ROUNDINGS[0] * rounding
                || (size <= ROUNDINGS[1] * rounding && size > 0.5 * before)
            {
                return Ok(way > 0.0);
            }
            way += size / steep.to_f64().sqrt();
            // Not a number is too large as well.
            if !(way <= self.allowed && size <= 0.5 * before) {
                return Err(way / self.allowed);
            }
            before = size;
            let lambda = missing / steep;
            for j in 0..n {
                q[j] -= lambda * squares[0] * hq[j];
                p[j] -= lambda * squares[1] * hp[j];
            }
            *energy = system.energy(q, p);
        }
    }
}
