//! Gonzalez's midpoint discrete gradient, for any H(q, p), any D and any number of degrees of
//! freedom.
//!
//! ```text
//! q1 - q0 = h ∇̄H_p        p1 - p0 = -h (∇̄H_q + D̄)        w1_j - w0_j = h D̄_j ∇̄H_p,j = D̄_j (q1 - q0)_j
//! ∇̄H = ∇H(z̄) + λ Δz       λ = [H(z1) - H(z0) - ∇H(z̄)·Δz] / |Δz|²
//! z̄ = (z0 + z1)/2         D̄ = D(z̄), with the velocity ∇̄H_p for ∂H/∂p         z = (q, p)
//! ```
//!
//! O. Gonzalez, J. Nonlinear Sci. 6 (1996) 449-467, with the reservoir of the paper. Order 2 in q,
//! p and w, symmetric, A-stable on linear systems but not L-stable. K is exact at any step:
//! `H1 - H0 = ∇̄H·Δz = -Σ Δw_j`. Passive where the system is: with D = R(z) ∂H/∂p,
//! `Σ Δw_j = h ∇̄H_p·R(z̄) ∇̄H_p ≥ 0`.
//!
//! **Rounding.** λ is of the size of Δz, but its numerator is only known to ε|H|. What that does to
//! H1 is ε|H| again, which K has anyway; to z1 it does h ε|H|/|Δz|, a rounding of z where |H| is
//! about |∇H||z|. Beside an equilibrium where H is not 0 it is more: the last digits of K decide
//! the last digits of z, so let H be 0 where the system comes to rest. Where the noise of λ would
//! be felt by the iteration, h ε|H|/|Δz|² > 1e-3, and λ |Δz|², which is what K changes by without
//! it, is at most 16 roundings of H, λ = 0 is taken (the midpoint rule); so it is at rest, Δz = 0.
//!
//! **Several solutions** there may be where h is beyond the system's own time scale. Newton's
//! iteration from Δz = 0 may then take one that does not continue from h = 0; this is not checked.
//! K is exact and the step passive on any of them.
//!
//! **Fails** by name, with the state as it was, where Newton's iteration finds no solution, also
//! when it is followed from h = 0. For scalars that hold one number: the linear equations are
//! solved in `f64`.

mod equation;
mod iteration;
mod jacobian;
mod update;

use crate::linear::LinearSolver;
use afterbay_core::{
    Curvature, Effort, InputError, Mask, Method, Quantity, Scalar, State, StepFailure, Vector,
};
use equation::Workspace;

/// Gonzalez's discrete gradient.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gonzalez {
    /// How its linear equations are solved. `None` chooses by what the system says of itself:
    /// Thomas' algorithm for a separable chain, elimination written out for up to 32 unknowns,
    /// faer's dense LU where everyone acts on everyone, its sparse LU otherwise.
    pub solver: Option<LinearSolver>,
}

impl<V, S> Method<V, S> for Gonzalez
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        Workspace::new(system, self.solver)
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        if h == V::Scalar::zero() {
            // No increment, and no velocity Δq/h to be had of it.
            return Ok(Effort::default());
        }
        let n = state.dof();
        let dissipative = !system.dissipation_form().zero;
        let effort = workspace.find(system, h, state)?;
        let Workspace { q, p, w, energy, .. } = workspace;
        let (q1, p1, w1) = (q.as_slice(), p.as_slice(), w.as_slice());
        let mut finite = energy.is_finite();
        for j in 0..n {
            finite = finite.and(q1[j].is_finite()).and(p1[j].is_finite());
        }
        if dissipative {
            finite = w1.iter().fold(finite, |finite, w| finite.and(w.is_finite()));
        }
        if !finite.all() {
            return Err(StepFailure::non_finite(&[
                (Quantity::Coordinate, q1),
                (Quantity::Momentum, p1),
                (Quantity::Reservoir, w1),
                (Quantity::Energy, &[*energy]),
            ]));
        }
        state.q.as_mut_slice().copy_from_slice(q1);
        state.p.as_mut_slice().copy_from_slice(p1);
        if dissipative {
            state.w.as_mut_slice().copy_from_slice(w1);
        }
        Ok(effort)
    }
}
