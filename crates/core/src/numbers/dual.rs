//! [`num_dual::Dual64`]: a number and its derivative. The oracle of the tests of gradients.
//!
//! Comparisons use the real part alone, so a branch is taken as it is for the number itself.

use super::scalar::Scalar;
use num_dual::{Dual64, DualNum};

impl Scalar for Dual64 {
    type Mask = bool;
    const EPSILON: f64 = <f64 as Scalar>::EPSILON;

    fn from_f64(x: f64) -> Self {
        Dual64::from(x)
    }
    fn to_f64(self) -> f64 {
        self.re
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    fn abs(self) -> Self {
        if self.re < 0.0 { -self } else { self }
    }
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }
    fn exp_m1(self) -> Self {
        DualNum::exp_m1(&self)
    }
    fn ln(self) -> Self {
        DualNum::ln(&self)
    }
    fn sin_cos(self) -> (Self, Self) {
        DualNum::sin_cos(&self)
    }
    fn atan(self) -> Self {
        DualNum::atan(&self)
    }
    fn floor(self) -> Self {
        Dual64::from(self.re.floor())
    }

    fn lt(self, other: Self) -> bool {
        self.re < other.re
    }
    fn le(self, other: Self) -> bool {
        self.re <= other.re
    }
    /// Whether the number and the derivative are finite.
    fn is_finite(self) -> bool {
        self.re.is_finite() && self.eps.is_finite()
    }
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_functions() {
        for x in [-2.5, -0.3, 1e-3, 0.7, 4.0_f64] {
            let d = Dual64::new(x, 1.0);
            let (sin, cos) = Scalar::sin_cos(d);
            let pairs = [
                (Scalar::exp(d).eps, x.exp()),
                (Scalar::exp_m1(d).eps, x.exp()),
                (sin.eps, x.cos()),
                (cos.eps, -x.sin()),
                (Scalar::abs(d).eps, x.signum()),
                (Scalar::sqrt(d * d + Dual64::one()).eps, x / x.hypot(1.0)),
                (Scalar::mul_add(d, d, d).eps, 2.0 * x + 1.0),
                (Scalar::recip(d).eps, -1.0 / (x * x)),
                (Scalar::ln(d * d).eps, 2.0 / x),
                (Scalar::atan(d).eps, 1.0 / (1.0 + x * x)),
            ];
            for (i, (computed, exact)) in pairs.into_iter().enumerate() {
                assert!(
                    (computed - exact).abs() <= 1e-14 * exact.abs().max(1.0),
                    "{i} at {x}: {computed}"
                );
            }
        }
    }

    #[test]
    fn comparisons_look_at_the_real_part() {
        let (a, b) = (Dual64::new(1.0, 5.0), Dual64::new(1.0, 2.0));
        assert!(Scalar::le(a, b) && Scalar::le(b, a) && !Scalar::lt(b, a));
        assert!(!Scalar::is_finite(Dual64::new(1.0, f64::INFINITY)) && Scalar::is_finite(a));
    }
}
