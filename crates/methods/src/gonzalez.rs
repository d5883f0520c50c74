//! Gonzalez's midpoint discrete gradient, for any H(q, p), any D and any number of degrees of
//! freedom.
//!
//! ```text
//! q1 - q0 = h ∇̄H_p        p1 - p0 = -h (∇̄H_q + D̄)
//! w1_j - w0_j = h D̄_j ∇̄H_p,j = D̄_j Δq_j
//! ∇̄H = ∇H(z̄) + λ Δz       λ = [H(z1) - H(z0) - ∇H(z̄)·Δz] / |Δz|²       z = (q, p)
//! z̄ = (z0 + z1)/2         D̄ = D(z̄), with the velocity ∇̄H_p for ∂H/∂p
//! ```
//!
//! O. Gonzalez, J. Nonlinear Sci. 6 (1996) 449-467, with the reservoir of the paper. The method has
//! order 2 in q, p and w, is symmetric, and is A-stable on linear systems but not L-stable. K is
//! exact at any step: `H1 - H0 = ∇̄H·Δz = -Σ Δw_j`. The method is passive where the system is: with
//! D = R(z) ∂H/∂p, `Σ Δw_j = h ∇̄H_p·R(z̄) ∇̄H_p ≥ 0`.
//!
//! **Rounding.** λ is of the size of Δz, but its numerator is known only to ε|H|. This changes H1
//! by ε|H|, which is the rounding of K in any case. It changes z1 by h ε|H|/|Δz|, which is a
//! rounding of z if |H| is about |∇H||z|. Near an equilibrium with H ≠ 0 it is more: the last
//! digits of K determine the last digits of z. Choose H such that it is 0 where the system comes to
//! rest. The step uses λ = 0 (the midpoint rule) if both conditions hold: the noise of λ would
//! disturb the iteration, h ε|H|/|Δz|² > 1e-3, and K changes without λ by at most 16 roundings of H
//! (the change is λ |Δz|²). It also uses λ = 0 if Δz = 0.
//!
//! **Several solutions** may exist if h exceeds the time scale of the system. Newton's iteration
//! from Δz = 0 may then converge to one that does not continue from h = 0; this is not checked. K
//! is exact and the step passive on each of them.
//!
//! A step **solves** 2N equations for Δz, to rounding. Newton's iteration starts from Δz = 0 and
//! keeps its Jacobian while corrections shrink fast. If it does not converge, the solution is
//! continued from h = 0. The linear equations are solved in `f64`, by a solver chosen by the
//! coupling ([`Gonzalez::solver`]): only scalars that hold one number are possible. K that is off
//! by more than 16 roundings is restored by a move of (q, p) along ∇H. The Euclidean norm of this
//! move is at most 1e-8 of the largest |q_j| or |p_j|.
//!
//! A step **fails** and leaves the state unchanged where Newton's iteration finds no solution, also
//! by continuation ([`StepFailure::NewtonStalled`]), where the linear equations are singular
//! (`Singular`), and where a number is not finite (`NonFinite`).

// A step: `iteration` corrects Δz until `equation` is solved, with the matrices of `jacobian`; then
// `update` computes w1 and restores K.
pub(crate) mod equation;
mod iteration;
mod jacobian;
pub(crate) mod lambda;
mod update;

use crate::commit;
use crate::linear::LinearSolver;
use crate::registry::binding::{Binding, Bound, Target};
use afterbay_core::{
    Curvature, Effort, InputError, Mask, Method, Quantity, Scalar, State, StepFailure, Vector,
};
use equation::Workspace;

/// Gonzalez's discrete gradient method.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gonzalez {
    /// The solver of the linear equations. `None` chooses by the second derivatives of the system:
    /// Thomas' algorithm for a separable chain or ring, Gaussian elimination for up to 32 unknowns,
    /// faer's dense LU for matrices with many entries, its sparse LU otherwise.
    pub solver: Option<LinearSolver>,
}

impl Binding for Gonzalez {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, _, _>(*self, target.curvature()?)
    }
}

impl<V, S> Method<V, S> for Gonzalez
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        Workspace::new("gonzalez", system, self.solver, true)
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        if h == V::Scalar::zero() {
            // The state does not change, and the velocity Δq/h is undefined.
            return Ok(Effort::default());
        }
        let dissipative = !system.dissipation_form().zero;
        let effort = workspace.find(system, h, state, |found| found.finish(system, h, state))?;
        let Workspace { q, p, w, energy, .. } = workspace;
        let ends = [q.as_slice(), p.as_slice(), w.as_slice()];
        if !energy.is_finite().all() {
            commit::check(ends)?;
            return Err(StepFailure::non_finite(&[(Quantity::Energy, &[*energy])]));
        }
        commit::commit(state, ends, dissipative)?;
        Ok(effort)
    }
}
