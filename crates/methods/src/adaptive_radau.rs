//! Radau IIA with step size control, and K exact after every step.

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
