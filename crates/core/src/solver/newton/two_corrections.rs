//! Two evaluations and two corrections, which solve the equation of an ordinary step.

use super::{Equation, Point, Root, Sample, can_be_improved};
use crate::numbers::{Mask, Scalar};

/// Two evaluations, or only the first, with the corrections computed from them.
pub(super) struct TwoCorrections<T: Scalar> {
    /// x after both corrections.
    pub(super) end: T,
    /// Lanes in which `end` is the solution.
    pub(super) done: T::Mask,
    /// Lanes in which the inverse slope could be improved by multiplications.
    pub(super) improvable: T::Mask,
    pub(super) inverse: T,
    pub(super) residuals: [T; 2],
    pub(super) correction: Correction<T>,
    /// The rounding error of `end`.
    pub(super) scale: T,
    /// The points at which F was evaluated, and F there.
    pub(super) first: (T, Sample<T>),
    pub(super) second: Option<(T, Sample<T>)>,
    /// F at `end`, once it is evaluated there.
    pub(super) third: Option<Sample<T>>,
}

impl<T: Scalar> TwoCorrections<T> {
    /// A single evaluation, for slopes that allow no second correction with an improved inverse.
    #[inline(always)]
    pub(super) fn once(x: T, done: T::Mask, first: Sample<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        Self {
            end: x,
            done,
            improvable: one.lt(zero),
            inverse: one,
            residuals: [zero; 2],
            correction: Correction::none(),
            scale: zero,
            first: (x, first),
            second: None,
            third: None,
        }
    }

    #[inline(always)]
    pub(super) fn root(&self) -> Root<T> {
        Root { x: self.end, evaluations: 2 }
    }

    /// The points of both evaluations; none of a single one.
    #[inline(always)]
    pub(super) fn points(&self) -> Option<[Point<T>; 2]> {
        let (one, (x, first), (middle, second)) = (T::one(), self.first, self.second?);
        let [before, residual] = self.residuals;
        Some([
            Point { x, slope: one + first.slope, residual: before },
            Point { x: middle, slope: one + second.slope, residual },
        ])
    }

    /// Marks lanes that are done at rest, where the first point is the solution and both
    /// corrections are 0.
    #[inline(always)]
    pub(super) fn accept_at_rest(&mut self) {
        let none = self.correction.previous.abs().le(T::zero());
        self.done = self.done.or(self.improvable.and(none));
    }
}

/// A correction with the slope at x and one with an improved inverse slope. `DIRECT` states that x
/// is `start` and s = 1.
#[inline(always)]
pub(super) fn two_corrections<T: Scalar, const DIRECT: bool>(
    s: T,
    x: T,
    start: T,
    first: Sample<T>,
    equation: &mut impl Equation<T>,
) -> TwoCorrections<T> {
    let one = T::one();
    let FirstInverse { inverse, inverse_error } = FirstInverse::of(first.slope);
    let before = if DIRECT { -first.value } else { start - x - first.value };
    let (previous, middle) = (before * inverse, before.mul_add(inverse, x));
    let second = equation.at(s, middle);
    let short = one - inverse;
    let missing = (-second.slope).mul_add(inverse, short);
    let inverse = (-second.slope).mul_add(inverse * inverse, inverse.mul_add(short, inverse));
    let residual = start - middle - second.value;
    let (update, end) = (residual * inverse, residual.mul_add(inverse, middle));
    // A lower bound of the rounding error, by fewer operations than `rounding_of_solution`.
    let scale =
        T::from_f64(T::EPSILON) * second.argument_rounding.mul_add(T::one().half(), end.abs());
    let correction = Correction { previous, update, inverse_error, missing };
    let converged = correction.next_is_rounding(scale);
    let improvable = can_be_improved(first.slope).and(can_be_improved(missing));
    TwoCorrections {
        end,
        done: converged.and(improvable),
        improvable,
        inverse,
        residuals: [before, residual],
        correction,
        scale,
        first: (x, first),
        second: Some((middle, second)),
        third: None,
    }
}

/// The rounding error of x, without that of F ([the criterion](super)), by the sample that was
/// taken before the last correction and the inverse slope of that correction.
#[inline(always)]
pub(super) fn rounding_of_solution<T: Scalar>(start: T, f: Sample<T>, inverse: T, x: T) -> T {
    T::from_f64(T::EPSILON) * (start.abs() + f.argument_rounding).mul_add(inverse.abs(), x.abs())
}

/// The first approximation of the inverse slope 1/(1 + F'), which needs no division.
///
/// ```text
/// y = (1 - F') (1 + F'²) = (1 - F'⁴)/(1 + F')
/// ```
///
/// Two corrections then suffice on a linear equation up to F' = 0.04, with 1 - F' alone up to
/// 0.002.
pub(super) struct FirstInverse<T> {
    /// y
    pub(super) inverse: T,
    /// 1 - (1 + F') y
    pub(super) inverse_error: T,
}

impl<T: Scalar> FirstInverse<T> {
    #[inline(always)]
    pub(super) fn of(slope: T) -> Self {
        let (plain, square) = (T::one() - slope, slope * slope);
        Self { inverse: plain.mul_add(square, plain), inverse_error: square * square }
    }
}

/// Two successive corrections.
#[derive(Clone, Copy)]
pub(super) struct Correction<T> {
    /// The correction before the last.
    pub(super) previous: T,
    /// The last correction.
    pub(super) update: T,
    /// 1 - (1 + F') y at the first of the two points, with the inverse slope y used there.
    pub(super) inverse_error: T,
    /// 1 - (1 + F') y at the second point, with the same y.
    pub(super) missing: T,
}

impl<T: Scalar> Correction<T> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let zero = T::zero();
        Self { previous: zero, update: zero, inverse_error: zero, missing: zero }
    }

    /// Whether the next correction is less than `scale`, the rounding of x.
    ///
    /// A correction turns an error e into e (r + c + d), with r the error of the inverse, c the
    /// change of the slope over e/2, and d the error of a slope that is not quite the derivative.
    /// The ratio of the last two corrections is r + c + d, and the error of the inverse at the last
    /// slope is r + 2 c. For the next correction r and c are smaller by that ratio, and d is the
    /// same. All are taken relative to the previous correction, so that none of them underflows
    /// near rest. If the previous correction is 0, the result is false.
    #[inline(always)]
    pub(super) fn next_is_rounding(&self, scale: T) -> T::Mask {
        let share = self.previous.recip();
        let ratio = self.update * share;
        let off = (ratio - (self.inverse_error + self.missing).half()).abs();
        let contraction = self.missing.abs() + ratio.abs();
        let next = contraction.mul_add(contraction, off) * ratio.abs();
        next.lt((scale * share).abs())
    }
}
