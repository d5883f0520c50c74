//! Numbers that carry their rounding errors.
//!
//! Every operation rounds as that of `T` does, and its error, known by error-free transformations
//! (T. J. Dekker 1971; D. E. Knuth; a product's by a fused multiply-add), goes into a second number
//! together with the errors of its operands, to first order:
//! `(a + α)(b + β) = ab + (aβ + bα + αβ)`. The sum of both has about 105 correct bits, as for
//! [`Quad`]. It is faster because the values do not depend on the errors: their chain is that of
//! `T` alone, and no operation normalises the pair. That is the compensated arithmetic of S.
//! Graillat, P. Langlois and N. Louvet (2009), for any straight-line program.

use super::scalar::{Mask, Scalar};
use super::two_sum::two_sum;
use qd::Quad;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// The sum of a rounded number and its accumulated rounding error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corrected<T> {
    value: T,
    lost: T,
}

/// a b and its error.
#[inline(always)]
fn product<T: Scalar>(a: T, b: T) -> (T, T) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl<T: Scalar> Corrected<T> {
    /// A number without error.
    #[inline(always)]
    pub fn exact(value: T) -> Self {
        Self { value, lost: T::zero() }
    }

    /// The nearest number of `T`, with the rest as its error.
    #[inline(always)]
    pub fn normalised(self) -> Self {
        let [value, lost] = two_sum(self.value, self.lost);
        // The rest of an overflow is not finite and is set to 0.
        let finite = value.is_finite().and(lost.is_finite());
        Self { value, lost: T::select(finite, lost, value * T::zero()) }
    }

    /// The nearest number.
    #[inline(always)]
    pub fn nearest(self) -> T {
        self.value + self.lost
    }

    /// The number as rounded by its operations, without its error.
    #[inline(always)]
    pub fn rounded(self) -> T {
        self.value
    }

    /// -1 for a negative number, else 1, also for -0 and NaN.
    #[inline(always)]
    fn sign(self) -> T {
        let (zero, one) = (T::zero(), T::one());
        T::select(self.nearest().lt(zero), -one, one)
    }

    #[inline(always)]
    fn scaled(self, by: T) -> Self {
        Self { value: self.value * by, lost: self.lost * by }
    }
}

impl From<f64> for Corrected<f64> {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Self::from_f64(x)
    }
}

impl<T: Scalar> Add for Corrected<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let [value, error] = two_sum(self.value, other.value);
        Self { value, lost: error + (self.lost + other.lost) }
    }
}

impl<T: Scalar> Sub for Corrected<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: Scalar> Mul for Corrected<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (value, error) = product(self.value, other.value);
        let lost = self.lost.mul_add(other.nearest(), error);
        Self { value, lost: self.value.mul_add(other.lost, lost) }
    }
}

impl<T: Scalar> Div for Corrected<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // A divisor that has cancelled down to its error has the value 0.
        let (dividend, divisor) = (self.normalised(), other.normalised());
        let value = dividend.value / divisor.value;
        let left = (-value).mul_add(divisor.value, dividend.value);
        let left = (-value).mul_add(divisor.lost, left + dividend.lost);
        Self { value, lost: left / divisor.nearest() }
    }
}

impl<T: Scalar> Neg for Corrected<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, lost: -self.lost }
    }
}

impl<T: Scalar> AddAssign for Corrected<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar> SubAssign for Corrected<T> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<T: Scalar> MulAssign for Corrected<T> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

/// Scalars that consist of one or several `f64` in lanes.
pub trait Lanewise: Scalar {}

impl Lanewise for f64 {}

impl<T: Lanewise> Corrected<T> {
    /// A function of each lane, computed in [`Quad`].
    fn by_quad(self, f: impl Fn(Quad) -> Quad) -> Self {
        let x = self.normalised();
        let of = |k: usize| {
            let Quad(value, lost) = f(Quad(x.value.lane(k), x.lost.lane(k)));
            // Infinities of `Quad` may have no low part that is a number.
            [value, if value.is_finite() { lost } else { 0.0 }]
        };
        Self { value: T::from_lanes(|k| of(k)[0]), lost: T::from_lanes(|k| of(k)[1]) }
    }
}

