//! The locally exact discrete gradient, for any H(q, p), any D and any number of degrees of
//! freedom.
//!
//! ```text
//! z1 - z0 = h φ(hA) f̄        φ(X) = 2 X⁻¹ tanh(X/2)        z̄ = (z0 + z1)/2        z = (q, p)
//! A = B S - [ 0 0 ; E 0 ]    S = H''(z̄)    B = [ 0 1 ; -1 -R ]
//! f̄ = (∇̄H_p, -∇̄H_q - D̄)     D̄ = D(z̄) with the velocity ∇̄H_p
//! ∇̄H = ∇H(z̄) + λ (z1 - z0), the midpoint discrete gradient
//! ```
//!
//! J. L. Cieslinski, B. Ratkiewicz, Phys. Rev. E 81 (2010) 016704 for D = 0. The step follows the
//! path u' = A u from z0 to z1 for which f̄ is the mean of u at both ends. With u(0) = f̄ - ½ A Δz
//! and y = ∫ u it reads
//!
//! ```text
//! Δz = y(h) = h φ₁(hA) u(0)        φ₁(X) = X⁻¹ (e^X - 1)
//! ```
//!
//! This form has none of the poles of tanh. It is solved by fixed-point iteration, which needs one
//! iteration for a linear system. Along the path the gradient is g(τ) = ∇̄H + S (y - ½ Δz), the
//! velocity v = g_p and the friction D̂ = D̄ + R (v - ∇̄H_p) + E (y_q - ½ Δq), so that y' = (v,
//! -g_q - D̂), and
//!
//! ```text
//! w1_j - w0_j = ∫_0^h D̂_j v_j dτ
//! ```
//!
//! For symmetric S, `∇̄H·Δz = ∫ g·y' = -∫ D̂·v`, since the contributions of S y cancel between the
//! ends. So `H1 - H0 = ∇̄H·Δz = -Σ Δw_j`, and K is exact for any step size and any S, R and E.
//! The method has order 2 in q, p and w and is symmetric. It is exact, including w, if H is
//! quadratic and D linear in (q, v).
//!
//! R satisfies D̄ = D(z̄, v = 0) + R ∇̄H_p, and its symmetric part is positive semidefinite where
//! the system is passive (`slopes.rs`). R is the matrix itself if D is linear in v, a diagonal
//! matrix of secants if each reservoir is passive by itself, and otherwise a multiple of 1 plus a
//! skew part. E is ∂D/∂q at fixed v if the system is linear, else 0. Then D̂ = R v, and the steps
//! are passive where the system is, in each degree of freedom or in the sum, because the quadrature
//! weights are positive. Friction must be computed from the velocity v, as
//! [`afterbay_core::System::dissipation`] requires. Friction computed from p has R = 0; K and order
//! 2 are retained, but the step is neither passive nor exact on linear systems.
//!
//! A step **fails** and leaves the state unchanged where the iteration does not contract or h |A|
//! exceeds 1000. For scalars that hold one number.

mod equation;
mod iteration;
mod slopes;

use crate::commit::commit;
use crate::hidden_coupling::states_coupling;
use crate::registry::binding::{Binding, Bound, Target};
use afterbay_core::{Curvature, Effort, InputError, Method, Scalar, State, StepFailure, Vector};
use equation::Workspace;

/// The locally exact discrete gradient method.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocallyExact;

impl Binding for LocallyExact {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        // D may then be written in p, and the workspace does not know this.
        if let Ok(separable) = target.separable() {
            states_coupling(target.name, &*separable, true)?;
        }
        target.fixed::<V, _, _>(*self, target.curvature()?)
    }
}

impl<V, S> Method<V, S> for LocallyExact
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        states_coupling("locally-exact", system, false)?;
        Workspace::new(system)
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        if h == V::Scalar::zero() {
            return Ok(Effort::default());
        }
        let effort = workspace.find(system, h, state)?;
        commit(state, workspace.ends(), !system.dissipation_form().zero)?;
        Ok(effort)
    }
}
