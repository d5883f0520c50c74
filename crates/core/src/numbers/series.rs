//! Truncated power series: Taylor coefficients by arithmetic.

use super::scalar::{Mask, Scalar};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// `c_0 + c_1 τ + ... + c_{N-1} τ^{N-1}`, everything of order N and beyond dropped. Comparisons
/// look at c_0.
///
/// Most operations are not inlined: a potential in slopes of series would compile to hundreds of
/// kilobytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<T, const N: usize>(pub [T; N]);

impl<T: Scalar, const N: usize> Series<T, N> {
    /// The series of a constant.
    #[inline]
    pub fn constant(c: T) -> Self {
        let mut series = [T::zero(); N];
        series[0] = c;
        Self(series)
    }

    /// The number of terms up to the last that is not 0.
    #[inline]
    fn terms(&self) -> usize {
        self.0.iter().rposition(|&c| c != T::zero()).map_or(0, |last| last + 1)
    }

    /// `c + ∫_0^τ`, the antiderivative with value `c` at 0.
    pub fn integral(&self, c: T) -> Self {
        self.integral_to(N, c)
    }

    /// The first so many terms of the antiderivative with value `c` at 0.
    pub(crate) fn integral_to(&self, terms: usize, c: T) -> Self {
        let mut series = Self::constant(c);
        for k in 1..terms.min(N) {
            series.0[k] = self.0[k - 1] / T::from_f64(k as f64);
        }
        series
    }

    /// The sum at τ.
    #[inline]
    pub fn at(&self, tau: T) -> T {
        self.0.iter().rev().fold(T::zero(), |sum, &c| sum.mul_add(tau, c))
    }

    /// The derivative by τ at τ.
    #[inline]
    pub(crate) fn rate_at(&self, tau: T) -> T {
        let terms = self.0.iter().enumerate().skip(1).rev();
        terms.fold(T::zero(), |sum, (k, &c)| sum.mul_add(tau, c * T::from_f64(k as f64)))
    }

    /// f(self) for an f that satisfies f' = g(f): `first` is f(c_0), `derivative` gives `g` from
    /// what is known of f.
    fn compose(self, first: T, derivative: impl Fn(&Self) -> Self) -> Self {
        let (mut f, terms) = (Self::constant(first), self.terms());
        for k in 1..N {
            let slope = derivative(&f);
            // k f_k = Σ_{i=1..k} i c_i g_{k-i}
            let sum = (1..terms.min(k + 1)).fold(T::zero(), |sum, i| {
                (T::from_f64(i as f64) * self.0[i]).mul_add(slope.0[k - i], sum)
            });
            f.0[k] = sum / T::from_f64(k as f64);
        }
        f
    }
}

impl<T: Scalar, const N: usize> Add for Series<T, N> {
    type Output = Self;
    #[inline]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<T: Scalar, const N: usize> Sub for Series<T, N> {
    type Output = Self;
    #[inline]
    fn sub(mut self, other: Self) -> Self {
        self -= other;
        self
    }
}

impl<T: Scalar, const N: usize> Neg for Series<T, N> {
    type Output = Self;
    #[inline(never)]
    fn neg(mut self) -> Self {
        for c in &mut self.0 {
            *c = -*c;
        }
        self
    }
}

impl<T: Scalar, const N: usize> Mul for Series<T, N> {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        // Half the factors are parameters, and many end early.
        let (a, b) = (self.terms(), other.terms());
        let mut product = [T::zero(); N];
        if a <= 1 {
            for (term, &c) in product.iter_mut().zip(&other.0) {
                *term = self.0[0] * c;
            }
            return Self(product);
        }
        if b <= 1 {
            for (term, &c) in product.iter_mut().zip(&self.0) {
                *term = c * other.0[0];
            }
            return Self(product);
        }
        for (k, term) in product.iter_mut().enumerate().take(a + b - 1) {
            for i in (k + 1).saturating_sub(b)..a.min(k + 1) {
                *term = self.0[i].mul_add(other.0[k - i], *term);
            }
        }
        Self(product)
    }
}

impl<T: Scalar, const N: usize> Div for Series<T, N> {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        let mut quotient = [T::zero(); N];
        for k in 0..N {
            let known = (0..k).fold(T::zero(), |sum, i| quotient[i].mul_add(other.0[k - i], sum));
            quotient[k] = (self.0[k] - known) / other.0[0];
        }
        Self(quotient)
    }
}

impl<T: Scalar, const N: usize> AddAssign for Series<T, N> {
    #[inline(never)]
    fn add_assign(&mut self, other: Self) {
        for (a, &b) in self.0.iter_mut().zip(&other.0) {
            *a += b;
        }
    }
}

impl<T: Scalar, const N: usize> SubAssign for Series<T, N> {
    #[inline(never)]
    fn sub_assign(&mut self, other: Self) {
        for (a, &b) in self.0.iter_mut().zip(&other.0) {
            *a -= b;
        }
    }
}

