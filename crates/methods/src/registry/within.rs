//! The adaptive method bound to a system, for whoever knows neither.

use super::Show;
use super::run::Place;
use crate::AdaptiveCollocation;
use afterbay_core::{
    Curvature, InputError, IntegrateError, Quantity, State, Statistics, Tolerance, Vector, integrate_within,
    sample_within,
};
use std::marker::PhantomData;

/// The name of adaptive collocation in scenes and tables. It takes a tolerance instead of a step, so it is no row of the registry.
pub const ADAPTIVE: &str = "adaptive-collocation";

/// [`AdaptiveCollocation`] bound to a system, its type and the storage of its steps forgotten.
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

struct Bound<V, S> {
    system: S,
    storage: PhantomData<fn() -> V>,
}

impl<V: Vector<Scalar = f64>, S: Curvature<f64>> Erased for Bound<V, S> {
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
        let mut look = |step: u64, state: &State<V>| show(step, state.view());
        let outcome =
            integrate_within(&AdaptiveCollocation, &self.system, tolerance, end, &mut state, &mut look);
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
        let mut look = |n: u64, state: &State<V>| show(n, state.view());
        let outcome =
            sample_within(&AdaptiveCollocation, &self.system, tolerance, times, &mut state, &mut look);
        place.put(&state);
        outcome
    }
}

/// Binds adaptive collocation to a system; states of one degree of freedom on the stack.
///
/// # Errors
/// [`InputError::Length`] for a system without a degree of freedom.
pub fn adaptive<S: Curvature<f64> + 'static>(system: S) -> Result<Within, InputError> {
    match system.dof() {
        0 => Err(InputError::Length { quantity: Quantity::Coordinate, expected: 1, found: 0 }),
        1 => Ok(Within(Box::new(Bound::<[f64; 1], S> { system, storage: PhantomData }))),
        _ => Ok(Within(Box::new(Bound::<Vec<f64>, S> { system, storage: PhantomData }))),
    }
}