impl<T: Lanewise> Scalar for Corrected<T> {
    type Mask = T::Mask;
    const LANES: usize = T::LANES;
    /// Eight units of 2⁻¹⁰⁶, of the sizes of the terms of a sum.
    const EPSILON: f64 = 2.0 * f64::EPSILON * f64::EPSILON;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self::exact(T::from_f64(x))
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.nearest().to_f64()
    }
    #[inline(always)]
    fn from_lanes(lane: impl FnMut(usize) -> f64) -> Self {
        Self::exact(T::from_lanes(lane))
    }
    #[inline(always)]
    fn lane(self, index: usize) -> f64 {
        self.nearest().lane(index)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.scaled(self.sign())
    }
    #[inline(always)]
    fn half(self) -> Self {
        self.scaled(T::from_f64(0.5))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let Self { value, lost } = self.normalised();
        let root = value.sqrt();
        let left = (-root).mul_add(root, value) + lost;
        let zero = root.le(T::zero());
        Self { value: root, lost: T::select(zero, T::zero(), (left / root).half()) }
    }
    fn exp(self) -> Self {
        self.by_quad(Scalar::exp)
    }
    fn exp_m1(self) -> Self {
        self.by_quad(Scalar::exp_m1)
    }
    fn ln(self) -> Self {
        self.by_quad(Scalar::ln)
    }
    fn sin_cos(self) -> (Self, Self) {
        (self.by_quad(|x| x.sin_cos().0), self.by_quad(|x| x.sin_cos().1))
    }
    fn atan(self) -> Self {
        self.by_quad(Scalar::atan)
    }
    fn floor(self) -> Self {
        self.by_quad(Scalar::floor)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> T::Mask {
        (self - other).nearest().lt(T::zero())
    }
    #[inline(always)]
    fn le(self, other: Self) -> T::Mask {
        (self - other).nearest().le(T::zero())
    }
    #[inline(always)]
    fn is_finite(self) -> T::Mask {
        self.nearest().is_finite()
    }
    #[inline(always)]
    fn select(mask: T::Mask, a: Self, b: Self) -> Self {
        Self { value: T::select(mask, a.value, b.value), lost: T::select(mask, a.lost, b.lost) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wide::f64x8;

    fn random(seed: &mut u64) -> f64 {
        *seed =
            seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * (*seed >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
    }

    /// Something of every operation.
    fn program<T: Scalar>(x: [T; 3]) -> T {
        let [a, b, c] = x;
        let polynomial = a.mul_add(b, c) * (a - b) + c.half();
        let quotient = polynomial / (b * b + T::one());
        let (sin, cos) = (a + quotient).sin_cos();
        let root = (sin * sin + T::from_f64(2.0)).sqrt();
        (root.ln() + cos.exp() - b.exp_m1() * c.atan()).abs()
    }

    fn quad(x: Corrected<f64>) -> Quad {
        let Corrected { value, lost } = x.normalised();
        Quad(value, lost)
    }

    #[test]
    fn programs_are_those_in_quad() {
        let mut seed = 1;
        for _ in 0..2000 {
            let [x, y] = [(); 2].map(|()| [(); 3].map(|()| random(&mut seed)));
            let exact =
                std::array::from_fn(|k| Quad::from_f64(x[k]) + Quad::from_f64(1e-18 * y[k]));
            let corrected = exact.map(|Quad(value, lost)| Corrected { value, lost });
            let off = (quad(program(corrected)) - program(exact)).to_f64().abs();
            assert!(off < 40.0 * Corrected::<f64>::EPSILON, "{x:?}: {off:e}");
            // A number alone, and the last of eight lanes.
            let lanes = corrected.map(|Corrected { value, lost }| Corrected {
                value: f64x8::splat(value),
                lost: f64x8::splat(lost),
            });
            let last = program(lanes);
            let alone = program(corrected);
            assert_eq!(last.value.to_array()[7].to_bits(), alone.value.to_bits());
            assert_eq!(last.lost.to_array()[7].to_bits(), alone.lost.to_bits());
        }
    }

    /// 1 + x - 1 has lost nothing, nor has a quotient with this divisor.
    #[test]
    fn what_cancels_is_still_there() {
        let one = Corrected::<f64>::one();
        for x in [1e-17, -3e-20, 1e-30] {
            let left = (one + Corrected::from(x)) - one;
            assert_eq!((left.to_f64(), (one / left).to_f64()), (x, 1.0 / x));
            assert_eq!((left * left).to_f64(), x * x);
            let negative = x < 0.0;
            assert_eq!((left.lt(Corrected::zero()), left.abs().to_f64()), (negative, x.abs()));
        }
    }

    #[test]
    fn what_is_not_finite_is_seen() {
        let (zero, one) = (Corrected::<f64>::zero(), Corrected::<f64>::one());
        let huge = Corrected::from(1e200);
        for x in [huge * huge, one / zero, zero / zero, (-one).sqrt(), Corrected::from(800.0).exp()]
        {
            assert!(!Scalar::is_finite(x) && !Scalar::is_finite(x.normalised()), "{x:?}");
        }
        assert_eq!((zero.sqrt(), Scalar::is_finite(one)), (zero, true));
    }
}
