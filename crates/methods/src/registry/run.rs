//! A method bound to a system, with the types of both erased.

use super::erased::{Chosen, Erased, Fixed, Part, Place, Sampling, Show, named};
use afterbay_core::{
    Adaptive, Effort, Grid, InputError, IntegrateError, Mask, Method, Quantity, Scalar, State,
    Statistics, System, Tolerance, Vector, Watch,
};
use std::sync::Arc;

/// The step control of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting<T> {
    /// The steps, for methods that take a step. Their times are counted from that of the state.
    Step(Grid<T>),
    /// A tolerance and the time of the end, for methods that choose their steps.
    Tolerance(Tolerance, T),
}

impl<T> From<Grid<T>> for Setting<T> {
    fn from(grid: Grid<T>) -> Self {
        Self::Step(grid)
    }
}

/// Takes a step of the given length. A method that chooses its steps passes the states between its
/// own steps to the watch. The time of the state does not change, and the state is unchanged after
/// an error.
pub type Stepping<'a, T> =
    Box<dyn FnMut(T, &mut State<Vec<T>>, Watch<'_, T>) -> Result<Effort, IntegrateError> + 'a>;

/// A method bound to a system. The types of both, and the storage of states, are erased.
pub struct Run<T: Scalar> {
    pub(super) method: &'static str,
    pub(super) bound: Box<dyn Erased<T>>,
}

impl<T: Scalar> std::fmt::Debug for Run<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (method, dof) = (self.method, self.bound.dof());
        f.debug_struct("Run").field("method", &method).field("dof", &dof).finish_non_exhaustive()
    }
}

impl<T: Scalar> Run<T> {
    /// Integrates `state` under the given setting and shows every `stride`-th state. See
    /// [`integrate`](afterbay_core::integrate) and
    /// [`integrate_within`](afterbay_core::integrate_within).
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the setting does not match the kind of the method, and the
    /// errors of [`integrate`](afterbay_core::integrate) and
    /// [`integrate_within`](afterbay_core::integrate_within).
    pub fn run<V: Vector<Scalar = T>>(
        &self,
        setting: impl Into<Setting<T>>,
        state: &mut State<V>,
        stride: u64,
        show: Show<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        match setting.into() {
            Setting::Step(grid) => {
                let remainder = &mut vec![T::zero(); state.dof()];
                self.run_part(Part { grid, first: 0, stride, remainder }, state, show)
            }
            Setting::Tolerance(tolerance, end) => {
                self.check(state)?;
                let place = Place::of(state);
                let found = self.bound.run_within(&tolerance, end, place, stride, show);
                found.map_err(|error| self.named(error))
            }
        }
    }

    /// Integrates `state` over a part of a run with a fixed step. If all parts have a multiple of
    /// [`STEPS_OF_BLOCK`](afterbay_core::STEPS_OF_BLOCK) steps, w equals that of a single run: to
    /// the bit if the method keeps nothing from step to step, else to rounding.
    ///
    /// # Errors
    /// Those of [`Run::run`], and [`InputError::Length`] if the remainder has another length than
    /// the state.
    pub fn run_part<V: Vector<Scalar = T>>(
        &self,
        part: Part<'_, T>,
        state: &mut State<V>,
        show: Show<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        let dof = self.bound.dof();
        self.check(state)?;
        if part.remainder.len() != dof {
            let (quantity, found) = (Quantity::Reservoir, part.remainder.len());
            return Err(InputError::Length { quantity, expected: dof, found }.into());
        }
        let (mut last, h) = (part.grid.steps, part.grid.h.to_f64());
        let outcome = self.bound.run(part, Place::of(state), &mut |step, state| {
            let seen = show(step, state);
            if seen.is_break() {
                last = step;
            }
            seen
        });
        let effort = outcome.map_err(|error| self.named(error))?;
        let statistics = Statistics { accepted: last, effort, ..Statistics::default() };
        Ok(Statistics { least: h, largest: h, ..statistics })
    }

