//! A method and its system behind one trait, for runs of every kind of method.

use afterbay_core::{
    Adaptive, AdaptiveRun, Effort, Every, Grid, InputError, IntegrateError, Mask, Method, Observer,
    Quantity, RunError, Scalar, State, StateRef, Statistics, StepControl, System, Tolerance,
    Vector, Watch, integrate_in, integrate_within, sample_within, step_in_parts,
};
use std::marker::PhantomData;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

/// A run with a fixed step, or a part of one that continues another part.
pub struct Part<'a, T> {
    /// The steps.
    pub grid: Grid<T>,
    /// The step of the first state that is shown, counted from the start of this part.
    pub first: u64,
    /// Every `stride`-th state from there on is shown.
    pub stride: u64,
    /// The part of w_j below its rounding, one entry a degree of freedom: 0 at the start of a run.
    /// It receives the value that the next part needs.
    pub remainder: &'a mut [T],
}

/// The callback of a run: receives the number of steps taken and the state. `Break` ends the run.
pub type Show<'a, T> = &'a mut dyn FnMut(u64, StateRef<'_, T>) -> ControlFlow<()>;

/// [`super::Stepping`] with the storage of states erased.
pub(super) type ErasedStepping<'a, T> =
    Box<dyn FnMut(T, Place<'_, T>, Watch<'_, T>) -> Result<Effort, IntegrateError> + 'a>;

/// The slices of a state, which are read before a run and written after it.
pub(super) struct Place<'a, T> {
    q: &'a mut [T],
    p: &'a mut [T],
    w: &'a mut [T],
    t: &'a mut T,
}

impl<'a, T: Scalar> Place<'a, T> {
    pub(super) fn of<V: Vector<Scalar = T>>(state: &'a mut State<V>) -> Self {
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

/// A placeholder for the name of the method in errors. [`named`] replaces it.
const UNNAMED: &str = "";

/// Names the method in an error as its row does. A method itself knows its family only.
pub(super) fn named(method: &'static str, error: InputError) -> InputError {
    match error {
        InputError::Unsupported { why, .. } => InputError::Unsupported { method, why },
        error => error,
    }
}

fn takes_a_tolerance() -> InputError {
    InputError::Unsupported { method: UNNAMED, why: "it takes a tolerance, not a step" }
}

fn takes_a_step() -> InputError {
    InputError::Unsupported { method: UNNAMED, why: "it takes a step, not a tolerance" }
}

/// The observer of a run at given times: `show` receives the states, and `stops` may end the run
/// between them.
pub(super) struct Sampling<'a, T> {
    pub(super) show: Show<'a, T>,
    pub(super) stops: &'a mut dyn FnMut() -> bool,
}

impl<V: Vector> Observer<V> for Sampling<'_, V::Scalar> {
    fn observe(&mut self, n: u64, state: &State<V>) -> ControlFlow<()> {
        (self.show)(n, state.state_ref())
    }

    fn stops(&mut self) -> bool {
        (self.stops)()
    }
}

/// A bound method. Fixed-step methods refuse tolerances and the reverse.
pub(super) trait Erased<T: Scalar>: Send + Sync {
    fn dof(&self) -> usize;

    /// [`System::motors`]
    fn motors(&self) -> usize;

    fn run(
        &self,
        _part: Part<'_, T>,
        _place: Place<'_, T>,
        _show: Show<'_, T>,
    ) -> Result<Effort, IntegrateError> {
        Err(takes_a_tolerance().into())
    }

    fn stepper(
        &self,
        tolerance: Option<Tolerance>,
        span: T,
    ) -> Result<ErasedStepping<'_, T>, InputError>;

    fn step(&self, _h: T, _place: Place<'_, T>) -> Result<Effort, IntegrateError> {
        Err(takes_a_tolerance().into())
    }

    fn run_within(
        &self,
        _tolerance: &Tolerance,
        _end: T,
        _place: Place<'_, T>,
        _stride: u64,
        _show: Show<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        Err(takes_a_step().into())
    }

    fn sample(
        &self,
        _tolerance: &Tolerance,
        _times: &[T],
        _place: Place<'_, T>,
        _sampling: Sampling<'_, T>,
    ) -> Result<Statistics, IntegrateError> {
        Err(takes_a_step().into())
    }
}

/// A fixed-step method and its system, with states stored in `V` while it steps.
pub(super) struct Fixed<V, M, S: ?Sized, W> {
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
    /// The method and its system, if `V` has room for its degrees of freedom.
    pub(super) fn new(method: M, system: Arc<S>) -> Result<Self, InputError> {
        fits::<V>(system.dof())?;
        let workspace = method.workspace(&system)?;
        Ok(Self { method, system, workspace, spare: Mutex::new(None), storage: PhantomData })
    }

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

