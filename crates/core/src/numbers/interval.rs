//! Intervals of `f64` rounded outward: enclosures of values over a range of arguments.
//!
//! The result of every operation contains the results for all points of its operands. If an operand
//! reaches a singularity or an overflow, the result is [`Interval::WHOLE`]. Every operation on
//! `WHOLE` gives `WHOLE` again, bounded functions included, so that the final result shows a
//! singularity of any intermediate one ([`Scalar::is_finite`]).
//!
//! Sums, products, quotients and roots are widened by one unit in the last place where they are
//! not exact, [`Scalar::mul_add`] by up to two. Functions of the standard library are widened by
//! [`LIBRARY_ULPS`] units.
//! (R. E. Moore, R. B. Kearfott, M. J. Cloud, *Introduction to Interval Analysis*, SIAM 2009.)

use super::scalar::{Mask, Scalar};
use super::two_sum::two_sum;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// The bound assumed for the errors of exp, exp_m1, ln, sin, cos and atan of the standard library,
/// in units in the last place. Measured errors are below 1.
const LIBRARY_ULPS: u32 = 3;

/// The largest angle, in radians, whose quadrant is determined; sine and cosine of larger ones are
/// enclosed by [-1, 1].
const LARGEST_ANGLE: f64 = 1e9;

/// All numbers between two bounds, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    low: f64,
    high: f64,
}

/// The outcome of a comparison of intervals: whether it holds for all of their points, and whether
/// it holds for some. If only for some, it is undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Certainty {
    certain: bool,
    possible: bool,
}

impl Mask for Certainty {
    /// Whether the comparison holds for all points.
    fn all(self) -> bool {
        self.certain
    }
    /// Whether the comparison holds for some points.
    fn any(self) -> bool {
        self.possible
    }
    fn and(self, other: Self) -> Self {
        Self { certain: self.certain && other.certain, possible: self.possible && other.possible }
    }
    fn or(self, other: Self) -> Self {
        Self { certain: self.certain || other.certain, possible: self.possible || other.possible }
    }
    fn not(self) -> Self {
        Self { certain: !self.possible, possible: !self.certain }
    }
}

/// `x` moved down by `count` units in the last place.
fn down(x: f64, count: u32) -> f64 {
    (0..count).fold(x, |x, _| x.next_down())
}

/// `x` moved up by `count` units in the last place.
fn up(x: f64, count: u32) -> f64 {
    (0..count).fold(x, |x, _| x.next_up())
}

/// a b and the sign of its rounding error; NaN where that is not known, near underflow.
fn product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let known = (product.abs() >= 1e-280) | (a == 0.0) | (b == 0.0);
    (product, if known { a.mul_add(b, -product) } else { f64::NAN })
}

/// a / b and the sign of its rounding error; NaN where that is not known, near underflow.
fn quotient(a: f64, b: f64) -> (f64, f64) {
    let quotient = a / b;
    if a == 0.0 {
        return (0.0, 0.0);
    }
    if quotient.abs() < 1e-280 || a.abs() < 1e-280 {
        return (quotient, f64::NAN);
    }
    let rest = (-quotient).mul_add(b, a);
    (quotient, if b < 0.0 { -rest } else { rest })
}

/// A lower bound of `value` plus an error of this sign.
///
/// The sign of a rounding error is practically random, so the processor would mispredict a branch
/// on it half the time. The next lower number is therefore always computed, and used where it is
/// needed.
#[inline]
fn below((value, error): (f64, f64)) -> f64 {
    let bits = if value == 0.0 { (-0.0_f64).to_bits() } else { value.to_bits() };
    // One unit towards 0 for a positive number, away from it for a negative one.
    let unit = if value > 0.0 { -1 } else { 1 };
    let lowered = f64::from_bits(bits.wrapping_add_signed(unit));
    if (error >= 0.0) | !value.is_finite() { value } else { lowered }
}

/// An upper bound of `value` plus an error of this sign.
#[inline]
fn above((value, error): (f64, f64)) -> f64 {
    -below((-value, -error))
}

/// A lower bound of a b + c.
///
/// The rounding errors of the product and of the sum are added to the sum. If a b and c cancel,
/// these errors may exceed one unit in the last place of the sum.
#[inline]
fn product_below((a, b): (f64, f64), c: f64) -> f64 {
    let (product, error) = product(a, b);
    let [sum, lost] = two_sum(product, c);
    let error = error + lost;
    if error == 0.0 {
        sum
    } else if error.is_finite() {
        below((sum + error, -1.0))
    } else {
        below(two_sum(below((product, f64::NAN)), c).into())
    }
}