    /// Shows the states at the given times, for methods that choose their steps. Before each step
    /// `stops` is asked whether the run ends there. See
    /// [`sample_within`](afterbay_core::sample_within).
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method takes a fixed step, and the errors of
    /// [`sample_within`](afterbay_core::sample_within).
    pub fn sample<V: Vector<Scalar = T>>(
        &self,
        tolerance: &Tolerance,
        times: &[T],
        state: &mut State<V>,
        show: Show<'_, T>,
        stops: &mut dyn FnMut() -> bool,
    ) -> Result<Statistics, IntegrateError> {
        self.check(state)?;
        self.bound
            .sample(tolerance, times, Place::of(state), Sampling { show, stops })
            .map_err(|error| self.named(error))
    }

    /// Takes one step with a fixed-step method. The time of `state` does not change.
    ///
    /// Each call copies the workspace and has no data of the step before, such as the K to which
    /// `relaxed-*` and `splitting-*` return. For more than a few steps take [`Run::run`];
    /// [`Run::stepper`] allocates less.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method chooses its steps, [`InputError::Step`] if h is
    /// not finite, the errors of [`State::check_with`], and those of
    /// [`Method::step`](afterbay_core::Method::step) reported as step 1 of a run. The state is
    /// unchanged after an error.
    pub fn step<V: Vector<Scalar = T>>(
        &self,
        h: T,
        state: &mut State<V>,
    ) -> Result<Effort, IntegrateError> {
        self.check(state)?;
        if !h.is_finite().all() {
            return Err(InputError::Step { h: h.to_f64() }.into());
        }
        self.bound.step(h, Place::of(state)).map_err(|error| self.named(error))
    }

    /// A function that takes single steps, for [`integrate_with_events`]. With a method that
    /// chooses its steps, such a step is a part of a run within the tolerance over the time `span`.
    /// It continues this run if it begins where the last step ended. Other methods ignore the
    /// tolerance and the span.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method chooses its steps and there is no tolerance.
    ///
    /// [`integrate_with_events`]: afterbay_core::integrate_with_events
    pub fn stepper(
        &self,
        tolerance: Option<Tolerance>,
        span: T,
    ) -> Result<Stepping<'_, T>, InputError> {
        let bound = self.bound.stepper(tolerance, span);
        let mut step = bound.map_err(|error| named(self.method, error))?;
        Ok(Box::new(move |h, state, watch| {
            self.check(state)?;
            let t = state.t;
            let outcome = step(h, Place::of(state), watch).map_err(|error| self.named(error));
            state.t = t;
            outcome
        }))
    }

    fn check<V: Vector<Scalar = T>>(&self, state: &State<V>) -> Result<(), InputError> {
        state.check_with(self.bound.dof(), || self.bound.motors())
    }

    /// Names the method in an error as its row does.
    fn named(&self, error: IntegrateError) -> IntegrateError {
        match error {
            IntegrateError::Input(error) => named(self.method, error).into(),
            error => error,
        }
    }
}

/// Binds a fixed-step method, with states stored in `V` while it steps.
pub(crate) fn fixed<V, S, M>(
    name: &'static str,
    method: M,
    system: Arc<S>,
) -> Result<Run<V::Scalar>, InputError>
where
    V: Vector + 'static,
    S: System<V::Scalar> + ?Sized + 'static,
    M: Method<V, S> + Send + Sync + 'static,
    M::Workspace: Clone + Send + Sync + 'static,
{
    let bound = Fixed::<V, M, S, _>::new(method, system).map_err(|error| named(name, error))?;
    Ok(Run { method: name, bound: Box::new(bound) })
}

/// Binds a method with step size control, with states stored in `V` while it steps.
pub(super) fn chosen<V, S, M>(
    name: &'static str,
    method: M,
    system: Arc<S>,
) -> Result<Run<V::Scalar>, InputError>
where
    V: Vector + 'static,
    S: System<V::Scalar> + ?Sized + 'static,
    M: Adaptive<V, S> + Send + Sync + 'static,
{
    Ok(Run { method: name, bound: Box::new(Chosen::<V, M, S>::new(method, system)?) })
}
