//! The damped harmonic oscillator, the paper's example (there with k = 1).
//!
//! ```text
//! q' = p        p' = -k q - b p        w' = b p²
//! H = p²/2 + k q²/2                    D = b p
//! ```
//!
//! Parameters, for a unit mass: the stiffness k > 0 in 1/time² and the damping b in 1/time, both
//! finite. b > 0 is passive, b < 0 active. It is underdamped for b² < 4k and overdamped for b² >
//! 4k.
//!
//! Invariants: K = H + w; areas in the (q,p) plane shrink by e^{-bt}. The solution
//! ([`DampedOscillator::increment`]) and the δ of the paper's order raising are known in closed
//! form.

mod flow;
mod order_raising;

use crate::family::{Family, Parameter, exactly};
use crate::{finite, linear_dissipation, positive};
use afterbay_core::{
    Abilities, Block, Curvature, Dissipation, DissipationForm, Flow, InputError, Line, Linear,
    Misprinted, OrderRaising, Scalar, SecondDerivatives, Separable, System,
};
use std::sync::Arc;

/// V = k q²/2 with D = b p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedOscillator<T> {
    k: T,
    b: T,
}

impl<T: Scalar> DampedOscillator<T> {
    /// The oscillator with stiffness k and damping b.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if one is not finite or k is not positive.
    pub fn new(k: T, b: T) -> Result<Self, InputError> {
        Ok(Self { k: positive("k", k)?, b: finite("b", b)? })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> DampedOscillator<U> {
        DampedOscillator { k: f(self.k), b: f(self.b) }
    }
}

impl<T: Scalar> System<T> for DampedOscillator<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        1
    }

    #[inline(always)]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        (p[0] * p[0] + self.k * (q[0] * q[0])).half()
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        hq[0] = self.k * q[0];
        hp[0] = p[0].read();
    }

    #[inline(always)]
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        d[0] = self.b * v[0];
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        linear_dissipation(self.b)
    }
}

impl<T: Scalar> Separable<T> for DampedOscillator<T> {
    #[inline(always)]
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        self.k * at
    }

    #[inline(always)]
    fn divided_difference(&self, q: &[T], _j: usize, to: T) -> Line<T> {
        let slope = self.k.half();
        Line { value: slope * (q[0] + to), slope }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_of(&self, _q: &[T], p: &[T], _j: usize) -> Dissipation<T> {
        Dissipation { value: self.b * p[0], by_q: T::zero(), by_p: self.b }
    }
}

impl<T: Scalar> Curvature<T> for DampedOscillator<T> {
    #[inline(always)]
    fn curvature(&self, _q: &[T], _p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        put(Block::Hqq, 0, 0, self.k);
        put(Block::Hpp, 0, 0, T::one());
        put(Block::Dp, 0, 0, self.b);
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        true
    }
}

impl<T: Scalar> Linear<T> for DampedOscillator<T> {
    #[inline(always)]
    fn stiffness(&self, _i: usize, _j: usize) -> T {
        self.k
    }

    #[inline(always)]
    fn dissipation_rate(&self, _j: usize) -> T {
        self.b
    }
}

impl<T: Scalar> Abilities<T> for DampedOscillator<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }

    fn linear(self: Arc<Self>) -> Option<Arc<dyn Linear<T>>> {
        Some(self)
    }

    fn order_raising(self: Arc<Self>) -> Option<Arc<dyn OrderRaising<T>>> {
        Some(self)
    }

    fn misprinted(self: Arc<Self>) -> Option<Arc<dyn Misprinted<T>>> {
        Some(self)
    }

    fn exact_flow(self: Arc<Self>) -> Option<Arc<dyn Flow<T>>> {
        Some(self)
    }
}

impl Family for DampedOscillator<f64> {
    type Of<T: Scalar> = DampedOscillator<T>;

    const NAME: &'static str = "damped-oscillator";
    const EQUATIONS: &'static str = "V = k q²/2, D = b p";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::new("k", "1/time²"), Parameter::new("b", "1/time")];
    const RANGES: &'static str = "k > 0 (b < 0 feeds energy in)";
    const SOLUTION: &'static str = "exact: q, p and w";
    const DOF: Option<usize> = Some(1);

    fn make<T: Scalar>(_n: usize, parameters: &[T]) -> Result<DampedOscillator<T>, InputError> {
        let [k, b] = exactly(parameters)?;
        DampedOscillator::new(k, b)
    }
}

#[cfg(test)]
mod tests {
    use afterbay_core::Passive;

    use super::*;

    #[test]
    fn parameters_have_their_range() {
        for k in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = DampedOscillator::new(k, 0.1).unwrap_err();
            assert!(matches!(
                error,
                InputError::Parameter { name: "k", range: "positive and finite", .. }
            ));
        }
        for b in [f64::NAN, f64::NEG_INFINITY] {
            let error = DampedOscillator::new(1.0, b).unwrap_err();
            assert!(matches!(error, InputError::Parameter { name: "b", range: "finite", .. }));
        }
        assert!(DampedOscillator::new(1.0, -0.1).is_ok());
    }

    #[test]
    fn the_sign_of_b_decides() {
        let damping = |b: f64| DampedOscillator::new(2.0, b).unwrap().dissipation_form();
        assert_eq!(damping(0.0), DissipationForm::NONE);
        assert_eq!(damping(-0.0), DissipationForm::NONE);
        assert_eq!(
            damping(0.1),
            DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
        );
        assert_eq!(damping(-0.1), DissipationForm::LINEAR);
    }

    #[test]
    fn as_a_linear_system_it_is_the_same() {
        let system = DampedOscillator::new(2.0, 0.3).unwrap();
        assert_eq!(system.partial(&[0.0], 0, 1.0), system.stiffness(0, 0));
        assert_eq!(system.dissipation_of(&[0.0], &[1.0], 0).value, system.dissipation_rate(0));
    }
}
