//! Slope arithmetic: a function's values at the two ends of an edge and its divided difference.
//!
//! Slope arithmetic gives divided differences as dual numbers give derivatives. The rule of each
//! operation has no subtraction that the operation itself does not have; with means f̄ = (f(a) +
//! f(b))/2:
//!
//! ```text
//! (f ± g)[a,b] = f[a,b] ± g[a,b]        (f g)[a,b] = f̄ g[a,b] + ḡ f[a,b]
//! (f/g)[a,b] = (f[a,b] - (f/g)(a) g[a,b])/g(b)        φ(f)[a,b] = φ[f(a), f(b)] f[a,b]
//! ```
//!
//! where [`crate::divided`] has the φ[a, b]. On an edge of width 0 the divided difference is the
//! derivative. (R. Krawczyk, A. Neumaier, SIAM J. Numer. Anal. 22 (1985);
//! T. W. Reps, L. B. Rall, Higher-Order and Symbolic Computation 16 (2003).)

use super::divided::{acos, asin, elementary as divided};
use super::line::Line;
use super::scalar::{Mask, Scalar};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// f(a), f(b) and f[a, b] of a function along the edge from a to b.
///
/// A comparison is made at both ends. If a [`Scalar::select`] takes different branches at a and b,
/// the divided difference is the plain quotient of the values. Its error is a rounding of the
/// values over the width, which changes an energy by one of its roundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope<T> {
    /// f(a)
    pub start: T,
    /// f(b)
    pub end: T,
    /// f[a, b] = (f(b) - f(a))/(b - a)
    pub slope: T,
    /// b - a; 0 for a constant.
    width: T,
}

/// A comparison at both ends of an edge.
#[derive(Clone, Copy, Debug)]
pub struct Ends<T: Scalar> {
    start: T::Mask,
    end: T::Mask,
    width: T,
}

impl<T: Scalar> Mask for Ends<T> {
    #[inline(always)]
    fn all(self) -> bool {
        self.start.all() && self.end.all()
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.start.any() || self.end.any()
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        let (start, end) = (self.start.and(other.start), self.end.and(other.end));
        Self { start, end, width: wider(self.width, other.width) }
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        let (start, end) = (self.start.or(other.start), self.end.or(other.end));
        Self { start, end, width: wider(self.width, other.width) }
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self { start: self.start.not(), end: self.end.not(), width: self.width }
    }
}

/// The width of the edge of two operands, of which one may be constant.
#[inline(always)]
fn wider<T: Scalar>(a: T, b: T) -> T {
    T::select(a.abs().le(T::zero()), b, a)
}

impl<T: Scalar> Slope<T> {
    /// The variable, from `a` to `b`.
    #[inline(always)]
    pub fn between(a: T, b: T) -> Self {
        Self { start: a, end: b, slope: T::one(), width: b - a }
    }

    /// A constant along the edge.
    #[inline(always)]
    pub fn constant(x: T) -> Self {
        Self { start: x, end: x, slope: T::zero(), width: T::zero() }
    }

    /// φ of the function, given φ at both ends and φ[start, end].
    #[inline(always)]
    fn under(self, start: T, end: T, divided: T) -> Self {
        Self { start, end, slope: divided * self.slope, width: self.width }
    }

    /// φ of the function, given φ and φ[a, b].
    #[inline(always)]
    fn by(self, function: impl Fn(T) -> T, divided: impl Fn(T, T) -> Line<T>) -> Self {
        let (start, end) = (self.start, self.end);
        self.under(function(start), function(end), divided(start, end).value)
    }

    /// (f(a) + f(b))/2
    #[inline(always)]
    fn mean(self) -> T {
        (self.start + self.end).half()
    }
}

impl<T: Scalar> Add for Slope<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            start: self.start + other.start,
            end: self.end + other.end,
            slope: self.slope + other.slope,
            width: wider(self.width, other.width),
        }
    }
}

impl<T: Scalar> Sub for Slope<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            start: self.start - other.start,
            end: self.end - other.end,
            slope: self.slope - other.slope,
            width: wider(self.width, other.width),
        }
    }
}

