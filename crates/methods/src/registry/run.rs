//! A method bound to a system, with the types of both erased.

use afterbay_core::{
    Adaptive, Effort, Every, Grid, InputError, IntegrateError, Method, Quantity, RunError, Scalar,
    State, StateRef, Statistics, System, Tolerance, Vector, integrate_in, integrate_within,
    sample_within,
};
use std::marker::PhantomData;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

/// The step control of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting<T> {
    /// A fixed step, for methods that take a step.
    Step(Grid<T>),
    /// A tolerance and the end time, for methods that choose their steps.
    Tolerance(Tolerance, T),
}

impl<T> From<Grid<T>> for Setting<T> {
    fn from(grid: Grid<T>) -> Self {
        Self::Step(grid)
    }
}

/// A run with a fixed step, or a part of one that continues another part.
pub struct Part<'a, T> {
    /// The steps.
    pub grid: Grid<T>,
    /// The step of the first state that is shown, counted from the start of this part.
    pub first: u64,
    /// Every so many states from there on are shown.
    pub stride: u64,
    /// The part of w_j below its rounding, one entry a degree of freedom: 0 at the start of a run.
    /// It receives what the next part needs.
    pub remainder: &'a mut [T],
}

/// The callback of a run: receives the number of steps taken and the state. `Break` ends the run.
pub type Show<'a, T> = &'a mut dyn FnMut(u64, StateRef<'_, T>) -> ControlFlow<()>;

/// Takes a step of the given length. The time of the state does not change, and the state is unchanged
/// after an error.
pub type Stepping<'a, T> =
    Box<dyn FnMut(T, &mut State<Vec<T>>) -> Result<Effort, IntegrateError> + 'a>;

/// [`Stepping`] with the storage of states erased.
type ErasedStepping<'a, T> = Box<dyn FnMut(T, Place<'_, T>) -> Result<Effort, IntegrateError> + 'a>;

/// A method bound to a system. The types of both, and the storage of states, are erased.
pub struct Run<T: Scalar> {
    method: &'static str,
    bound: Box<dyn Erased<T>>,
}

impl<T: Scalar> Run<T> {
    /// Integrates `state` under the given setting and shows every `stride`-th state. See
    /// [`integrate`](afterbay_core::integrate) and [`integrate_within`].
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the setting does not match the kind of the method, and the
    /// errors of [`integrate`](afterbay_core::integrate) and [`integrate_within`].
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
                state.check(self.bound.dof())?;
                let place = Place::of(state);
                let found = self.bound.run_within(&tolerance, end, place, stride, show);
                found.map_err(|error| self.named(error))
            }
        }
    }

    /// Integrates `state` over a part of a run with a fixed step. Of parts of a multiple of
    /// [`STEPS_OF_BLOCK`](afterbay_core::STEPS_OF_BLOCK) steps, w is that of one run.
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
        state.check(dof)?;
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

    /// Shows the states at the given times, for methods that choose their steps. See
    /// [`sample_within`].
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method takes a fixed step, and the errors of
    /// [`sample_within`].
    pub fn sample<V: Vector<Scalar = T>>(
        &self,
        tolerance: &Tolerance,
        times: &[T],
        state: &mut State<V>,
        show: Show<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        state.check(self.bound.dof())?;
        self.bound
            .sample(tolerance, times, Place::of(state), show)
            .map_err(|error| self.named(error))
    }

    /// Takes one step with a fixed-step method. The time of `state` does not change.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method chooses its steps, the errors of [`State::check`],
    /// and those of [`Method::step`] reported as step 1 of a run. The state is unchanged after an
    /// error.
    pub fn step<V: Vector<Scalar = T>>(
        &self,
        h: T,
        state: &mut State<V>,
    ) -> Result<Effort, IntegrateError> {
        state.check(self.bound.dof())?;
        self.bound.step(h, Place::of(state)).map_err(|error| self.named(error))
    }

    /// A function that takes single steps, for [`integrate_with_events`]: with a method that chooses
    /// its steps, a step is a run within the tolerance.
    ///
    /// [`integrate_with_events`]: afterbay_core::integrate_with_events
    pub fn stepper(&self, tolerance: Tolerance) -> Stepping<'_, T> {
        let mut step = self.bound.stepper(tolerance);
        Box::new(move |h, state| {
            state.check(self.bound.dof())?;
            let t = state.t;
            let outcome = step(h, Place::of(state)).map_err(|error| self.named(error));
            state.t = t;
            outcome
        })
    }

    /// Inserts the name of the method into an error that has none.
    fn named(&self, error: IntegrateError) -> IntegrateError {
        match error {
            IntegrateError::Input(InputError::Unsupported { method: "", why }) => {
                InputError::Unsupported { method: self.method, why }.into()
            }
            error => error,
        }
    }
}