impl<T: Scalar, const N: usize> MulAssign for Series<T, N> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<T: Scalar, const N: usize> Scalar for Series<T, N> {
    type Mask = T::Mask;
    const EPSILON: f64 = T::EPSILON;

    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::constant(T::from_f64(x))
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self.0[0].to_f64()
    }
    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline]
    fn abs(self) -> Self {
        Self::select(self.lt(Self::zero()), -self, self)
    }
    fn sqrt(self) -> Self {
        let mut f = Self::constant(self.0[0].sqrt());
        for k in 1..N {
            // 2 f_0 f_k = c_k - Σ_{0<i<k} f_i f_{k-i}
            let known = (1..k).fold(T::zero(), |sum, i| f.0[i].mul_add(f.0[k - i], sum));
            f.0[k] = ((self.0[k] - known) / f.0[0]).half();
        }
        f
    }
    fn exp(self) -> Self {
        self.compose(self.0[0].exp(), |f| *f)
    }
    fn exp_m1(self) -> Self {
        // The slope is e^u: that of a sum with 1 would be lost where u is far below 0.
        let mut series = self.exp();
        series.0[0] = self.0[0].exp_m1();
        series
    }
    fn ln(self) -> Self {
        let slope = self.recip();
        self.compose(self.0[0].ln(), |_| slope)
    }
    fn atan(self) -> Self {
        let slope = (self * self + Self::one()).recip();
        self.compose(self.0[0].atan(), |_| slope)
    }
    fn floor(self) -> Self {
        Self::constant(self.0[0].floor())
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0[0].sin_cos();
        // (sin u)' = cos u u' and (cos u)' = -sin u u' grow together, one coefficient at a time.
        let (mut s, mut c) = (Self::constant(sin), Self::constant(cos));
        let terms = self.terms();
        for k in 1..N {
            let (mut ds, mut dc) = (T::zero(), T::zero());
            for i in 1..terms.min(k + 1) {
                let weight = T::from_f64(i as f64) * self.0[i];
                ds = weight.mul_add(c.0[k - i], ds);
                dc = weight.mul_add(-s.0[k - i], dc);
            }
            s.0[k] = ds / T::from_f64(k as f64);
            c.0[k] = dc / T::from_f64(k as f64);
        }
        (s, c)
    }
    #[inline]
    fn lt(self, other: Self) -> T::Mask {
        self.0[0].lt(other.0[0])
    }
    #[inline]
    fn le(self, other: Self) -> T::Mask {
        self.0[0].le(other.0[0])
    }
    #[inline]
    fn is_finite(self) -> T::Mask {
        self.0[1..].iter().fold(self.0[0].is_finite(), |mask, c| mask.and(c.is_finite()))
    }
    #[inline(never)]
    fn select(mask: T::Mask, mut a: Self, b: Self) -> Self {
        for (a, &b) in a.0.iter_mut().zip(&b.0) {
            *a = T::select(mask, *a, b);
        }
        a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Series<f64, 8> = Series([0.7, -1.3, 0.4, 2.0, -0.6, 0.1, 0.9, -0.2]);

    fn assert_close(a: Series<f64, 8>, b: Series<f64, 8>) {
        for k in 0..8 {
            assert!(
                (a.0[k] - b.0[k]).abs() < 1e-11 * (1.0 + b.0[k].abs()),
                "coefficient {k}: {a:?} {b:?}"
            );
        }
    }

    #[test]
    fn a_constant_is_a_factor_of_each_term() {
        let [mut nearly, mut lacking] = [Series::constant(3.0), Series::constant(0.0)];
        (nearly.0[7], lacking.0[2]) = (1e-300, 5.0);
        for other in [Series::constant(3.0), nearly, lacking] {
            let full = std::array::from_fn(|k| (0..=k).map(|i| X.0[i] * other.0[k - i]).sum());
            assert_close(X * other, Series(full));
            assert_close(other * X, Series(full));
        }
        assert_eq!((X * Series::constant(3.0)).0, X.0.map(|c| 3.0 * c));
    }

    #[test]
    fn inverse_operations_cancel() {
        let y = X * X + Series::from_f64(2.0);
        assert_close(X * y / y, X);
        assert_close(y.sqrt() * y.sqrt(), y);
        assert_close(X.exp() * (-X).exp(), Series::one());
        assert_close(X.exp_m1() + Series::one(), X.exp());
        let (sin, cos) = X.sin_cos();
        assert_close(sin * sin + cos * cos, Series::one());
        assert_close((X + X).sin_cos().0, (sin * cos) * Series::from_f64(2.0));
        assert_close(X.exp().ln(), X);
        assert_close((sin / cos).atan(), X);
    }

    #[test]
    fn coefficients_are_those_of_taylor() {
        let tau = Series::<f64, 8>([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let mut factorial = 1.0;
        for (k, c) in tau.exp().0.into_iter().enumerate() {
            factorial *= if k == 0 { 1.0 } else { k as f64 };
            assert!((c * factorial - 1.0).abs() < 1e-15);
        }
        assert!((tau.exp().at(0.01) - 0.01_f64.exp()).abs() < 1e-15);
        assert_close(tau.exp().integral(1.0), tau.exp());
    }
}
