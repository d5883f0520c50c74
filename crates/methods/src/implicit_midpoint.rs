//! The implicit midpoint rule with a reservoir, for any H(q, p), any D and any number of degrees of
//! freedom.
//!
//! ```text
//! q1 - q0 = h v̄        p1 - p0 = -h (∂H/∂q(z̄) + D̄)        w1_j - w0_j = h D̄_j v̄_j
//! z̄ = (z0 + z1)/2        v̄ = ∂H/∂p(z̄)        D̄ = D(z̄, v̄)        z = (q, p)
//! ```
//!
//! It is the Gauss method with one stage (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
//! Integration, II.1), with the reservoir of the paper. It has order 2 in q, p and w, is symmetric,
//! symplectic without dissipation, and A-stable on linear systems but not L-stable. It is passive
//! where the system is, since `Σ Δw_j = h D̄·v̄`.
//!
//! K is conserved where H is quadratic, since then `ΔH = ∇H(z̄)·Δz`. For other H its error is
//! O(h²). [`Gonzalez`](crate::Gonzalez) adds to ∇H(z̄) the multiple of Δz that conserves K, and
//! [`Collocation`](crate::Collocation) with one stage replaces ∇H(z̄) by its mean between z0 and
//! z1.
//!
//! The equations **solved** are those of [`Gonzalez`](crate::Gonzalez) with λ = 0, by the same
//! iteration.
//!
//! A step **fails** and leaves the state unchanged where Newton's iteration finds no solution, also
//! by continuation from h = 0. Beyond the time scale of the system it may find a solution that does
//! not continue from h = 0; this is not checked. The scalar must hold one number, since the linear
//! equations are solved in `f64`.

use crate::commit::commit;
use crate::gonzalez::equation::Workspace;
use crate::gonzalez::lambda::Lambda;
use crate::kernels::reductions::max_norm;
use crate::registry::binding::{Binding, Bound, Target};
use afterbay_core::{Curvature, Effort, InputError, Method, Scalar, State, StepFailure, Vector};

/// The error of an equation, as a share of its terms, at which a solution is rejected.
const LARGEST_DEFECT: f64 = 1e-3;
/// The number of roundings of z̄ and of the forces that are allowed beside [`LARGEST_DEFECT`].
const DEFECT_ROUNDINGS: f64 = 64.0;

/// The implicit midpoint rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImplicitMidpoint;

impl Binding for ImplicitMidpoint {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, _, _>(*self, target.curvature()?)
    }
}

impl<V, S> Method<V, S> for ImplicitMidpoint
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        Workspace::new("implicit-midpoint", system, None, false)
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let mut effort =
            workspace.find(system, h, state, |found| finish(found, system, h, state))?;
        let Workspace { q, p, w, .. } = workspace;
        commit(state, [q.as_slice(), p.as_slice(), w.as_slice()], !system.dissipation_form().zero)?;
        // v̄ and D̄ are evaluated once more, at the solution.
        effort.evaluations += 1;
        Ok(effort)
    }
}

/// Computes v̄, D̄ and w1 at the solution found, and returns whether it solves the equations.
/// Corrections may be small because the Jacobian, evaluated far out, is large.
fn finish<V, S>(found: &mut Workspace<V>, system: &S, h: V::Scalar, state: &State<V>) -> bool
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    found.evaluate(system);
    found.residual(system, h, &Lambda::zero());
    let Workspace { v, d, w, .. } = found;
    let parts = v.as_slice().iter().zip(d.as_slice()).zip(state.w.as_slice());
    for (w1, ((&v, &d), &w0)) in w.as_mut_slice().iter_mut().zip(parts) {
        *w1 = (h * d).mul_add(v, w0);
    }

    let Workspace { dq, dp, q_mean, p_mean, hq, v, d, missing, gain, force_rounding, .. } = found;
    let largest = |z: &V| max_norm(z.as_slice());
    let length = h.to_f64().abs();
    let q = largest(q_mean);
    let p = length.mul_add(*force_rounding, largest(p_mean));
    let terms = [
        length.mul_add(largest(v), largest(dq)),
        length.mul_add(largest(hq) + largest(d), largest(dp)),
    ];
    let rounded = [gain.mul_add(p, q), gain.mul_add(q, p)];
    let rounding = DEFECT_ROUNDINGS * V::Scalar::EPSILON;
    missing.iter().zip(terms).zip(rounded).all(|((missing, terms), rounded)| {
        let allowed = LARGEST_DEFECT.mul_add(terms, rounding * rounded);
        missing.iter().all(|x| x.abs() <= allowed)
    })
}
