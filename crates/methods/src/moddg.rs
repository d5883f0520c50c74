//! The modified discrete gradient of the paper, for one degree of freedom (eq. modgr).
//!
//! ```text
//! q1 - q0 = δ(q) p̄/m        p1 - p0 = -δ(p) (ΔV/Δq + D̄)        w1 - w0 = δ(w) D̄ p̄/m
//! p̄ = (p0 + p1)/2        ΔV/Δq = [V(q1) - V(q0)]/(q1 - q0)        D̄ = D((q0 + q1)/2, p̄)
//! ```
//!
//! With δ = h in all three equations (the plain scheme) the method has order 2, is symmetric, is
//! passive where D is, and is A-stable on linear systems but not L-stable. K is exact for any step
//! size and any system if the *same* δ stands in all three equations ([`steps`] describes other
//! choices): `H1 - H0 = p̄/m Δp + (ΔV/Δq) Δq = -δ D̄ p̄/m = -Δw`.
//!
//! A step **solves** one scalar equation for the mean momentum v = p̄, `v = p0 - δ(p)/2 (ΔV/Δq +
//! D̄)(v)`, which is regular at turning points, where Δq = 0. [`ClosedForm`] evaluates the solution
//! for linear systems. For all others a [`Solver`](afterbay_core::solver::Solver) computes it to
//! rounding: [`Newton`], with continuation from h = 0, or fixed-point iteration
//! ([`FixedPoint`](afterbay_core::solver::FixedPoint)).
//!
//! A step **fails** and leaves the state unchanged where
//! - a number is not finite ([`StepFailure::NonFinite`]), or a δ has a pole (`Pole`);
//! - the equation is not solved: `Singular` in closed form, `NewtonStalled` or `SeveralSolutions`
//!   by Newton's method, `NotContracting` by fixed-point iteration;
//! - V is singular on the edge (`AcrossSingularity`);
//! - divided differences by quadrature are not resolved (`EdgeUnresolved`) or lose K
//!   (`BalanceLost`).

pub mod steps;

mod binding;
mod closed_form;
mod driven;
mod implicit;

pub use closed_form::ClosedForm;

use crate::commit::not_finite_by_value;
use afterbay_core::solver::Newton;
use afterbay_core::{
    InputError, Mask, Scalar, Separable, Single, State, StepFailure, Vector, validate,
};
use steps::Plain;

/// The modified discrete gradient with step sizes `D` ([`Plain`], [`steps::Raised`] or
/// [`steps::Printed`]). `E` solves its equation: [`ClosedForm`] or a
/// [`Solver`](afterbay_core::solver::Solver).
#[derive(Clone, Copy, Debug, Default)]
pub struct ModDg<D = Plain, E = Newton> {
    /// The step sizes δ in the three equations.
    pub steps: D,
    /// The solver of the equation for the mean momentum.
    pub solver: E,
}

impl ModDg {
    /// The plain scheme for any system, with Newton's method.
    pub const fn newton() -> Self {
        Self { steps: Plain, solver: Newton }
    }
}

impl ModDg<Plain, ClosedForm> {
    /// The plain scheme for linear systems, in closed form.
    pub const fn linear() -> Self {
        Self { steps: Plain, solver: ClosedForm }
    }
}

/// Checks that the system has one degree of freedom and a valid mass.
fn one_degree_of_freedom<T: Scalar>(
    system: &(impl Separable<T> + ?Sized),
) -> Result<(), InputError> {
    let why = "the scheme applies to one degree of freedom only";
    if system.dof() != 1 {
        return Err(InputError::Unsupported { method: "moddg", why });
    }
    validate::masses(system)
}

/// Writes the new state if it is finite. Without dissipation w is not written.
#[inline(always)]
fn commit<V: Vector>(
    state: &mut State<V>,
    q: V::Scalar,
    p: V::Scalar,
    w: Option<V::Scalar>,
) -> Result<(), StepFailure> {
    let finite = |x: V::Scalar| x.is_finite().all();
    if !(finite(q) && finite(p) && w.is_none_or(finite)) {
        return Err(not_finite_by_value([q, p, w.unwrap_or(V::Scalar::zero())].map(Single)));
    }
    state.q.as_mut_slice()[0] = q;
    state.p.as_mut_slice()[0] = p;
    if let Some(w) = w {
        state.w.as_mut_slice()[0] = w;
    }
    Ok(())
}
