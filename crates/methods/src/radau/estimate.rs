//! The estimate of the error of a step.
//!
//! The embedded method of order S has one more stage, the start of the step, with the weight μ, the
//! real eigenvalue of A. It differs from the Radau method by `h μ (z'(0) - Σ ℓ_i(0) z'_i)`. This is
//! the slope at the start less that of the collocation polynomial there, times h μ. The difference
//! is filtered by the matrix 1 - h μ J (Hairer, Wanner II, (8.17) to (8.20)), where J is the
//! Jacobian of (q', p', w').
//!
//! The error of order S+1 is raised to the order 2 S of the step, as RADAU does with its tolerance
//! (J. Comput. Appl. Math. 111 (1999) 93-111). This is right for modes that the step resolves and
//! for fast modes that decay, if they are of the size of the solution. In two cases the error is
//! larger:
//!
//! - A fast oscillation does not decay, but the step damps it. The difference is then about its
//!   amplitude, whatever h is.
//! - A component is small, as an oscillation of small amplitude or a friction that turns around
//!   within the step. A difference that is raised relative to the size of the solution
//!   underestimates it. The decrease ρ of the last Legendre coefficients of the slopes of p or w
//!   shows how well the step resolves it:
//!
//!   ```text
//!   error = C ρ^((S-1)/2) times the difference   C = 10 (S = 5), 60 (S = 7)
//!   ```
//!
//!   of an oscillation, within a factor of 3 for hω ≤ 8 and any phase. Three stages have too few
//!   coefficients. This does not count where the filter has divided the difference by 4, as most
//!   of it then decays within the step, or where roundings of q and p may have caused it: their
//!   coefficients do not decrease, however short the step is.

use super::component::Component;
use super::engine::Engine;
use super::share::{Allowed, power};
use super::stages::Point;
use afterbay_core::{Scalar, State, System, Vector, larger_or_nan};

/// The factor by which the estimate is multiplied before it is raised to the order of the step. Its
/// value is that of RADAU. Most systems of the test set would need a tenth of it. A long chain
/// whose fast waves are driven smoothly needs it, since the error of such waves has the order S+1
/// of the estimate.
const CAUTION: f64 = 10.0;

/// The largest factor by which the difference is multiplied where the step does not resolve the
/// slopes at all. A choice.
const UNRESOLVED: f64 = 10.0;

