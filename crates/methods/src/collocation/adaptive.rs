//! Collocation with steps as long as a tolerance allows, K exact at every one of them.
//!
//! Gauss's collocation with K nodes τ_i, weights b_i and `a_ij = ∫_0^{τ_i} ℓ_j`,
//!
//! ```text
//! p_i = p0 - h Σ_j a_ij f_j        q_i = q0 + h Σ_j a_ij v_j        v = ∂H/∂p        f = ∂H/∂q + D(q, p, v)
//! p1 = p0 - h Σ b_i f_i            q1 = q0 + h Σ b_i v_i            w1 = w0 + h Σ b_i D(q_i, p_i, v_i) v_i
//! ```
//!
//! is solved by sweeps until a tenth of what is allowed of the step is left. Then (q1, p1) goes
//! onto `H = H(q0, p0) - Σ Δw_j` along the gradient of H, scaled by the tolerances, which takes
//! about the error of the step: K is exact, w remains the quadrature, and with weights above 0 Δw ≥
//! 0 where the system is passive. (Projection: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
//! Integration, IV.4.) Steps that cannot be corrected so, next to a point of rest, and steps of
//! stiff systems are those of [`super::Collocation`], which keeps K of itself.
//!
//! Order 8 (K = 4) for a relative tolerance above 1e-5, else 16 (K = 8), in q, p and w, at the
//! times between steps as well: a sample is a step of its own from where the step began, with K
//! exact. A-stable. Sweeps are left for Newton's method where they hold steps back for long.
//!
//! A step aims at an error of its share of what is allowed at the end, by its length. That is what
//! is spent where errors stay; where solutions draw together, or errors cancel, the error at the
//! end is smaller, down to a hundredth and less.
//!
//! Steps allocate nothing, but one: the first that is made by Newton's method, or next to a point
//! of rest, makes the workspace of [`super::Collocation`] for itself. Runs that never need it, and
//! most do not, are spared its memory.
//!
//! **Fails** by name, with the last good state: [`StepFailure`] of the shortest step tried, or
//! `Vanishes`.

use super::engine::Engine;
use super::gauss::Gauss;
use afterbay_core::{
    Adaptive, Attempt, Curvature, Effort, InputError, Quad, State, StepFailure, Tolerance, Vector,
};
use std::sync::LazyLock;

/// Adaptive collocation, of order 8 or 16 by the tolerance: for [`afterbay_core::integrate_within`]
/// and [`afterbay_core::sample_within`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveCollocation;

/// The relative tolerance above which 4 nodes do.
const COARSE: f64 = 1e-5;

static FOUR: LazyLock<Gauss<Quad, 4>> = LazyLock::new(Gauss::new);
static EIGHT: LazyLock<Gauss<Quad, 8>> = LazyLock::new(Gauss::new);

/// The workspace: order 8 or 16.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector>(Order<V>);

#[derive(Clone, Debug)]
enum Order<V: Vector> {
    Eight(Box<Engine<V, 4>>),
    Sixteen(Box<Engine<V, 8>>),
}

macro_rules! with {
    ($workspace:expr, $engine:ident => $body:expr) => {
        match &mut $workspace.0 {
            Order::Eight($engine) => $body,
            Order::Sixteen($engine) => $body,
        }
    };
}

impl<V, S> Adaptive<V, S> for AdaptiveCollocation
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    const LEAST_GROWTH: f64 = 1.1;

    fn workspace(
        &self,
        system: &S,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Workspace<V>, InputError> {
        Ok(Workspace(if tolerance.relative > COARSE {
            Order::Eight(Box::new(Engine::new(system, &FOUR, tolerance, span)))
        } else {
            Order::Sixteen(Box::new(Engine::new(system, &EIGHT, tolerance, span)))
        }))
    }

    fn attempt(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Attempt, StepFailure> {
        with!(workspace, engine => engine.attempt(system, h, state))
    }

    fn end<'a>(&self, workspace: &'a Workspace<V>) -> &'a [V::Scalar] {
        match &workspace.0 {
            Order::Eight(engine) => engine.end_of_attempt(),
            Order::Sixteen(engine) => engine.end_of_attempt(),
        }
    }

    fn accept(&self, state: &mut State<V>, workspace: &mut Workspace<V>) {
        with!(workspace, engine => engine.accept(state));
    }

    fn between(
        &self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        workspace: &mut Workspace<V>,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure> {
        with!(workspace, engine => engine.between(system, h, before, to))
    }
}