impl Interval {
    /// All real numbers. It is the result where an operand contains a singularity.
    pub const WHOLE: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// The interval between two numbers, in any order. It is [`Interval::WHOLE`] where one of them
    /// is not finite.
    pub fn new(a: f64, b: f64) -> Self {
        if a.is_nan() || b.is_nan() { Self::WHOLE } else { Self::bounded(a.min(b), a.max(b)) }
    }

    /// The interval with these bounds; `WHOLE` if a bound is infinite or NaN.
    fn bounded(low: f64, high: f64) -> Self {
        if low.is_finite() && high.is_finite() { Self { low, high } } else { Self::WHOLE }
    }

    /// The lower bound.
    pub fn low(self) -> f64 {
        self.low
    }

    /// The upper bound.
    pub fn high(self) -> f64 {
        self.high
    }

    /// The distance of the bounds, rounded to nearest.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// The largest absolute value of its points.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Whether the interval contains x.
    pub fn contains(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    /// Whether both bounds are finite. If not, the interval is `WHOLE`.
    pub fn is_bounded(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The two pairs of bounds, one bound of each interval, with the least and the largest product;
    /// `None` if both intervals contain numbers of both signs.
    #[inline]
    fn ends(self, other: Self) -> Option<[(f64, f64); 2]> {
        if self.low >= 0.0 {
            let least = if other.low >= 0.0 { self.low } else { self.high };
            let most = if other.high >= 0.0 { self.high } else { self.low };
            Some([(least, other.low), (most, other.high)])
        } else if self.high <= 0.0 {
            let least = if other.high >= 0.0 { self.low } else { self.high };
            let most = if other.low >= 0.0 { self.high } else { self.low };
            Some([(least, other.high), (most, other.low)])
        } else if other.low >= 0.0 || other.high <= 0.0 {
            other.ends(self)
        } else {
            None
        }
    }

    /// The least interval that contains both.
    pub(crate) fn hull(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The squares of its points, none of which is negative. A product treats its operands as
    /// independent and would be wider.
    pub fn square(self) -> Self {
        let size = self.abs();
        let (least, most) = (product(size.low, size.low), product(size.high, size.high));
        Self::bounded(below(least).max(0.0), above(most))
    }

    /// The values of an increasing function of the standard library, which lie in [least, most].
    fn increasing(self, f: impl Fn(f64) -> f64, [least, most]: [f64; 2]) -> Self {
        if !self.is_bounded() {
            return Self::WHOLE;
        }
        let (low, high) = (down(f(self.low), LIBRARY_ULPS), up(f(self.high), LIBRARY_ULPS));
        Self::bounded(low.max(least), high.min(most))
    }

    /// The values of a function of period 2π that is 1 at `top` + 2πk, -1 half a period later, and
    /// monotone between. `ends` are its values at the bounds.
    fn wave(self, ends: [f64; 2], top: f64) -> Self {
        let turns = |x: f64, from: f64| (x - from) / (2.0 * PI);
        // An extremum is counted if it may be inside.
        let reached = |from: f64| {
            let slack = 1e-6;
            (turns(self.high, from) + slack).floor() >= (turns(self.low, from) - slack).ceil()
        };
        let (low, high) =
            (down(ends[0].min(ends[1]), LIBRARY_ULPS), up(ends[0].max(ends[1]), LIBRARY_ULPS));
        Self {
            low: if reached(top + PI) { -1.0 } else { low.max(-1.0) },
            high: if reached(top) { 1.0 } else { high.min(1.0) },
        }
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::bounded(
            below(two_sum(self.low, other.low).into()),
            above(two_sum(self.high, other.high).into()),
        )
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if !(self.is_bounded() && other.is_bounded()) {
            return Self::WHOLE;
        }
        if let Some([least, most]) = self.ends(other) {
            return Self::bounded(below(product(least.0, least.1)), above(product(most.0, most.1)));
        }
        let least = [product(self.low, other.high), product(self.high, other.low)].map(below);
        let most = [product(self.low, other.low), product(self.high, other.high)].map(above);
        Self::bounded(least[0].min(least[1]), most[0].max(most[1]))
    }
}

impl Div for Interval {
    type Output = Self;
    /// [`Interval::WHOLE`] where the divisor contains 0.
    fn div(self, other: Self) -> Self {
        if other.contains(0.0) || !(self.is_bounded() && other.is_bounded()) {
            return Self::WHOLE;
        }
        let corners = [
            quotient(self.low, other.low),
            quotient(self.low, other.high),
            quotient(self.high, other.low),
            quotient(self.high, other.high),
        ];
        let low = corners.iter().fold(f64::INFINITY, |low, &x| low.min(below(x)));
        let high = corners.iter().fold(f64::NEG_INFINITY, |high, &x| high.max(above(x)));
        Self::bounded(low, high)
    }
}

impl AddAssign for Interval {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Interval {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Interval {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Scalar for Interval {
    type Mask = Certainty;
    const EPSILON: f64 = <f64 as Scalar>::EPSILON;

    /// The point; [`Interval::WHOLE`] where it is not finite.
    fn from_f64(x: f64) -> Self {
        Self::bounded(x, x)
    }
    /// The middle; NaN for `WHOLE`.
    fn to_f64(self) -> f64 {
        if self.is_bounded() { 0.5 * self.low + 0.5 * self.high } else { f64::NAN }
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        if !(self.is_bounded() && a.is_bounded() && b.is_bounded()) {
            return Self::WHOLE;
        }
        let Some([least, most]) = self.ends(a) else { return self * a + b };
        let high = -product_below((-most.0, most.1), -b.high);
        Self::bounded(product_below(least, b.low), high)
    }
    fn abs(self) -> Self {
        if self.low >= 0.0 || !self.is_bounded() {
            self
        } else if self.high <= 0.0 {
            -self
        } else {
            Self { low: 0.0, high: self.magnitude() }
        }
    }
    /// [`Interval::WHOLE`] where a point is negative.
    fn sqrt(self) -> Self {
        if self.low < 0.0 || !self.is_bounded() {
            return Self::WHOLE;
        }
        let root = |x: f64| {
            let root = x.sqrt();
            let known = x == 0.0 || x > 1e-280;
            (root, if known { (-root).mul_add(root, x) } else { f64::NAN })
        };
        Self { low: below(root(self.low)).max(0.0), high: above(root(self.high)) }
    }
    fn exp(self) -> Self {
        self.increasing(f64::exp, [0.0, f64::INFINITY])
    }
    fn exp_m1(self) -> Self {
        self.increasing(f64::exp_m1, [-1.0, f64::INFINITY])
    }
    /// [`Interval::WHOLE`] where a point is not positive.
    fn ln(self) -> Self {
        if self.low <= 0.0 {
            return Self::WHOLE;
        }
        self.increasing(f64::ln, [f64::NEG_INFINITY, f64::INFINITY])
    }
    fn sin_cos(self) -> (Self, Self) {
        if !self.is_bounded() {
            return (Self::WHOLE, Self::WHOLE);
        }
        if self.magnitude() > LARGEST_ANGLE {
            return (Self { low: -1.0, high: 1.0 }, Self { low: -1.0, high: 1.0 });
        }
        let ((s0, c0), (s1, c1)) = (self.low.sin_cos(), self.high.sin_cos());
        (self.wave([s0, s1], FRAC_PI_2), self.wave([c0, c1], 0.0))
    }
    fn atan(self) -> Self {
        self.increasing(f64::atan, [-FRAC_PI_2.next_up(), FRAC_PI_2.next_up()])
    }
    fn floor(self) -> Self {
        Self { low: self.low.floor(), high: self.high.floor() }
    }
    fn lt(self, other: Self) -> Certainty {
        Certainty { certain: self.high < other.low, possible: self.low < other.high }
    }
    fn le(self, other: Self) -> Certainty {
        Certainty { certain: self.high <= other.low, possible: self.low <= other.high }
    }
    /// Certain if the interval is bounded, else impossible.
    fn is_finite(self) -> Certainty {
        Certainty { certain: self.is_bounded(), possible: self.is_bounded() }
    }
    /// The hull of both where the mask is undecided.
    fn select(mask: Certainty, a: Self, b: Self) -> Self {
        match (mask.certain, mask.possible) {
            (true, _) => a,
            (false, false) => b,
            (false, true) => a.hull(b),
        }
    }
}

#[cfg(test)]
mod tests;
