//! A third evaluation and correction, for steps that two do not quite solve.

use super::iteration::rises;
use super::two_corrections::{Correction, TwoCorrections, rounding_of_solution};
use super::{Equation, MOST_MISSING, Root};
use crate::numbers::{Mask, Scalar};
use crate::solver::convergence::UPDATE_ROUNDINGS;

impl<T: Scalar> TwoCorrections<T> {
    /// The solution after a third correction, equal to the bit to that of `iterate_to_rounding`.
    /// None if a lane needs more care: an inverse computed anew, a slope that may not be positive
    /// between the points, updates near the noise of F, or more corrections.
    #[inline(always)]
    pub(super) fn corrected_again(
        &mut self,
        start: T,
        equation: &mut impl Equation<T>,
    ) -> Option<Root<T>> {
        let ((_, second), seen) = (self.second?, self.points()?);
        if !self.improvable.or(self.done).all() {
            return None;
        }
        let one = T::one();
        let Correction { previous, update, missing, .. } = self.correction;
        let scale = rounding_of_solution(start, second, self.inverse, self.end);
        let done = self.done.or(self.correction.next_is_rounding(scale));
        let floored_scale = scale + T::from_f64(f64::MIN_POSITIVE);
        let rise_noise = T::from_f64(T::EPSILON.sqrt() / T::EPSILON) * floored_scale;
        let rising = rises(seen, previous, rise_noise * seen[0].slope.abs());
        let update_noise = (T::from_f64(T::EPSILON) * second.value_rounding)
            .mul_add(self.inverse.abs(), floored_scale);
        let clear = (T::from_f64(UPDATE_ROUNDINGS) * update_noise).lt(update.abs());
        if !done.or(rising.and(clear)).all() {
            return None;
        }
        if done.all() {
            return Some(self.root());
        }
        let f = equation.at(one, self.end);
        self.third = Some(f);
        let now_missing = (-f.slope).mul_add(self.inverse, one - self.inverse);
        if done.not().and(T::from_f64(MOST_MISSING).le(now_missing.abs())).any() {
            return None;
        }
        let inverse = self.inverse.mul_add(now_missing, self.inverse);
        let residual = start - self.end - f.value;
        let end = T::select(done, self.end, residual.mul_add(inverse, self.end));
        let correction = Correction {
            previous: update,
            update: residual * inverse,
            inverse_error: missing * missing,
            missing: now_missing,
        };
        let scale = rounding_of_solution(start, f, inverse, end);
        let done = done.or(correction.next_is_rounding(scale));
        done.all().then_some(Root { x: end, evaluations: 3 })
    }
}