impl<T: Scalar> Neg for Slope<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { start: -self.start, end: -self.end, slope: -self.slope, width: self.width }
    }
}

impl<T: Scalar> Mul for Slope<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            start: self.start * other.start,
            end: self.end * other.end,
            slope: self.mean().mul_add(other.slope, other.mean() * self.slope),
            width: wider(self.width, other.width),
        }
    }
}

impl<T: Scalar> Div for Slope<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let start = self.start / other.start;
        Self {
            start,
            end: self.end / other.end,
            slope: (-start).mul_add(other.slope, self.slope) / other.end,
            width: wider(self.width, other.width),
        }
    }
}

impl<T: Scalar> AddAssign for Slope<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar> SubAssign for Slope<T> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<T: Scalar> MulAssign for Slope<T> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<T: Scalar> Scalar for Slope<T> {
    type Mask = Ends<T>;
    const LANES: usize = T::LANES;
    const EPSILON: f64 = T::EPSILON;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self::constant(T::from_f64(x))
    }
    /// The value at the end of the edge.
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.end.to_f64()
    }
    #[inline(always)]
    fn from_lanes(lane: impl FnMut(usize) -> f64) -> Self {
        Self::constant(T::from_lanes(lane))
    }
    #[inline(always)]
    fn lane(self, index: usize) -> f64 {
        self.end.lane(index)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let (start, end) = (self.start.abs(), self.end.abs());
        // If both ends are 0, the slope is that of the branch taken, as for other scalars.
        let rest = (start + end).le(T::zero());
        let divided = divided::abs(self.start, self.end).value;
        self.under(start, end, T::select(rest, T::one(), divided))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let (start, end) = (self.start.sqrt(), self.end.sqrt());
        self.under(start, end, divided::sqrt(start, end).value)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(self) -> Self {
        self.by(T::exp, divided::exp)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp_m1(self) -> Self {
        self.by(T::exp_m1, divided::exp)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn ln(self) -> Self {
        self.by(T::ln, divided::ln)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos(self) -> (Self, Self) {
        let ((s0, c0), (s1, c1)) = (self.start.sin_cos(), self.end.sin_cos());
        let (sin, cos) = divided::sin_cos(self.start, self.end);
        (self.under(s0, s1, sin.value), self.under(c0, c1, cos.value))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn atan(self) -> Self {
        self.by(T::atan, divided::atan)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn asin(self) -> Self {
        self.by(T::asin, asin)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn acos(self) -> Self {
        self.by(T::acos, acos)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sinh(self) -> Self {
        self.by(T::sinh, divided::sinh)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn cosh(self) -> Self {
        self.by(T::cosh, divided::cosh)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn tanh(self) -> Self {
        self.by(T::tanh, divided::tanh)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn floor(self) -> Self {
        let (start, end) = (self.start.floor(), self.end.floor());
        let rise = end - start;
        let same = rise.abs().le(T::zero());
        let width = T::select(same, T::one(), self.end - self.start);
        self.under(start, end, rise / width)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Ends<T> {
        let (start, end) = (self.start.lt(other.start), self.end.lt(other.end));
        Ends { start, end, width: wider(self.width, other.width) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> Ends<T> {
        let (start, end) = (self.start.le(other.start), self.end.le(other.end));
        Ends { start, end, width: wider(self.width, other.width) }
    }
    /// Whether the values and the divided difference are finite.
    #[inline(always)]
    fn is_finite(self) -> Ends<T> {
        let slope = self.slope.is_finite();
        let (start, end) = (self.start.is_finite().and(slope), self.end.is_finite().and(slope));
        Ends { start, end, width: self.width }
    }
    #[inline(always)]
    fn select(mask: Ends<T>, a: Self, b: Self) -> Self {
        let start = T::select(mask.start, a.start, b.start);
        let end = T::select(mask.end, a.end, b.end);
        let slope = T::select(mask.start, a.slope, b.slope);
        let alike = mask.start.and(mask.end).or(mask.start.not().and(mask.end.not()));
        let width = wider(wider(a.width, b.width), mask.width);
        if alike.all() {
            return Self { start, end, slope, width };
        }
        let quotient = (end - start) / width;
        Self { start, end, slope: T::select(alike, slope, quotient), width }
    }
    #[inline(always)]
    fn half(self) -> Self {
        Self {
            start: self.start.half(),
            end: self.end.half(),
            slope: self.slope.half(),
            width: self.width,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use qd::Quad;

    /// A function made of every operation, and of functions of functions.
    fn f<T: Scalar>(x: T) -> T {
        let (one, two) = (T::one(), T::from_f64(2.0));
        let (sin, cos) = (x * x).sin_cos();
        let bell = (-(x - two) * x).exp() / (one + x * x);
        let bowl = ((x + two) * (x + two) + one).sqrt() * (one + sin.abs()).ln();
        bell * cos - bowl.half() + (x * sin).atan() - (x - one).exp_m1().mul_add(x, cos) + g(x)
    }

    /// A function made of the functions that other scalars compute by those above.
    fn g<T: Scalar>(x: T) -> T {
        let share = (x - T::one()).over(5.0);
        let arcs = share.asin() * share.acos() + share.tan();
        arcs + (x * x).tanh() * x.sinh() - x.cosh() + x.cos() * x.sin() + (x + x).powi(3)
    }

    #[test]
    fn a_slope_is_the_quotient_in_more_digits() {
        for a in [-1.3, -0.2, 0.0, 0.7, 1.1] {
            for width in [0.0, 1e-300, 1e-30, -1e-14, 1e-8, -0.01, 0.3, -1.0, 2.5] {
                let b = a + width;
                let found = f(Slope::between(a, b));
                let [x, y] = [a, b].map(Quad::from_f64);
                let exact = f(Slope::between(x, y)).slope;
                // The quotient itself, where its width leaves digits, or that of a short edge.
                let (quotient, bound) = match width.abs() {
                    w if w > 1e-9 => ((f(y) - f(x)) / (y - x), 1e-20),
                    _ => {
                        let step = Quad::from_f64(1e-10);
                        ((f(x + step) - f(x - step)) / (step + step), 1e-7)
                    }
                };
                assert!((quotient - exact).abs().0 < bound, "{a} {b}: {exact:?} {quotient:?}");
                let off = (Quad::from_f64(found.slope) - exact).abs().0;
                assert!(off < 1e-14 * (1.0 + exact.0.abs()), "{a} {b}: {found:?} {exact:?}");
                for (found, exact) in [(found.start, f(a)), (found.end, f(b))] {
                    assert!((found - exact).abs() < 1e-14 * (1.0 + exact.abs()), "{found} {exact}");
                }
            }
        }
    }

    #[test]
    fn small_slopes_have_all_digits() {
        for [a, b] in [[1e-9, 2e-9], [-0.7, 0.3], [0.5, 0.5]] {
            let x = Slope::between(a, b);
            let found = [x.asin(), x.acos(), x.sinh(), x.cosh(), x.tanh()].map(|f| f.slope);
            let closed = [asin, acos, divided::sinh, divided::cosh, divided::tanh];
            assert_eq!(found, closed.map(|f| f(a, b).value));
        }
    }

    #[test]
    fn branches_differ_between_the_ends() {
        let ramp = |x: Slope<f64>| {
            let negative = x.lt(Slope::zero());
            Slope::select(negative, Slope::zero(), x * x)
        };
        assert_eq!(ramp(Slope::between(-1.0, 3.0)).slope, 9.0 / 4.0);
        assert_eq!(ramp(Slope::between(1.0, 3.0)).slope, 4.0);
        assert_eq!(ramp(Slope::between(-2.0, -1.0)).slope, 0.0);
        let step =
            |x: Slope<f64>| Slope::select(x.lt(Slope::one()).not(), Slope::one(), Slope::zero());
        assert_eq!(step(Slope::between(0.0, 4.0)).slope, 0.25);
        assert_eq!(Slope::between(0.0, 0.0).abs().slope, 1.0);
        assert_eq!(Slope::between(-1.0, 3.0).abs().slope, 0.5);
    }
}
