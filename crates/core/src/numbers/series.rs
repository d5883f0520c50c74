//! Truncated power series: Taylor coefficients by arithmetic.

use super::scalar::{Mask, Scalar};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// `c_0 + c_1 τ + ... + c_{N-1} τ^{N-1}`, everything of order N and beyond dropped. Comparisons
/// look at c_0.
///
/// A series may be known to fewer than N terms. A result is known to as many terms as the operand
/// with the fewest known terms. Further terms are not computed.
///
/// Most operations are not inlined: a potential in slopes of series would compile to hundreds of
/// kilobytes.
#[derive(Clone, Copy, Debug)]
pub struct Series<T, const N: usize> {
    /// The coefficients; 0 where they are not known.
    pub c: [T; N],
    /// The number of coefficients that are known.
    known: usize,
}

impl<T: Scalar, const N: usize> Series<T, N> {
    /// The series with these coefficients.
    pub const fn new(c: [T; N]) -> Self {
        Self { c, known: N }
    }

    /// The series of a constant.
    #[inline]
    pub fn constant(c: T) -> Self {
        let mut series = Self::new([T::zero(); N]);
        series.c[0] = c;
        series
    }

    /// A series with `known` known terms: the first is `c`, the others are still 0.
    #[inline]
    fn begun(c: T, known: usize) -> Self {
        Self { known, ..Self::constant(c) }
    }

    /// The series of which only the first term is known.
    pub(crate) fn first(&self) -> Self {
        Self::begun(self.c[0], 1)
    }

    /// The number of terms up to the last that is not 0.
    #[inline]
    pub(crate) fn terms(&self) -> usize {
        self.c[..self.known].iter().rposition(|&c| c != T::zero()).map_or(0, |last| last + 1)
    }

    /// `c + ∫_0^τ`, the antiderivative with value `c` at 0. It is known to one term more.
    pub fn integral(&self, c: T) -> Self {
        let mut series = Self::begun(c, (self.known + 1).min(N));
        for k in 1..series.known {
            series.c[k] = self.c[k - 1].over(k as f64);
        }
        series
    }

    /// The sum at τ.
    #[inline]
    pub fn at(&self, tau: T) -> T {
        self.c.iter().rev().fold(T::zero(), |sum, &c| sum.mul_add(tau, c))
    }

    /// The derivative by τ at τ.
    #[inline]
    pub(crate) fn rate_at(&self, tau: T) -> T {
        let terms = self.c.iter().enumerate().skip(1).rev();
        terms.fold(T::zero(), |sum, (k, &c)| sum.mul_add(tau, c * T::from_f64(k as f64)))
    }

    /// Replaces each term by f of it and of the same term of `other`.
    #[inline]
    fn with(&mut self, other: &Self, f: impl Fn(T, T) -> T) {
        let known = self.known.min(other.known);
        let (terms, unknown) = self.c.split_at_mut(known);
        for (a, &b) in terms.iter_mut().zip(&other.c) {
            *a = f(*a, b);
        }
        unknown.fill(T::zero());
        self.known = known;
    }

    /// k c_k for the first `terms` values of k: the coefficients of τ times the derivative.
    #[inline]
    fn weights(&self, terms: usize) -> [T; N] {
        let mut weights = self.c;
        for (k, weight) in weights.iter_mut().enumerate().take(terms) {
            *weight *= T::from_f64(k as f64);
        }
        weights
    }

    /// f(self). `slope` is the series of f'(self), or `None` if f' = f; `first` is f(c_0).
    fn compose(self, first: T, slope: Option<&Self>) -> Self {
        let (mut f, terms) = (Self::begun(first, self.known), self.terms());
        let weights = self.weights(terms);
        for k in 1..f.known {
            let slope = slope.unwrap_or(&f);
            // k f_k = Σ_{i=1..k} i c_i f'_{k-i}
            let sum = (1..terms.min(k + 1))
                .fold(T::zero(), |sum, i| weights[i].mul_add(slope.c[k - i], sum));
            f.c[k] = sum.over(k as f64);
        }
        f
    }
}

/// Whether the coefficients are equal, however many are known.
impl<T: Scalar, const N: usize> PartialEq for Series<T, N> {
    fn eq(&self, other: &Self) -> bool {
        self.c == other.c
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
        for c in &mut self.c[..self.known] {
            *c = -*c;
        }
        self
    }
}

