//! The modified Van der Pol oscillator: the force of [`VanDerPol`] on the potential of [`Duffing`].
//!
//! ```text
//! q' = p        p' = -α q - β q³ + μ (1 - q²) p        w' = -μ (1 - q²) p²
//! H = p²/2 + α q²/2 + β q⁴/4                           D = -μ (1 - q²) p
//! ```
//!
//! Parameters, all finite, with q in half-widths of the driven strip and a unit mass: μ in 1/time,
//! α and β in 1/time². α = 1, β = 0 is the Van der Pol oscillator; β < 0 leaves V unbounded below;
//! α < 0 < β puts the minima of a double well at q = ±√(-α/β).
//!
//! Invariant: K = H + w. For μ ≠ 0 the reservoir gives and takes by turns, so D is never passive.
//! There is no closed solution: references come from [`afterbay_core::taylor::trajectory`] in a
//! wider scalar.
//!
//! The paper names a modified Van der Pol system and does not define it; this one is ours.

use crate::family::{BY_SERIES, Family, Parameter, exactly};
use crate::{Duffing, VanDerPol};
use afterbay_core::{
    Abilities, Block, Curvature, Dissipation, DissipationForm, InputError, Line, OrderRaising,
    Scalar, SecondDerivatives, Separable, System,
};
use std::sync::Arc;

/// V = α q²/2 + β q⁴/4 with D = -μ (1 - q²) p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifiedVanDerPol<T> {
    potential: Duffing<T>,
    force: VanDerPol<T>,
}

impl<T: Scalar> ModifiedVanDerPol<T> {
    /// The oscillator with nonlinearity μ and stiffness α + β q².
    ///
    /// # Errors
    /// [`InputError::Parameter`] if one is not finite.
    pub fn new(mu: T, alpha: T, beta: T) -> Result<Self, InputError> {
        let force = VanDerPol::new(mu)?;
        Ok(Self { potential: Duffing::new(alpha, beta, T::zero())?, force })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> ModifiedVanDerPol<U> {
        ModifiedVanDerPol { potential: self.potential.map(&f), force: self.force.map(&f) }
    }
}

impl<T: Scalar> System<T> for ModifiedVanDerPol<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        1
    }

    #[inline(always)]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        self.potential.energy(q, p)
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        self.potential.gradient(q, p, hq, hp);
    }

    #[inline(always)]
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.force.dissipation(q, p, v, d);
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        self.force.dissipation_form()
    }
}

impl<T: Scalar> Separable<T> for ModifiedVanDerPol<T> {
    #[inline(always)]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        self.potential.partial(q, j, at)
    }

    #[inline(always)]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        self.potential.divided_difference(q, j, to)
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        self.force.dissipation_of(q, p, j)
    }
}

impl<T: Scalar> Curvature<T> for ModifiedVanDerPol<T> {
    #[inline(always)]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        // The inner Duffing oscillator has c = 0, so that its derivatives of D are 0.
        self.potential.curvature(q, p, |block, i, j, x| {
            if block != Block::Dp {
                put(block, i, j, x);
            }
        });
        let drag = self.dissipation_of(q, p, 0);
        put(Block::Dq, 0, 0, drag.by_q);
        put(Block::Dp, 0, 0, drag.by_p);
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        self.force.is_linear() && self.potential.is_linear()
    }
}

impl<T: Scalar> Abilities<T> for ModifiedVanDerPol<T> {
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

impl Family for ModifiedVanDerPol<f64> {
    type Of<T: Scalar> = ModifiedVanDerPol<T>;

    const NAME: &'static str = "modified-van-der-pol";
    const EQUATIONS: &'static str = "V = α q²/2 + β q⁴/4, D = -μ (1 - q²) p";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new("mu", "1/time"),
        Parameter::new("alpha", "1/time²"),
        Parameter::new("beta", "1/(length² time²)"),
    ];
    const RANGES: &'static str = "any";
    const SOLUTION: &'static str = BY_SERIES;
    const DOF: Option<usize> = Some(1);

    fn make<T: Scalar>(_n: usize, parameters: &[T]) -> Result<ModifiedVanDerPol<T>, InputError> {
        let [mu, alpha, beta] = exactly(parameters)?;
        ModifiedVanDerPol::new(mu, alpha, beta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::OrderRaising;

    #[test]
    fn parameters_are_finite() {
        let nan = f64::NAN;
        for (system, name) in [
            (ModifiedVanDerPol::new(nan, 1.0, 1.0), "mu"),
            (ModifiedVanDerPol::new(1.0, nan, 1.0), "alpha"),
            (ModifiedVanDerPol::new(1.0, 1.0, nan), "beta"),
        ] {
            assert!(
                matches!(system, Err(InputError::Parameter { name: found, .. }) if found == name)
            );
        }
    }

    #[test]
    fn without_a_cubic_term_it_is_van_der_pol() {
        let (system, plain) =
            (ModifiedVanDerPol::new(3.0, 1.0, 0.0).unwrap(), VanDerPol::new(3.0).unwrap());
        let (q, p, to) = ([0.7], [-1.3], 0.9);
        assert_eq!(system.dissipation_form(), plain.dissipation_form());
        assert_eq!(system.dissipation_of(&q, &p, 0), plain.dissipation_of(&q, &p, 0));
        assert_eq!(system.divided_difference(&q, 0, to), plain.divided_difference(&q, 0, to));
        assert_eq!(system.delta_q(q[0], p[0]), plain.delta_q(q[0], p[0]));
    }
}
