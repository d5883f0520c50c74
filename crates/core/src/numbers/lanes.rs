//! Eight `f64` side by side ([`wide::f64x8`]), each computed as it would be alone.
//!
//! Sums, products, quotients and roots round as those of `f64` do, and `ln` and `atan` are those of
//! `f64`, lane by lane. `exp`, `exp_m1` and `sin_cos` are the crate's own: their last digits are
//! not those of the standard library. A call `f64x8::name` below is that of the crate `wide`, which
//! takes precedence over the method of the trait.

use super::corrected::Lanewise;
use super::scalar::{Mask, Scalar};
use std::hint::cold_path;
use wide::f64x8;

/// The largest angle whose sine and cosine have all digits in lanes. Above it digits are lost, and
/// above 1e16 the values leave [-1, 1].
const LARGEST_ANGLE: f64 = 1e8;

impl Mask for f64x8 {
    #[inline(always)]
    fn all(self) -> bool {
        f64x8::all(self)
    }
    #[inline(always)]
    fn any(self) -> bool {
        f64x8::any(self)
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

impl Scalar for f64x8 {
    /// All bits of a lane set or none.
    type Mask = Self;
    const LANES: usize = 8;
    const EPSILON: f64 = f64::EPSILON / 2.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self::splat(x)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.to_array()[0]
    }
    #[inline(always)]
    fn from_lanes(lane: impl FnMut(usize) -> f64) -> Self {
        Self::new(std::array::from_fn(lane))
    }
    #[inline(always)]
    fn lane(self, index: usize) -> f64 {
        self.to_array()[index % 8]
    }
    #[inline(always)]
    fn read(&self) -> Self {
        *self | Self::splat(0.0)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        f64x8::mul_add(self, a, b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64x8::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64x8::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64x8::exp(self)
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        f64x8::exp_m1(self)
    }
    #[inline]
    fn ln(self) -> Self {
        Self::new(self.to_array().map(f64::ln))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        if Mask::any(Self::splat(LARGEST_ANGLE).simd_lt(f64x8::abs(self))) {
            cold_path();
            let of_each = self.to_array().map(f64::sin_cos);
            let (sin, cos) = (of_each.map(|(sin, _)| sin), of_each.map(|(_, cos)| cos));
            return (Self::new(sin), Self::new(cos));
        }
        f64x8::sin_cos(self)
    }
    #[inline]
    fn atan(self) -> Self {
        Self::new(self.to_array().map(f64::atan))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f64x8::floor(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self {
        self.simd_lt(other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self {
        self.simd_le(other)
    }
    #[inline(always)]
    fn is_finite(self) -> Self {
        (self * Self::splat(0.0)).simd_eq(Self::splat(0.0))
    }
    #[inline(always)]
    fn select(mask: Self, a: Self, b: Self) -> Self {
        mask.select(a, b)
    }
}

impl Lanewise for f64x8 {}
