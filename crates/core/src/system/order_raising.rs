//! Order raising by a corrected step: δ = h + δ₃h³ + δ₄h⁴ in place of h (paper, section 4).

use super::linear::Linear;
use super::separable::Separable;
use crate::numbers::Scalar;

/// δ₃ and δ₄ at one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction<T> {
    /// δ₃
    pub third: T,
    /// δ₄
    pub fourth: T,
}

impl<T: Scalar> Correction<T> {
    /// h + δ₃h³, the step that raises the order by one.
    #[inline(always)]
    pub fn step3(&self, h: T) -> T {
        (self.third * h * h).mul_add(h, h)
    }

    /// h + δ₃h³ + δ₄h⁴, the step that raises the order by two.
    #[inline(always)]
    pub fn step4(&self, h: T) -> T {
        (self.fourth.mul_add(h, self.third) * h * h).mul_add(h, h)
    }
}

/// A system with one degree of freedom and closed forms of δ. The exact solution defines both:
/// `Δq = δ(q) p̄` and `Δp = -δ(p) (ΔV/Δq + D̄)`. [`crate::taylor::corrections`] computes them for
/// any system.
pub trait OrderRaising<T: Scalar>: Separable<T> {
    /// δ of the equation for q; its pole is p = 0.
    fn delta_q(&self, q: T, p: T) -> Correction<T>;
    /// δ of the equation for p; its pole is V'(q) + D(q,p) = 0.
    fn delta_p(&self, q: T, p: T) -> Correction<T>;
}

/// A system for which the paper prints δ with misprints: a linear one.
pub trait Misprinted<T: Scalar>: OrderRaising<T> + Linear<T> {
    /// δ of the equation for q as printed.
    fn printed_delta_q(&self, q: T, p: T) -> Correction<T>;
    /// δ of the equation for p as printed.
    fn printed_delta_p(&self, q: T, p: T) -> Correction<T>;
}
