//! The paper's modified discrete gradient, for one degree of freedom (eq. modgr).
//!
//! ```text
//! q1 - q0 = δ(q) p̄/m        p1 - p0 = -δ(p) (ΔV/Δq + D̄)        w1 - w0 = δ(w) D̄ p̄/m
//! p̄ = (p0 + p1)/2        ΔV/Δq = [V(q1) - V(q0)]/(q1 - q0)        D̄ = D((q0 + q1)/2, p̄)
//! ```
//!
//! With δ = h in all three (the plain scheme): order 2, symmetric, passive where D is, A-stable on
//! linear systems but not L-stable. K is exact, for any step and any system, as long as the *same*
//! δ stands in all three equations ([`steps`] has the others):
//! `H1 - H0 = p̄/m Δp + (ΔV/Δq) Δq = -δ D̄ p̄/m = -Δw`.
//!
//! The mean momentum v = p̄ is solved for: `v = p0 - δ(p)/2 (ΔV/Δq + D̄)(v)` is regular at turning
//! points, where Δq = 0. [`ClosedForm`] writes the solution down for linear systems; a
//! [`Solver`](afterbay_core::solver::Solver) finds it for the others.

pub mod steps;

mod closed_form;
mod implicit;

pub use closed_form::ClosedForm;

use afterbay_core::solver::Newton;
use afterbay_core::{
    InputError, Mask, Quantity, Scalar, Separable, State, StepFailure, Vector, validate,
};
use steps::Plain;

/// The modified discrete gradient with the step sizes `D` ([`Plain`], [`steps::Raised`],
/// [`steps::Printed`]), its equation solved by `E` ([`ClosedForm`], or a
/// [`Solver`](afterbay_core::solver::Solver)).
#[derive(Clone, Copy, Debug, Default)]
pub struct ModDg<D = Plain, E = Newton> {
    /// δ in each equation.
    pub steps: D,
    /// How the equation is solved.
    pub solver: E,
}

impl ModDg {
    /// The plain scheme for any system, solved by Newton's method.
    pub const fn newton() -> Self {
        Self { steps: Plain, solver: Newton }
    }
}

impl ModDg<Plain, ClosedForm> {
    /// The plain scheme for linear systems.
    pub const fn linear() -> Self {
        Self { steps: Plain, solver: ClosedForm }
    }
}

/// [`ModDg`] has one degree of freedom, and it has a mass.
fn one_degree_of_freedom<T: Scalar>(
    system: &(impl Separable<T> + ?Sized),
) -> Result<(), InputError> {
    let why = "it is the scheme for one degree of freedom";
    if system.dof() != 1 {
        return Err(InputError::Unsupported { method: "moddg", why });
    }
    validate::masses(system)
}

/// Takes the new state if it is finite. A system without dissipation has no reservoir to write.
#[inline(always)]
fn commit<V: Vector>(
    state: &mut State<V>,
    q: V::Scalar,
    p: V::Scalar,
    w: Option<V::Scalar>,
) -> Result<(), StepFailure> {
    let finite = |x: V::Scalar| x.is_finite().all();
    if !(finite(q) && finite(p) && w.is_none_or(finite)) {
        let w = w.unwrap_or(V::Scalar::zero());
        return Err(StepFailure::non_finite(&[
            (Quantity::Coordinate, &[q]),
            (Quantity::Momentum, &[p]),
            (Quantity::Reservoir, &[w]),
        ]));
    }
    state.q.as_mut_slice()[0] = q;
    state.p.as_mut_slice()[0] = p;
    if let Some(w) = w {
        state.w.as_mut_slice()[0] = w;
    }
    Ok(())
}
