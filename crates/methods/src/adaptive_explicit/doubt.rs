//! The end of a step that is not taken at once: its estimate exceeds the allowed error or may be a
//! rounding, or it passes a kink.

use super::{STAGES_ROUNDINGS, Workspace};
use crate::adaptive::{End, Passage, REFUSED_ERROR, size_of_first_or_nan, size_or_nan};
use crate::commit::not_finite;
use crate::runge_kutta::Embedded;
use afterbay_core::{Curvature, Scalar, State, StepFailure, Vector};

/// Estimates below this share of the largest, relative to the allowed errors, do not count where
/// the largest may be rounding. A choice.
const SMALL_SHARE: f64 = 0.1;

impl<V: Vector> Workspace<V> {
    /// Ends the step from its stages. The allowed errors are raised to the roundings that the
    /// estimate contains. Returns the error relative to them; 0 if the estimate is a rounding.
    #[cold]
    #[inline(never)]
    pub(super) fn end_in_doubt<B, S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        passage: Passage,
    ) -> Result<f64, StepFailure>
    where
        B: Embedded,
        S: Curvature<V::Scalar> + ?Sized,
    {
        let mut errors_allowed = self.errors_allowed::<B>(state);
        if !self.smooth {
            self.allow_roundings_of_time::<B>(state.t, &mut errors_allowed);
        }
        let estimates = self.estimates::<B>();
        let mut error = self.relative_error(estimates, errors_allowed);
        if error > 1.0 {
            // The estimate for w contains roundings of the gain of w, which exceed those of w if w
            // is small at the start.
            let gain = V::Scalar::EPSILON * size_or_nan(&self.end.gain);
            let rounding = STAGES_ROUNDINGS * B::ESTIMATE_ROUNDINGS * gain;
            errors_allowed[2] = errors_allowed[2].max(rounding);
            error = self.relative_error(estimates, errors_allowed);
        }
        // A ratio that overflows is an error that is too large; numbers that are not finite give
        // NaN.
        let mut error = if error == f64::INFINITY { f64::MAX } else { error };
        if !error.is_finite() {
            let End { q, p, gain, .. } = &self.end;
            return Err(not_finite([q, p, gain].map(V::as_slice)));
        }
        if passage == Passage::Returned {
            error = error.max(REFUSED_ERROR);
        }
        if self.smooth
            && let Some(raised) =
                self.raised_to_roundings::<B>(state, error, estimates, errors_allowed)
        {
            (error, errors_allowed) = (0.0, raised);
        }
        self.end_step::<B, S>(system, h, state, error, errors_allowed)
    }

    /// The allowed errors raised to the roundings of the slopes, if an estimate is such a rounding.
    fn raised_to_roundings<B: Embedded>(
        &mut self,
        state: &State<V>,
        error: f64,
        estimates: [[f64; 3]; 2],
        errors_allowed: [f64; 3],
    ) -> Option<[f64; 3]> {
        let roundings = self.roundings_of_slopes::<B>(state);
        // Estimates below SMALL_SHARE of the largest do not count.
        let other = if error > 1.0 { 1.0 } else { SMALL_SHARE * error };
        let bounds = [0, 1, 2].map(|part| roundings[part].max(other * errors_allowed[part]));
        let known = bounds.iter().all(|bound| bound.is_finite());
        if !known || self.relative_error(estimates, bounds) > 1.0 {
            if !self.inside {
                self.roundings.end();
            }
            return None;
        }
        self.growth = if self.inside { 1.0 } else { self.roundings.accepts(self.length, error)? };
        Some([0, 1, 2].map(|part| errors_allowed[part].max(bounds[part])))
    }

    /// The largest errors of q, p and energies in an estimate that one rounding of each slope, and
    /// of the time at each stage, may cause.
    fn roundings_of_slopes<B: Embedded>(&self, state: &State<V>) -> [f64; 3] {
        let unit = B::ESTIMATE_ROUNDINGS * V::Scalar::EPSILON * self.length;
        let Self { stages, free, .. } = self;
        let size = |part: &V| size_of_first_or_nan(part, *free);
        let ends = [0, B::ROWS.len() - 1].map(|stage| stages.slopes(stage));
        let [v, f] = [0, 1].map(|part| size(ends[0][part]).max(size(ends[1][part])));
        let force = f + size(&stages.start).max(size(&stages.hq));
        let motors = ends.iter().flat_map(|[_, f]| &f.as_slice()[*free..]);
        let power = motors.fold(force * v, |most, f| most.max(f.to_f64().abs()));
        let t = state.t.to_f64().abs();
        let [by_v, by_f, by_power] = self.rates.by_time().map(|slope| t * slope);
        [v + by_v, force + by_f, power + by_f * v + by_power].map(|slope| unit * slope)
    }
}
