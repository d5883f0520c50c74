//! Radau IIA with step size control, and K exact after every step.
//!
//! ```text
//! z = (q, p)        f = (∂H/∂p, -∂H/∂q - D)        v = ∂H/∂p        Z_i = z0 + h Σ_j a_ij f(Z_j)
//! z1 = Z_s          w1_j = w0_j + h Σ_i b_i D_j(Z_i) v_j(Z_i) + share of the defect of K
//! ```
//!
//! E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8; J. Comput.
//! Appl. Math. 111 (1999) 93-111. Order 2s - 1 in q, p and w, also between steps: a sample is a
//! step of its own from the beginning of the current step, with K exact. Order 5 (s = 3) for a
//! tolerance above 1e-3, 13 (s = 7) up to 1e-8, and 9 (s = 5) between; the smaller of the relative
//! tolerances of (q, p) and w counts.
//!
//! The defect of K, of the size of the error of the step, is divided by the estimated errors: w
//! takes the energy that a fast decay dissipates unresolved, and (q, p) is projected along ∇H by
//! the rest (`radau/balance.rs`). K is exact, and Δw ≥ 0 where the system is passive. On linear
//! passive systems H ≥ 0 then cannot grow at any h. The step before K is restored is L-stable; the
//! projection may give back a part of what has decayed, and then it is as large as the error and
//! rejects the step.
//!
//! The equations are solved by Newton's method to the accuracy the tolerance requires
//! (`radau/solve.rs`), decoupled into systems of N unknowns, or 2N if H is not separable
//! (`linear/phase_space.rs`). Steps do not allocate, except where K differs only by rounding, near
//! rest.
//!
//! A run **fails** with the last accepted state, and reports the [`StepFailure`] of the shortest
//! step tried, or `Vanishes`. Systems whose dense matrix does not fit in memory are refused.

use crate::radau::{Engine, Tables};
use crate::registry::binding::{AdaptiveBinding, Bound, Target};
use afterbay_core::{
    Adaptive, Attempt, Curvature, Effort, InputError, Quad, State, StepFailure, Tolerance, Vector,
};
use std::sync::LazyLock;

/// Adaptive Radau IIA of order 5, 9 or 13, depending on the tolerance, for
/// [`afterbay_core::integrate_within`] and [`afterbay_core::sample_within`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveRadau;

/// The relative tolerances above which 3 and 5 stages are used.
const COARSE: f64 = 1e-3;
const FINE: f64 = 1e-8;

static THREE: LazyLock<Tables<Quad, 3>> = LazyLock::new(Tables::new);
static FIVE: LazyLock<Tables<Quad, 5>> = LazyLock::new(Tables::new);
static SEVEN: LazyLock<Tables<Quad, 7>> = LazyLock::new(Tables::new);

/// The workspace, of order 5, 9 or 13.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector>(Order<V>);

#[derive(Clone, Debug)]
enum Order<V: Vector> {
    Five(Box<Engine<V, 3>>),
    Nine(Box<Engine<V, 5>>),
    Thirteen(Box<Engine<V, 7>>),
}

macro_rules! with {
    ($workspace:expr, $engine:ident => $body:expr) => {
        match &mut $workspace.0 {
            Order::Five($engine) => $body,
            Order::Nine($engine) => $body,
            Order::Thirteen($engine) => $body,
        }
    };
}

impl AdaptiveBinding for AdaptiveRadau {
    fn bind(&self, target: &Target<'_, f64>) -> Bound<f64> {
        let system = target.curvature()?;
        match target.system.dof() {
            1 => target.chosen::<[f64; 1], _, _>(*self, system),
            _ => target.chosen::<Vec<f64>, _, _>(*self, system),
        }
    }
}

impl<V, S> Adaptive<V, S> for AdaptiveRadau
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    /// Matrices are kept as long as the step is. With one degree of freedom they cost little.
    const LEAST_GROWTH: f64 = match V::LEN {
        Some(1) => 1.0,
        _ => 1.2,
    };

    fn workspace(
        &self,
        system: &S,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Workspace<V>, InputError> {
        let relative = tolerance.relative.min(tolerance.w.0);
        Ok(Workspace(if relative > COARSE {
            Order::Five(Box::new(Engine::new(system, &THREE, tolerance, span)?))
        } else if relative > FINE {
            Order::Nine(Box::new(Engine::new(system, &FIVE, tolerance, span)?))
        } else {
            Order::Thirteen(Box::new(Engine::new(system, &SEVEN, tolerance, span)?))
        }))
    }

    #[inline]
    fn attempt(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Attempt, StepFailure> {
        with!(workspace, engine => engine.attempt(system, h, state))
    }

    #[inline]
    fn end<'a>(&self, workspace: &'a Workspace<V>) -> &'a [V::Scalar] {
        match &workspace.0 {
            Order::Five(engine) => engine.q.as_slice(),
            Order::Nine(engine) => engine.q.as_slice(),
            Order::Thirteen(engine) => engine.q.as_slice(),
        }
    }

    #[inline]
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
