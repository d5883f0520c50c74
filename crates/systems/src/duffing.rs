//! The Duffing oscillator, a cubic spring with linear damping.
//!
//! ```text
//! q' = p        p' = -α q - β q³ - c p        w' = c p²
//! H = p²/2 + α q²/2 + β q⁴/4                  D = c p
//! ```
//!
//! Parameters, all finite, for a unit mass: α in 1/time², β in 1/(length² time²), c in 1/time. β >
//! 0 hardens the spring, β < 0 softens it and leaves V unbounded below; α < 0 < β is a double well
//! with its minima at q = ±√(-α/β). c > 0 is passive, c < 0 active.
//!
//! Invariants: K = H + w, and H itself at c = 0. Without damping the solution is an elliptic
//! function, with it there is none in closed form: references come from
//! [`afterbay_core::taylor::trajectory`] in a wider scalar.
//!
//! The paper names a modified Duffing system and does not define it; this one is ours.

use crate::family::{BY_SERIES, Family, Parameter, exactly};
use crate::{finite, is_zero, linear_dissipation};
use afterbay_core::{
    Abilities, Block, Curvature, Dissipation, DissipationForm, InputError, Line, OrderRaising,
    Scalar, SecondDerivatives, Separable, System,
};
use std::sync::Arc;

/// V = α q²/2 + β q⁴/4 with D = c p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duffing<T> {
    alpha: T,
    beta: T,
    c: T,
}

impl<T: Scalar> Duffing<T> {
    /// The oscillator with stiffness α + β q² and damping c.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if one is not finite.
    pub fn new(alpha: T, beta: T, c: T) -> Result<Self, InputError> {
        Ok(Self { alpha: finite("alpha", alpha)?, beta: finite("beta", beta)?, c: finite("c", c)? })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> Duffing<U> {
        Duffing { alpha: f(self.alpha), beta: f(self.beta), c: f(self.c) }
    }
}

impl<T: Scalar> System<T> for Duffing<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        1
    }

    #[inline(always)]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let square = q[0] * q[0];
        (p[0] * p[0] + square * (self.beta.half() * square + self.alpha)).half()
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        hq[0] = self.partial(q, 0, q[0]);
        hp[0] = p[0].read();
    }

    #[inline(always)]
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        d[0] = self.c * v[0];
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        linear_dissipation(self.c)
    }
}

impl<T: Scalar> Separable<T> for Duffing<T> {
    #[inline(always)]
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        at * self.beta.mul_add(at * at, self.alpha)
    }

    /// `ΔV/Δq = (a + b) [α/2 + β/4 (a² + b²)]` between a and b.
    #[inline(always)]
    fn divided_difference(&self, q: &[T], _j: usize, to: T) -> Line<T> {
        let (sum, half_beta) = (q[0] + to, self.beta.half());
        let stiffness = half_beta.half().mul_add(to.mul_add(to, q[0] * q[0]), self.alpha.half());
        Line { value: sum * stiffness, slope: (half_beta * to).mul_add(sum, stiffness) }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_of(&self, _q: &[T], p: &[T], _j: usize) -> Dissipation<T> {
        Dissipation { value: self.c * p[0], by_q: T::zero(), by_p: self.c }
    }
}

impl<T: Scalar> Curvature<T> for Duffing<T> {
    #[inline(always)]
    fn curvature(&self, q: &[T], _p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let bend = self.beta * (q[0] * q[0]);
        put(Block::Hqq, 0, 0, self.alpha + (bend + bend + bend));
        put(Block::Hpp, 0, 0, T::one());
        put(Block::Dp, 0, 0, self.c);
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        is_zero(self.beta)
    }
}

impl<T: Scalar> Abilities<T> for Duffing<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }

    fn order_raising(self: Arc<Self>) -> Option<Arc<dyn OrderRaising<T>>> {
        Some(self)
    }
}

impl Family for Duffing<f64> {
    type Of<T: Scalar> = Duffing<T>;

    const NAME: &'static str = "duffing";
    const EQUATIONS: &'static str = "V = α q²/2 + β q⁴/4, D = c p";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new("alpha", "1/time²"),
        Parameter::new("beta", "1/(length² time²)"),
        Parameter::new("c", "1/time"),
    ];
    const RANGES: &'static str = "any (alpha < 0 < beta: double well)";
    const SOLUTION: &'static str = BY_SERIES;
    const DOF: Option<usize> = Some(1);

    fn make<T: Scalar>(_n: usize, parameters: &[T]) -> Result<Duffing<T>, InputError> {
        let [alpha, beta, c] = exactly(parameters)?;
        Duffing::new(alpha, beta, c)
    }
}

#[cfg(test)]
mod tests {
    use afterbay_core::Passive;

    use super::*;
    use afterbay_core::OrderRaising;

    #[test]
    fn parameters_are_finite() {
        let nan = f64::NAN;
        for (system, name) in [
            (Duffing::new(nan, 1.0, 0.1), "alpha"),
            (Duffing::new(1.0, f64::INFINITY, 0.1), "beta"),
            (Duffing::new(-1.0, 1.0, nan), "c"),
        ] {
            assert!(
                matches!(system, Err(InputError::Parameter { name: found, .. }) if found == name)
            );
        }
    }

    #[test]
    fn the_sign_of_c_decides() {
        let damping = |c: f64| Duffing::new(-1.0, 1.0, c).unwrap().dissipation_form();
        assert_eq!(damping(0.0), DissipationForm::NONE);
        assert_eq!(damping(-0.0), DissipationForm::NONE);
        assert_eq!(
            damping(0.1),
            DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
        );
        assert_eq!(damping(-0.1), DissipationForm::LINEAR);
    }

    #[test]
    fn the_wells_are_at_rest() {
        let system = Duffing::new(-4.0, 1.0, 0.3).unwrap();
        for q in [-2.0, 0.0, 2.0] {
            assert_eq!(system.partial(&[q], 0, q), 0.0);
        }
        // The bottom is α²/(4β) below the top of the barrier.
        assert_eq!(system.energy(&[2.0], &[0.0]), -4.0);
    }

    #[test]
    fn without_a_cubic_term_the_corrections_are_linear() {
        let system = Duffing::new(2.5, 0.0, 0.2).unwrap();
        let linear = crate::DampedOscillator::new(2.5, 0.2).unwrap();
        let (q, p) = (0.7, -1.3);
        for (found, expected) in [
            (system.delta_q(q, p), linear.delta_q(q, p)),
            (system.delta_p(q, p), linear.delta_p(q, p)),
        ] {
            assert!((found.third - expected.third).abs() < 1e-15, "{found:?} {expected:?}");
            assert!((found.fourth - expected.fourth).abs() < 1e-15, "{found:?} {expected:?}");
        }
    }
}
