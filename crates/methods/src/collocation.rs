//! Energy-preserving collocation of order 2s, for any H(q, p), any D and any number of degrees of
//! freedom.
//!
//! With P_j the orthonormal Legendre polynomials on [0, 1] and k Gauss nodes τ_i with weights b_i,
//!
//! ```text
//! z(τ) = z0 + h Σ_{j<s} γ_j ∫_0^τ P_j             z = (q, p)         z1 = z0 + h γ_0
//! ĝ_j = Σ_i b_i P_j(τ_i) ∇H(z(τ_i))               v(τ) = Σ_{j<s} ĝ_{p,j} P_j(τ)
//! γ_{q,j} = ĝ_{p,j}            γ_{p,j} = -ĝ_{q,j} - Σ_i b_i P_j(τ_i) D(z(τ_i), v(τ_i))
//! w1 - w0 = h Σ_i b_i D(z(τ_i), v(τ_i)) · v(τ_i)   for each degree of freedom
//! ```
//!
//! Sources, for D = 0: L. Brugnano, F. Iavernaro, D. Trigiante, J. Numer. Anal. Ind. Appl. Math. 5
//! (2010) 17-37 (HBVM(k, s)) and E. Hairer, the same volume, 73-84; the reservoir is that of the
//! paper. Since z' = Σ γ_j P_j, v = q' and Δq = h ∫ v. If the quadrature integrates ∇H·z' exactly,
//! `ΔH = h Σ γ_j·ĝ_j = -h Σ_i b_i D·v = -Σ Δw_j`, and K is exact for any step size. This holds for
//! polynomial H of degree up to 2k/s. For other H the quadrature error is of order 2k. If it
//! exceeds rounding, the step is repeated with twice the nodes, up to 64, and fails if these do not
//! resolve H either. [`Workspace::defect`] returns the error of K.
//!
//! The method has order 2s in q, p and w, is symmetric, and is A-stable on linear systems but not
//! L-stable. It is passive where the system is, at every order, since the weights are positive and
//! D·v ≥ 0 for D = R v with passive R.
//!
//! The equations are solved by fixed-point iteration where it contracts, else by Newton's method.
//! Its linear equations decouple into one system per eigenvalue, with N unknowns each, and cost
//! O(N) if only neighbours are coupled. The first step that needs Newton's method with more than
//! 2048 unknowns, or with the exact derivative over the step, allocates memory.
//!
//! A step **fails** and leaves the state unchanged where Newton's iteration finds no solution that
//! continues from h = 0, and where the coupling is all-to-all and the matrices would need more than
//! 4 GB. The scalar must hold one number, since convergence is tested in `f64`.

mod defect;
mod equations;
mod exact_newton;
mod in_turn;
mod iteration;
mod krylov;
mod newton;
mod nodes;
mod progress;
mod rounding;
mod rule;
mod spectrum;

use crate::legendre::MODES;
use crate::linear::check_derivatives;
use crate::registry::binding::{Binding, Bound, Target};
use afterbay_core::{Curvature, Effort, InputError, Method, State, StepFailure, Vector};

pub(crate) use equations::Response;
pub(crate) use iteration::Workspace;
pub(crate) use rule::MOST_NODES;

/// Energy-preserving collocation with s stages and k quadrature nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collocation {
    /// The number of stages s, 1 to 8; the order is 2s.
    pub stages: usize,
    /// The number of quadrature nodes k, 2s to 64, rounded up to 8, 16, 32 or 64, since nodes are
    /// computed eight at a time.
    pub nodes: usize,
}

impl Collocation {
    /// Uses s stages and 2s nodes, sufficient for H of degree 4.
    pub const fn new(stages: usize) -> Self {
        Self { stages, nodes: 2 * stages }
    }
}

impl Binding for Collocation {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, _, _>(*self, target.curvature()?)
    }
}

impl<V, S> Method<V, S> for Collocation
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let outside =
            |name, value: usize, range| InputError::Parameter { name, value: value as f64, range };
        if !(1..=MODES).contains(&self.stages) {
            return Err(outside("stages", self.stages, "1 to 8"));
        }
        if !(2 * self.stages..=MOST_NODES).contains(&self.nodes) {
            return Err(outside("nodes", self.nodes, "twice the stages to 64"));
        }
        check_derivatives("collocation", system)?;
        Ok(Workspace::new(system, self.stages, self.nodes))
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let effort = workspace.find(system, h, state)?;
        workspace.commit(state);
        Ok(effort)
    }
}
