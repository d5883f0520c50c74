//! The Van der Pol oscillator, driven inside |q| < 1 and damped outside.
//!
//! ```text
//! q' = p        p' = -q + μ (1 - q²) p        w' = -μ (1 - q²) p²
//! H = p²/2 + q²/2                             D = -μ (1 - q²) p
//! ```
//!
//! μ is any finite number and has no unit: q is measured in half-widths of the driven strip, time
//! in periods over 2π. μ > 0 has an attracting limit cycle, of amplitude 2 as μ → 0 and stiff for
//! large μ; μ < 0 is the same with time reversed.
//!
//! Invariant: K = H + w. For μ ≠ 0 the reservoir gives and takes by turns, so D is never passive.
//! There is no closed solution: references come from [`afterbay_core::taylor::trajectory`] in a
//! wider scalar.

use crate::family::{BY_SERIES, Family, Parameter, exactly};
use crate::{finite, is_zero, not_negative};
use afterbay_core::{
    Abilities, Block, Curvature, Dissipation, DissipationForm, InputError, Line, OrderRaising,
    Scalar, SecondDerivatives, Separable, System,
};
use std::sync::Arc;

/// V = q²/2 with D = -μ (1 - q²) p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanDerPol<T> {
    mu: T,
}

impl<T: Scalar> VanDerPol<T> {
    /// The oscillator with nonlinearity μ.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if μ is not finite.
    pub fn new(mu: T) -> Result<Self, InputError> {
        Ok(Self { mu: finite("mu", mu)? })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> VanDerPol<U> {
        VanDerPol { mu: f(self.mu) }
    }

    /// The coefficient D/p = μ (q² - 1).
    #[inline(always)]
    pub(crate) fn dissipation_rate(&self, q: T) -> T {
        self.mu * q.mul_add(q, -T::one())
    }
}

impl<T: Scalar> System<T> for VanDerPol<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        1
    }

    #[inline(always)]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        (p[0] * p[0] + q[0] * q[0]).half()
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        hq[0] = q[0];
        hp[0] = p[0].read();
    }

    #[inline(always)]
    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        d[0] = self.dissipation_rate(q[0]) * v[0];
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        let zero = not_negative(self.mu) && not_negative(-self.mu);
        if zero { DissipationForm::NONE } else { DissipationForm::LINEAR }
    }
}

impl<T: Scalar> Separable<T> for VanDerPol<T> {
    #[inline(always)]
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        at
    }

    #[inline(always)]
    fn divided_difference(&self, q: &[T], _j: usize, to: T) -> Line<T> {
        Line { value: (q[0] + to).half(), slope: T::one().half() }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_of(&self, q: &[T], p: &[T], _j: usize) -> Dissipation<T> {
        let (by_p, twice_q) = (self.dissipation_rate(q[0]), q[0] + q[0]);
        Dissipation { value: by_p * p[0], by_q: (self.mu * p[0]) * twice_q, by_p }
    }
}

impl<T: Scalar> Curvature<T> for VanDerPol<T> {
    #[inline(always)]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let drag = self.dissipation_of(q, p, 0);
        put(Block::Hqq, 0, 0, T::one());
        put(Block::Hpp, 0, 0, T::one());
        put(Block::Dq, 0, 0, drag.by_q);
        put(Block::Dp, 0, 0, drag.by_p);
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        is_zero(self.mu)
    }
}

impl<T: Scalar> Abilities<T> for VanDerPol<T> {
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

impl Family for VanDerPol<f64> {
    type Of<T: Scalar> = VanDerPol<T>;

    const NAME: &'static str = "van-der-pol";
    const EQUATIONS: &'static str = "V = q²/2, D = -μ (1 - q²) p";
    const PARAMETERS: &'static [Parameter] = &[Parameter::new("mu", "1")];
    const RANGES: &'static str = "any (mu > 0: limit cycle)";
    const SOLUTION: &'static str = BY_SERIES;
    const DOF: Option<usize> = Some(1);

    fn make<T: Scalar>(_n: usize, parameters: &[T]) -> Result<VanDerPol<T>, InputError> {
        let [mu] = exactly(parameters)?;
        VanDerPol::new(mu)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mu_is_finite() {
        for mu in [f64::NAN, f64::NEG_INFINITY] {
            assert!(matches!(VanDerPol::new(mu), Err(InputError::Parameter { name: "mu", .. })));
        }
    }

    #[test]
    fn only_without_mu_is_it_passive() {
        let damping = |mu: f64| VanDerPol::new(mu).unwrap().dissipation_form();
        assert_eq!(damping(0.0), DissipationForm::NONE);
        for mu in [5.0, -5.0] {
            assert_eq!(damping(mu), DissipationForm::LINEAR);
        }
    }

    #[test]
    fn the_strip_drives_and_the_rest_damps() {
        let system = VanDerPol::new(3.0).unwrap();
        let power = |q: f64| system.dissipation_of(&[q], &[2.0], 0).value * 2.0;
        assert_eq!((power(0.0), power(1.0), power(-2.0)), (-12.0, 0.0, 36.0));
    }
}