/// The slices of a state, which are read before a run and written after it.
struct Place<'a, T> {
    q: &'a mut [T],
    p: &'a mut [T],
    w: &'a mut [T],
    t: &'a mut T,
}

impl<'a, T: Scalar> Place<'a, T> {
    fn of<V: Vector<Scalar = T>>(state: &'a mut State<V>) -> Self {
        let State { q, p, w, t } = state;
        Self { q: q.as_mut_slice(), p: p.as_mut_slice(), w: w.as_mut_slice(), t }
    }

    fn take<V: Vector<Scalar = T>>(&self) -> State<V> {
        let copy = |part: &[T]| V::filled(part, |x| x);
        State { q: copy(self.q), p: copy(self.p), w: copy(self.w), t: *self.t }
    }

    fn put<V: Vector<Scalar = T>>(self, state: &State<V>) {
        let StateRef { q, p, w, t } = state.state_ref();
        for (to, from) in [(self.q, q), (self.p, p), (self.w, w)] {
            to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
        }
        *self.t = t;
    }
}

/// A bound method. Fixed-step methods refuse tolerances and the reverse.
trait Erased<T: Scalar>: Send + Sync {
    fn dof(&self) -> usize;

    fn run(
        &self,
        _part: Part<'_, T>,
        _place: Place<'_, T>,
        _show: Show<'_, T>,
    ) -> Result<Effort, IntegrateError> {
        Err(InputError::Unsupported { method: "", why: "it takes a tolerance, not a step" }.into())
    }

    fn stepper(&self, tolerance: Tolerance) -> ErasedStepping<'_, T>;

    fn step(&self, _h: T, _place: Place<'_, T>) -> Result<Effort, IntegrateError> {
        Err(InputError::Unsupported { method: "", why: "it takes a tolerance, not a step" }.into())
    }

    fn run_within(
        &self,
        _tolerance: &Tolerance,
        _end: T,
        _place: Place<'_, T>,
        _stride: u64,
        _show: Show<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        Err(InputError::Unsupported { method: "", why: "it takes a step, not a tolerance" }.into())
    }

    fn sample(
        &self,
        _tolerance: &Tolerance,
        _times: &[T],
        _place: Place<'_, T>,
        _show: Show<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        Err(InputError::Unsupported { method: "", why: "it takes a step, not a tolerance" }.into())
    }
}

/// A fixed-step method and its system, with states stored in `V` while it steps.
struct Fixed<V, M, S: ?Sized, W> {
    method: M,
    system: Arc<S>,
    /// A workspace that is cloned and never used for a step.
    workspace: W,
    /// The workspace of the last run, for methods whose workspace carries no memory between runs.
    spare: Mutex<Option<W>>,
    storage: PhantomData<fn() -> V>,
}

impl<V, S, M> Fixed<V, M, S, M::Workspace>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S>,
    M::Workspace: Clone,
{
    /// Runs `run` in a fresh workspace. Of concurrent runs, one takes the spare workspace and the
    /// others clone; none waits.
    #[inline(always)]
    fn within<R>(&self, run: impl FnOnce(&mut M::Workspace) -> R) -> R {
        let spare = || if self.method.is_memoryless() { self.spare.try_lock().ok() } else { None };
        let kept = spare().and_then(|mut spare| spare.take());
        let mut workspace = kept.unwrap_or_else(|| self.workspace.clone());
        let done = run(&mut workspace);
        if let Some(mut spare) = spare() {
            *spare = Some(workspace);
        }
        done
    }
}