    /// Runs in a given workspace. It is compiled once for runs and for single steps.
    #[inline(never)]
    fn run_in(
        &self,
        workspace: &mut M::Workspace,
        Part { grid, first, stride, remainder }: Part<'_, V::Scalar>,
        place: Place<'_, V::Scalar>,
        show: Show<'_, V::Scalar>,
    ) -> Result<Effort, IntegrateError> {
        let (mut state, mut left) = (place.take::<V>(), V::filled(remainder, |x| x));
        let look = |step: u64, state: &State<V>| show(step, state.state_ref());
        let mut observer = Every::starting(first, stride, look);
        let outcome = integrate_in(
            &self.method,
            &*self.system,
            grid,
            &mut state,
            &mut left,
            workspace,
            &mut observer,
        );
        place.put(&state);
        remainder.copy_from_slice(left.as_slice());
        outcome
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

    fn motors(&self) -> usize {
        self.system.motors()
    }

    fn run(
        &self,
        part: Part<'_, V::Scalar>,
        place: Place<'_, V::Scalar>,
        show: Show<'_, V::Scalar>,
    ) -> Result<Effort, IntegrateError> {
        self.within(|workspace| self.run_in(workspace, part, place, show))
    }

    fn stepper(
        &self,
        _tolerance: Option<Tolerance>,
        _span: V::Scalar,
    ) -> Result<ErasedStepping<'_, V::Scalar>, InputError> {
        let (mut workspace, zero) = (self.workspace.clone(), V::Scalar::zero());
        let mut remainder = vec![zero; self.system.dof()];
        Ok(Box::new(move |h, place, _| {
            remainder.fill(zero);
            let grid = Grid { h, steps: 1 };
            let part = Part { grid, first: 0, stride: u64::MAX, remainder: &mut remainder };
            self.run_in(&mut workspace, part, place, &mut |_, _| ControlFlow::Continue(()))
        }))
    }

    fn step(&self, h: V::Scalar, place: Place<'_, V::Scalar>) -> Result<Effort, IntegrateError> {
        let mut state = place.take::<V>();
        let (method, system) = (&self.method, &*self.system);
        let outcome = self.within(|kept| step_in_parts(method, system, h, &mut state, kept));
        let t = state.t.to_f64();
        place.put(&state);
        Ok(outcome.map_err(|failure| RunError { step: 1, t, failure })?)
    }
}

/// A method with step size control and its system, with states stored in `V` while it steps.
pub(super) struct Chosen<V, M, S: ?Sized> {
    method: M,
    system: Arc<S>,
    storage: PhantomData<fn() -> V>,
}

impl<V, S, M> Chosen<V, M, S>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    /// The method and its system, if `V` has room for its degrees of freedom.
    pub(super) fn new(method: M, system: Arc<S>) -> Result<Self, InputError> {
        fits::<V>(system.dof())?;
        Ok(Self { method, system, storage: PhantomData })
    }
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

    fn motors(&self) -> usize {
        self.system.motors()
    }

    fn stepper(
        &self,
        tolerance: Option<Tolerance>,
        span: V::Scalar,
    ) -> Result<ErasedStepping<'_, V::Scalar>, InputError> {
        let tolerance = tolerance.ok_or_else(takes_a_tolerance)?;
        let (method, system) = (&self.method, &*self.system);
        // The run so far and the state at its end.
        let mut kept: Option<(AdaptiveRun<'_, V, S, M>, State<V>)> = None;
        Ok(Box::new(move |h, place, watch| {
            let mut state = place.take::<V>();
            let (mut run, mut last) = match kept.take() {
                Some((run, last)) if is_same_point(&last, &state) => (run, last),
                _ => {
                    let (control, end) = (StepControl::default(), state.t + span);
                    let run = AdaptiveRun::new(method, system, &tolerance, control, end, &state)?;
                    (run, state.clone())
                }
            };
            let (end, before) = (state.t + h, run.statistics().effort);
            let mut between = |_: u64, state: &State<V>| match state.t.lt(end).all() {
                true => watch(state.state_ref()),
                false => ControlFlow::Continue(()),
            };
            run.advance(end, &mut state, &mut between)?;
            let effort = run.statistics().effort - before;
            last.clone_from(&state);
            kept = Some((run, last));
            place.put(&state);
            Ok(effort)
        }))
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
        mut sampling: Sampling<'_, V::Scalar>,
    ) -> Result<Statistics, IntegrateError> {
        let mut state = place.take::<V>();
        let outcome =
            sample_within(&self.method, &*self.system, tolerance, times, &mut state, &mut sampling);
        place.put(&state);
        outcome
    }
}

/// Whether two states are the same, whatever their times are: the caller rounds these.
fn is_same_point<V: Vector>(a: &State<V>, b: &State<V>) -> bool {
    let (a, b) = (a.state_ref(), b.state_ref());
    (a.q, a.p, a.w) == (b.q, b.p, b.w)
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