impl<V: Vector, const S: usize> Engine<V, S> {
    /// Estimates the errors of q, p and w, and returns the largest relative to the allowed one.
    /// Across a kink the step is of no higher order than the estimate.
    #[inline(always)]
    pub(super) fn estimate(&mut self, h: V::Scalar, allowed: Allowed, smooth: bool) -> f64 {
        let Self { tables, trial, equations, start, errors, dissipative, .. } = self;
        let [of_q, of_p, raw_of_w] = errors.each_mut().map(V::as_mut_slice);
        let Point { v, f, d: drag, loss, .. } = start;
        let n = V::LEN.unwrap_or(of_q.len());
        let scale = h * V::Scalar::from_f64(tables.eigenvalue);
        let step = scale.to_f64();
        let raw = |at: &V, slopes: &[V; S], d: usize| {
            let terms = tables.start.iter().zip(slopes);
            let difference = terms.fold(at.as_slice()[d], |difference, (&start, slope)| {
                (-start).mul_add(slope.as_slice()[d], difference)
            });
            (scale * difference).to_f64()
        };
        let (shares, of_energies) = (allowed.shares(), allowed.scales[2].recip());
        let (mut most, mut poison) = ([0.0_f64; 3], 0.0);
        let (mut of_oscillations, mut rough) = (0.0_f64, 0.0_f64);
        equations.filter(
            tables,
            n,
            |d| [raw(v, &trial.v, d), raw(f, &trial.f, d)],
            |d, [a, b, friction]| {
                let [share_q, share_p] = shares(d);
                let [raw_a, raw_b] = [raw(v, &trial.v, d), raw(f, &trial.f, d)];
                let friction = step * friction;
                let mut ratio = tables.roughness(&trial.f, d, raw_b / step);
                let (mut c, mut raw_c) = (0.0, 0.0);
                if *dissipative {
                    // The power D v changes with v and with D.
                    let by_v = (a - raw_a) * drag.as_slice()[d].to_f64();
                    let by_d = friction * v.as_slice()[d].to_f64();
                    raw_c = raw(loss, &trial.loss, d);
                    c = raw_c + by_v + by_d;
                    ratio = ratio.max(tables.roughness(&trial.loss, d, raw_c / step));
                }
                let mut largest = 0.0_f64;
                for ((most, x), share) in
                    most.iter_mut().zip([a, b, c]).zip([share_q, share_p, of_energies])
                {
                    let x = x.abs() * share;
                    *most = if x > *most { x } else { *most };
                    largest = largest.max(x);
                    poison += 0.0 * x;
                }
                let component = Component {
                    raw: [raw_a * share_q, raw_b * share_p],
                    filtered: [a * share_q, b * share_p],
                    friction: friction * share_p,
                };
                if component.oscillates(tables.eigenvalue) {
                    of_oscillations = of_oscillations.max(largest);
                }
                if !component.decays() && !component.is_noise(largest, allowed.rounding) {
                    rough = rough.max(largest * Self::of_roughness(ratio));
                }
                for (to, x) in [&mut *of_q, of_p, raw_of_w].into_iter().zip([a, b, raw_c]) {
                    to[d] = V::Scalar::from_f64(x);
                }
            },
        );
        let order = if smooth { Self::RAISED.recip() } else { 1.0 };
        let unraised = |error: f64| bounded(power(error / allowed.share, order));
        self.oscillation = unraised(of_oscillations);
        let error = if smooth {
            Self::raised(most, allowed).max(bounded(rough / allowed.share))
        } else {
            unraised(most.into_iter().fold(0.0, f64::max))
        };
        error.max(self.oscillation) + poison
    }

    /// The error over the difference, C ρ^((S-1)/2), from ρ².
    #[inline(always)]
    fn of_roughness(ratio: f64) -> f64 {
        let factor = if S == 5 { 10.0 * ratio } else { 60.0 * (ratio * ratio.sqrt()) };
        factor.min(UNRESOLVED)
    }

    /// The order of the estimate over that of the step.
    const RAISED: f64 = (S + 1) as f64 / (2 * S) as f64;

    /// The error relative to the allowed one, from estimates of order S+1 in units of the scales.
    #[inline(always)]
    fn raised(estimates: [f64; 3], allowed: Allowed) -> f64 {
        let ratios = estimates.into_iter().zip(allowed.relative).map(|(estimate, relative)| {
            CAUTION * estimate * relative / power(relative * allowed.share, Self::RAISED)
        });
        let most = ratios.fold(0.0, larger_or_nan);
        bounded(power(most, Self::RAISED.recip()))
    }

    /// Estimates the errors again, with the slopes at the start moved by the first estimate. The
    /// estimate then vanishes for fast components that decay and are not resolved. It would vanish
    /// for fast oscillations, too, whose first estimate remains.
    #[cold]
    pub(super) fn estimate_again<F: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
        allowed: Allowed,
        smooth: bool,
    ) -> f64 {
        let Self { at, errors, moved, dissipative, .. } = self;
        for ((to, from), by) in at.iter_mut().zip([&state.q, &state.p]).zip(&*errors) {
            let steps = from.as_slice().iter().zip(by.as_slice());
            for (to, (&from, &by)) in to.as_mut_slice().iter_mut().zip(steps) {
                *to = from + by;
            }
        }
        moved.evaluate_slopes(system, *dissipative, &at[0], &at[1]);
        let of_oscillations = self.oscillation;
        std::mem::swap(&mut self.start, &mut self.moved);
        let error = self.estimate(h, allowed, smooth);
        std::mem::swap(&mut self.start, &mut self.moved);
        larger_or_nan(error, of_oscillations)
    }
}

/// An error that overflows is too large, whatever its size.
#[inline(always)]
fn bounded(error: f64) -> f64 {
    if error == f64::INFINITY { f64::MAX } else { error }
}