impl<V, S, M> Erased<V::Scalar> for Fixed<V, M, S, M::Workspace>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + Send + Sync,
    M::Workspace: Clone + Send + Sync,
{
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn run(
        &self,
        Part { grid, first, stride, remainder }: Part<'_, V::Scalar>,
        place: Place<'_, V::Scalar>,
        show: Show<'_, V::Scalar>,
    ) -> Result<Effort, IntegrateError> {
        let (mut state, mut left) = (place.take::<V>(), V::filled(remainder, |x| x));
        let look = |step: u64, state: &State<V>| show(step, state.state_ref());
        let mut observer = Every::starting(first, stride, look);
        let outcome = self.within(|workspace| {
            let state = (&mut state, &mut left);
            integrate_in(&self.method, &*self.system, grid, state, workspace, &mut observer)
        });
        place.put(&state);
        remainder.copy_from_slice(left.as_slice());
        outcome
    }

    fn stepper(&self, _tolerance: Tolerance) -> ErasedStepping<'_, V::Scalar> {
        let mut workspace = self.workspace.clone();
        Box::new(move |h, place| {
            let (mut state, system) = (place.take::<V>(), &*self.system);
            let (grid, mut remainder) = (Grid { h, steps: 1 }, V::zeros(system.dof()));
            let states = (&mut state, &mut remainder);
            let effort = integrate_in(&self.method, system, grid, states, &mut workspace, &mut ())?;
            place.put(&state);
            Ok(effort)
        })
    }

    fn step(&self, h: V::Scalar, place: Place<'_, V::Scalar>) -> Result<Effort, IntegrateError> {
        let mut state = place.take::<V>();
        let outcome =
            self.within(|workspace| self.method.step(&*self.system, h, &mut state, workspace));
        let t = state.t.to_f64();
        place.put(&state);
        Ok(outcome.map_err(|failure| RunError { step: 1, t, failure })?)
    }
}

/// A method with step size control and its system, with states stored in `V` while it steps.
struct Chosen<V, M, S: ?Sized> {
    method: M,
    system: Arc<S>,
    storage: PhantomData<fn() -> V>,
}

impl<V, S, M> Erased<V::Scalar> for Chosen<V, M, S>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + Send + Sync,
{
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn stepper(&self, tolerance: Tolerance) -> ErasedStepping<'_, V::Scalar> {
        Box::new(move |h, place| {
            let (mut state, system) = (place.take::<V>(), &*self.system);
            let end = state.t + h;
            let found =
                integrate_within(&self.method, system, &tolerance, end, &mut state, &mut ())?;
            place.put(&state);
            Ok(found.effort)
        })
    }

    fn run_within(
        &self,
        tolerance: &Tolerance,
        end: V::Scalar,
        place: Place<'_, V::Scalar>,
        stride: u64,
        show: Show<'_, V::Scalar>,
    ) -> Result<Statistics, IntegrateError> {
        let mut state = place.take::<V>();
        let look = |step: u64, state: &State<V>| show(step, state.state_ref());
        let mut observer = Every::new(stride, look);
        let outcome = integrate_within(
            &self.method,
            &*self.system,
            tolerance,
            end,
            &mut state,
            &mut observer,
        );
        place.put(&state);
        outcome
    }

    fn sample(
        &self,
        tolerance: &Tolerance,
        times: &[V::Scalar],
        place: Place<'_, V::Scalar>,
        show: Show<'_, V::Scalar>,
    ) -> Result<Statistics, IntegrateError> {
        let mut state = place.take::<V>();
        let mut look = |n: u64, state: &State<V>| show(n, state.state_ref());
        let outcome =
            sample_within(&self.method, &*self.system, tolerance, times, &mut state, &mut look);
        place.put(&state);
        outcome
    }
}

/// Checks that the storage `V` has room for `dof` degrees of freedom.
fn fits<V: Vector>(dof: usize) -> Result<(), InputError> {
    match V::LEN.filter(|&len| len != dof) {
        Some(found) => {
            Err(InputError::Length { quantity: Quantity::Coordinate, expected: dof, found })
        }
        None => Ok(()),
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
    fits::<V>(system.dof())?;
    let workspace = method.workspace(&system)?;
    let bound = Fixed {
        method,
        system,
        workspace,
        spare: Mutex::new(None),
        storage: PhantomData::<fn() -> V>,
    };
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
    fits::<V>(system.dof())?;
    Ok(Run {
        method: name,
        bound: Box::new(Chosen { method, system, storage: PhantomData::<fn() -> V> }),
    })
}
