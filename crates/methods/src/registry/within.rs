//! Methods that choose their steps, by name, and bound to a system for whoever knows neither.

use super::Show;
use super::run::Place;
use crate::{AdaptiveCollocation, AdaptiveDop853};
use afterbay_core::{
    Adaptive, Curvature, InputError, IntegrateError, Quantity, State, Statistics, Tolerance, Vector,
    integrate_within, sample_within,
};
use std::marker::PhantomData;

/// A method that takes a tolerance instead of a step, and keeps K. It is no row of [`METHODS`](super::METHODS).
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveRow {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// One line on what it is.
    pub about: &'static str,
    /// The order in q, p and w of the least accurate of its forms.
    pub order: u32,
    /// Every Δw_j ≥ 0 where the system is [`Passive::Each`](afterbay_core::Passive::Each), and their sum where it is
    /// [`Passive::InSum`](afterbay_core::Passive::InSum).
    pub passive: bool,
    /// Steps are as long as the tolerance allows however stiff the system is.
    pub a_stable: bool,
    /// What a step costs, in words.
    pub cost: &'static str,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Collocation,
    Dop853,
}

/// Every method that chooses its steps; the first is the one for any system.
pub const ADAPTIVE: [AdaptiveRow; 2] = [
    AdaptiveRow {
        name: "adaptive-collocation",
        about: "Gauss collocation of order 8 or 16, its steps and K by the tolerance",
        order: 8,
        passive: true,
        a_stable: true,
        cost: "equations, 4 or 8 nodes",
        kind: Kind::Collocation,
    },
    AdaptiveRow {
        name: "adaptive-dop853",
        about: "DOP853, its steps and K by the tolerance",
        order: 8,
        passive: false,
        a_stable: false,
        cost: "12 evaluations",
        kind: Kind::Dop853,
    },
];

/// The row of a method that chooses its steps.
pub fn find_adaptive(name: &str) -> Option<&'static AdaptiveRow> {
    ADAPTIVE.iter().find(|row| row.name == name)
}

/// A method that chooses its steps bound to a system, their types and the storage of the steps forgotten.
pub struct Within(Box<dyn Erased>);

impl Within {
    /// [`integrate_within`], every step shown.
    ///
    /// # Errors
    /// Those of [`integrate_within`].
    pub fn run<V: Vector<Scalar = f64>>(
        &self,
        tolerance: &Tolerance,
        end: f64,
        state: &mut State<V>,
        show: Show<'_, f64>,
    ) -> Result<Statistics, IntegrateError> {
        state.check(self.0.dof())?;
        self.0.run(tolerance, end, Place::of(state), show)
    }

    /// [`sample_within`].
    ///
    /// # Errors
    /// Those of [`sample_within`].
    pub fn sample<V: Vector<Scalar = f64>>(
        &self,
        tolerance: &Tolerance,
        times: &[f64],
        state: &mut State<V>,
        show: Show<'_, f64>,
    ) -> Result<Statistics, IntegrateError> {
        state.check(self.0.dof())?;
        self.0.sample(tolerance, times, Place::of(state), show)
    }
}

trait Erased: Send + Sync {
    fn dof(&self) -> usize;
    fn run(
        &self,
        tolerance: &Tolerance,
        end: f64,
        place: Place<'_, f64>,
        show: Show<'_, f64>,
    ) -> Result<Statistics, IntegrateError>;
    fn sample(
        &self,
        tolerance: &Tolerance,
        times: &[f64],
        place: Place<'_, f64>,
        show: Show<'_, f64>,
    ) -> Result<Statistics, IntegrateError>;
}

struct Bound<V, M, S> {
    method: M,
    system: S,
    storage: PhantomData<fn() -> V>,
}

impl<V, M, S> Erased for Bound<V, M, S>
where
    V: Vector<Scalar = f64>,
    S: Curvature<f64>,
    M: Adaptive<V, S> + Send + Sync,
{
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn run(
        &self,
        tolerance: &Tolerance,
        end: f64,
        place: Place<'_, f64>,
        show: Show<'_, f64>,
    ) -> Result<Statistics, IntegrateError> {
        let mut state = place.take::<V>();
        let mut look = |step: u64, state: &State<V>| show(step, state.state_ref());
        let outcome = integrate_within(&self.method, &self.system, tolerance, end, &mut state, &mut look);
        place.put(&state);
        outcome
    }

    fn sample(
        &self,
        tolerance: &Tolerance,
        times: &[f64],
        place: Place<'_, f64>,
        show: Show<'_, f64>,
    ) -> Result<Statistics, IntegrateError> {
        let mut state = place.take::<V>();
        let mut look = |n: u64, state: &State<V>| show(n, state.state_ref());
        let outcome = sample_within(&self.method, &self.system, tolerance, times, &mut state, &mut look);
        place.put(&state);
        outcome
    }
}

/// Binds a method that chooses its steps to a system; states of few degrees of freedom on the stack.
///
/// # Errors
/// [`InputError::Length`] for a system without a degree of freedom.
pub fn adaptive<S: Curvature<f64> + 'static>(row: &AdaptiveRow, system: S) -> Result<Within, InputError> {
    match (row.kind, system.dof()) {
        (_, 0) => Err(InputError::Length { quantity: Quantity::Coordinate, expected: 1, found: 0 }),
        (Kind::Collocation, 1) => Ok(bind::<[f64; 1], _, _>(AdaptiveCollocation, system)),
        (Kind::Collocation, _) => Ok(bind::<Vec<f64>, _, _>(AdaptiveCollocation, system)),
        (Kind::Dop853, 1) => Ok(bind::<[f64; 1], _, _>(AdaptiveDop853, system)),
        (Kind::Dop853, 2) => Ok(bind::<[f64; 2], _, _>(AdaptiveDop853, system)),
        (Kind::Dop853, _) => Ok(bind::<Vec<f64>, _, _>(AdaptiveDop853, system)),
    }
}

fn bind<V, M, S>(method: M, system: S) -> Within
where
    V: Vector<Scalar = f64> + 'static,
    S: Curvature<f64> + 'static,
    M: Adaptive<V, S> + Send + Sync + 'static,
{
    Within(Box::new(Bound { method, system, storage: PhantomData::<fn() -> V> }))
}