impl<T: Scalar, const N: usize> Mul for Series<T, N> {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        // Half the factors are parameters, and many others have few terms.
        let (a, b) = (self.terms(), other.terms());
        let known = self.known.min(other.known);
        let mut product = Self::begun(T::zero(), known);
        if a <= 1 {
            for (term, &c) in product.c[..known].iter_mut().zip(&other.c) {
                *term = self.c[0] * c;
            }
            return product;
        }
        if b <= 1 {
            for (term, &c) in product.c[..known].iter_mut().zip(&self.c) {
                *term = c * other.c[0];
            }
            return product;
        }
        // Row by row: the terms of a row are independent of each other.
        for (i, &c) in self.c[..a.min(known)].iter().enumerate() {
            for (term, &d) in product.c[i..known].iter_mut().zip(&other.c[..b]) {
                *term = c.mul_add(d, *term);
            }
        }
        product
    }
}

impl<T: Scalar, const N: usize> Div for Series<T, N> {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        let (terms, known) = (other.terms(), self.known.min(other.known));
        let mut quotient = Self::begun(T::zero(), known);
        // The contribution of the terms found so far to the product of quotient and divisor.
        let mut product = [T::zero(); N];
        for k in 0..known {
            let c = (self.c[k] - product[k]) / other.c[0];
            quotient.c[k] = c;
            for (term, &d) in product[k..known].iter_mut().zip(&other.c[..terms]).skip(1) {
                *term = c.mul_add(d, *term);
            }
        }
        quotient
    }
}

impl<T: Scalar, const N: usize> AddAssign for Series<T, N> {
    #[inline(never)]
    fn add_assign(&mut self, other: Self) {
        self.with(&other, |a, b| a + b);
    }
}

impl<T: Scalar, const N: usize> SubAssign for Series<T, N> {
    #[inline(never)]
    fn sub_assign(&mut self, other: Self) {
        self.with(&other, |a, b| a - b);
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
        self.c[0].to_f64()
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
        let mut f = Self::begun(self.c[0].sqrt(), self.known);
        for k in 1..self.known {
            // 2 f_0 f_k = c_k - Σ_{0<i<k} f_i f_{k-i}
            let sum = (1..k).fold(T::zero(), |sum, i| f.c[i].mul_add(f.c[k - i], sum));
            f.c[k] = ((self.c[k] - sum) / f.c[0]).half();
        }
        f
    }
    fn exp(self) -> Self {
        self.compose(self.c[0].exp(), None)
    }
    fn exp_m1(self) -> Self {
        // The slope is e^u. A slope computed as 1 + (e^u - 1) would be lost where u is far below 0.
        let mut series = self.exp();
        series.c[0] = self.c[0].exp_m1();
        series
    }
    fn ln(self) -> Self {
        let slope = self.recip();
        self.compose(self.c[0].ln(), Some(&slope))
    }
    fn atan(self) -> Self {
        let slope = (self * self + Self::one()).recip();
        self.compose(self.c[0].atan(), Some(&slope))
    }
    fn floor(self) -> Self {
        Self::constant(self.c[0].floor())
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.c[0].sin_cos();
        // (sin u)' = cos u u' and (cos u)' = -sin u u' grow together, one coefficient at a time.
        let (mut s, mut c) = (Self::begun(sin, self.known), Self::begun(cos, self.known));
        let terms = self.terms();
        let weights = self.weights(terms);
        for k in 1..self.known {
            let (mut ds, mut dc) = (T::zero(), T::zero());
            for (i, weight) in weights.iter().enumerate().take(terms.min(k + 1)).skip(1) {
                ds = weight.mul_add(c.c[k - i], ds);
                dc = weight.mul_add(s.c[k - i], dc);
            }
            s.c[k] = ds.over(k as f64);
            c.c[k] = -dc.over(k as f64);
        }
        (s, c)
    }
    fn over(mut self, divisor: f64) -> Self {
        for c in &mut self.c[..self.known] {
            *c = c.over(divisor);
        }
        self
    }
    #[inline]
    fn lt(self, other: Self) -> T::Mask {
        self.c[0].lt(other.c[0])
    }
    #[inline]
    fn le(self, other: Self) -> T::Mask {
        self.c[0].le(other.c[0])
    }
    #[inline]
    fn is_finite(self) -> T::Mask {
        self.c[1..].iter().fold(self.c[0].is_finite(), |mask, c| mask.and(c.is_finite()))
    }
    #[inline(never)]
    fn select(mask: T::Mask, mut a: Self, b: Self) -> Self {
        a.with(&b, |a, b| T::select(mask, a, b));
        a
    }
}

#[cfg(test)]
mod tests;
