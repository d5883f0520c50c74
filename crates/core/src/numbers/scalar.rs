//! The trait of the numbers that systems and methods compute with.
//!
//! Comparisons give a [`Mask`], and branches on values are a [`Scalar::select`], so that a scalar
//! may hold several numbers in SIMD lanes.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// The outcome of a comparison: one truth value for each number a [`Scalar`] holds.
pub trait Mask: Copy {
    /// Whether it is true in every lane.
    fn all(self) -> bool;
    /// Whether it is true in at least one lane.
    fn any(self) -> bool;
    /// True where both masks are.
    fn and(self, other: Self) -> Self;
    /// True where at least one mask is.
    fn or(self, other: Self) -> Self;
    /// True where the mask is not.
    fn not(self) -> Self;
}

impl Mask for bool {
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn not(self) -> Self {
        !self
    }
}

/// A real number, or several in SIMD lanes.
///
/// It has the functions of the expressions in scenes; min and max are a [`Scalar::select`].
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// The outcome of a comparison.
    type Mask: Mask;

    /// The number of lanes.
    const LANES: usize = 1;

    /// The unit roundoff: the largest relative error of a sum or product.
    const EPSILON: f64;

    /// Whether the numbers have more digits than `f64`.
    const IS_EXTENDED: bool = Self::EPSILON < f64::EPSILON / 4.0;

    /// `x`, without rounding.
    fn from_f64(x: f64) -> Self;

    /// The nearest `f64` (of the real part, of the first lane), for messages and tables.
    fn to_f64(self) -> f64;

    /// The number whose lanes are `lane(0)`, `lane(1)`, ..
    #[inline(always)]
    fn from_lanes(mut lane: impl FnMut(usize) -> f64) -> Self {
        Self::from_f64(lane(0))
    }

    /// The nearest `f64` (of the real part) of one lane, counted from 0.
    #[inline(always)]
    fn lane(self, _index: usize) -> f64 {
        self.to_f64()
    }

    /// The number, read in one piece. Without this function the compiler copies eight lanes in two
    /// halves, and the next operation on all of them waits for both.
    #[inline(always)]
    fn read(&self) -> Self {
        *self
    }

    /// `self · a + b`, with one rounding where the hardware has it.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// |self|
    fn abs(self) -> Self;
    /// √self
    fn sqrt(self) -> Self;
    /// e^self
    fn exp(self) -> Self;
    /// e^self - 1, accurate near 0.
    fn exp_m1(self) -> Self;
    /// ln self
    fn ln(self) -> Self;
    /// sin self and cos self.
    fn sin_cos(self) -> (Self, Self);
    /// The angle between -π/2 and π/2 whose tangent is self.
    fn atan(self) -> Self;
    /// The largest whole number ≤ self; of a number with derivatives, that of its value.
    fn floor(self) -> Self;

    /// self < other
    fn lt(self, other: Self) -> Self::Mask;
    /// self ≤ other
    fn le(self, other: Self) -> Self::Mask;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> Self::Mask;
    /// `a` where the mask is true, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// 0
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// 1
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }
    /// ½ self
    #[inline(always)]
    fn half(self) -> Self {
        self * Self::from_f64(0.5)
    }
    /// self / divisor
    #[inline(always)]
    fn over(self, divisor: f64) -> Self {
        self / Self::from_f64(divisor)
    }
    /// 1 / self
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }

    /// self to the power n, by products; for n < 0 the reciprocal of that for -n.
    #[inline]
    fn powi(self, n: i32) -> Self {
        let (mut power, mut square, mut rest) = (Self::one(), self, n.unsigned_abs());
        while rest > 0 {
            if rest % 2 == 1 {
                power *= square;
            }
            rest /= 2;
            if rest > 0 {
                square *= square;
            }
        }
        if n < 0 { power.recip() } else { power }
    }

    // No formula below subtracts numbers that are nearly equal and rounded.

    /// sin self
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// cos self
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// tan self
    #[inline(always)]
    fn tan(self) -> Self {
        let (sin, cos) = self.sin_cos();
        sin / cos
    }
    /// The angle between -π/2 and π/2 whose sine is self. By half of it no divisor is 0.
    #[inline]
    fn asin(self) -> Self {
        let one = Self::one();
        let half = (self / (one + ((one - self) * (one + self)).sqrt())).atan();
        half + half
    }
    /// The angle between 0 and π whose cosine is self, by a quarter of it.
    #[inline]
    fn acos(self) -> Self {
        let (one, root) = (Self::one(), (Self::one() + Self::one()).sqrt());
        let quarter = ((one - self).sqrt() / (root + (one + self).sqrt())).atan();
        Self::from_f64(4.0) * quarter
    }
    /// (e^self - e^-self)/2
    #[inline]
    fn sinh(self) -> Self {
        let (one, e) = (Self::one(), self.abs().exp_m1());
        let sinh = (e + Self::select(e.is_finite(), e / (e + one), one)).half();
        Self::select(self.lt(Self::zero()), -sinh, sinh)
    }
    /// (e^self + e^-self)/2
    #[inline]
    fn cosh(self) -> Self {
        // In Quad, e^x of a large negative x underflows in its low part.
        let e = self.abs().exp();
        (e + e.recip()).half()
    }
    /// sinh self / cosh self
    #[inline]
    fn tanh(self) -> Self {
        let e = (-(self.abs() + self.abs())).exp_m1();
        let tanh = -e / (e + Self::one() + Self::one());
        Self::select(self.lt(Self::zero()), -tanh, tanh)
    }
}

/// The index of the first entry that is not finite, and its value in the first lane that is not.
#[cold]
pub(crate) fn first_not_finite<T: Scalar>(part: &[T]) -> Option<(usize, f64)> {
    let at = part.iter().position(|x| !x.is_finite().all())?;
    Some((at, value_not_finite(part[at])))
}

/// The value in the first lane that is not finite, or NaN if all lanes are finite.
#[cold]
pub(crate) fn value_not_finite<T: Scalar>(x: T) -> f64 {
    (0..T::LANES).map(|lane| x.lane(lane)).find(|x| !x.is_finite()).unwrap_or(f64::NAN)
}

impl Scalar for f64 {
    type Mask = bool;
    const EPSILON: f64 = f64::EPSILON / 2.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        f64::mul_add(self, a, b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        f64::exp_m1(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f64::ln(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        f64::atan(self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f64::floor(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        // Infinity and NaN give NaN. `f64::is_finite` would go through the integer registers.
        self * 0.0 == 0.0
    }
    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
}
