//! Two evaluations and two corrections: the ordinary step.

use super::{Equation, Root, Sample, is_gentle};
use crate::numbers::{Mask, Scalar};
use std::hint::cold_path;

/// Two evaluations, or the first of them, and what they show.
pub(super) struct Twice<T: Scalar> {
    pub(super) end: T,
    /// Lanes in which `end` is the solution.
    pub(super) done: T::Mask,
    /// Lanes in which the slopes are such that it may be.
    pub(super) gentle: T::Mask,
    pub(super) inverse: T,
    pub(super) residuals: [T; 2],
    pub(super) correction: Correction<T>,
    /// A rounding of `end`.
    pub(super) scale: T,
    /// Where F has been evaluated, and F there.
    pub(super) first: (T, Sample<T>),
    pub(super) second: Option<(T, Sample<T>)>,
}

impl<T: Scalar> Twice<T> {
    /// One evaluation where a second one at the same place would not do in any lane.
    #[inline(always)]
    pub(super) fn once(x: T, done: T::Mask, first: Sample<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        Self {
            end: x,
            done,
            gentle: one.lt(zero),
            inverse: one,
            residuals: [zero; 2],
            correction: Correction::none(),
            scale: zero,
            first: (x, first),
            second: None,
        }
    }

    #[inline(always)]
    pub(super) fn root(&self) -> Root<T> {
        Root { x: self.end, evaluations: 2 }
    }

    /// Where the first point is the solution, as at rest, no share of a correction is less than the
    /// other; and near rest the products of corrections may be too small for numbers.
    #[inline(always)]
    pub(super) fn rest(&mut self) {
        let none = self.correction.previous.abs().le(T::zero());
        let lost = self.correction.lost_near_rest(self.scale);
        self.done = self.done.or(self.gentle.and(none.or(lost)));
    }
}

/// Newton's correction and one with the inverse of its slope improved. At s = 1 this is `DIRECT`ly
/// from the start.
#[inline(always)]
pub(super) fn twice<T: Scalar, const DIRECT: bool>(
    s: T,
    x: T,
    start: T,
    first: Sample<T>,
    equation: &mut impl Equation<T>,
) -> Twice<T> {
    let one = T::one();
    let (inverse, rest) = (one - first.slope, first.slope * first.slope);
    let before = if DIRECT { -first.value } else { start - x - first.value };
    let (previous, middle) = (before * inverse, before.mul_add(inverse, x));
    let second = equation.at(s, middle);
    let short = one - inverse;
    let missing = (-second.slope).mul_add(inverse, short);
    let inverse = (-second.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse));
    let residual = start - middle - second.value;
    let (update, end) = (residual * inverse, residual.mul_add(inverse, middle));
    // Rounding as far as it takes the fewest operations to know, less than in `carefully`.
    let scale = T::from_f64(T::EPSILON) * second.argument_rounding.mul_add(T::one().half(), end.abs());
    let correction = Correction { previous, update, rest, missing };
    let lost = correction.lost(scale);
    let gentle = is_gentle(first.slope).and(is_gentle(missing));
    Twice {
        end,
        done: lost.and(gentle),
        gentle,
        inverse,
        residuals: [before, residual],
        correction,
        scale,
        first: (x, first),
        second: Some((middle, second)),
    }
}

/// Two corrections, one after the other.
#[derive(Clone, Copy)]
pub(super) struct Correction<T> {
    pub(super) previous: T,
    pub(super) update: T,
    pub(super) rest: T,
    pub(super) missing: T,
}

impl<T: Scalar> Correction<T> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let zero = T::zero();
        Self { previous: zero, update: zero, rest: zero, missing: zero }
    }

    /// Is the next correction less than `scale`?
    ///
    /// An error e becomes e (r + c + d): r the rest the inverse misses, c what the slope changes
    /// over e/2, d what a slope that is not quite the derivative is off by. The correction before
    /// shows them: it shrank by r + c + d, and the slope has changed by 2 c since, so that r + 2 c
    /// was missing. The next r and c are smaller by a factor, d is not. All of it times the square
    /// of the correction before, so that nothing waits for a division.
    #[inline(always)]
    pub(super) fn lost(&self, scale: T) -> T::Mask {
        let (size, largest) = (self.update.abs(), self.previous.abs());
        let off = (self.rest + self.missing).half().mul_add(-self.previous, self.update).abs();
        let contraction = self.missing.abs().mul_add(largest, size);
        let next = contraction.mul_add(contraction, off * largest) * size;
        next.lt(scale * (largest * largest))
    }

    /// The same, where the products are too small for numbers by the shares of the correction
    /// before.
    #[inline(always)]
    pub(super) fn lost_near_rest(&self, scale: T) -> T::Mask {
        let largest = self.previous.abs();
        let vanishing = (scale * (largest * largest)).lt(T::from_f64(f64::MIN_POSITIVE));
        let lost = self.lost(scale);
        if !vanishing.any() {
            return lost;
        }
        cold_path();
        let share = largest.recip();
        let shares = Self { previous: self.previous * share, update: self.update * share, ..*self };
        lost.or(vanishing.and(shares.lost(scale * share)))
    }
}
