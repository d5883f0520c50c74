//! A method bound to a system, for whoever knows neither: studies are written once for every method, system and N.

use afterbay_core::{
    Effort, Every, Grid, InputError, IntegrateError, Method, Quantity, RunError, Scalar, State, StateRef,
    StepFailure, System, Vector, integrate_in,
};
use std::marker::PhantomData;
use std::ops::ControlFlow;
use std::sync::Mutex;

/// What is shown of a run: the number of steps done and the state. `Break` ends the run.
pub type Show<'a, T> = &'a mut dyn FnMut(u64, StateRef<'_, T>) -> ControlFlow<()>;

/// A method bound to a system, their types and the storage of its steps forgotten.
pub struct Run<T: Scalar>(Box<dyn Erased<T>>);

impl<T: Scalar> Run<T> {
    /// [`integrate`](afterbay_core::integrate), with every `stride`-th state shown.
    ///
    /// # Errors
    /// Those of [`integrate`](afterbay_core::integrate).
    pub fn run<V: Vector<Scalar = T>>(
        &self,
        grid: Grid<T>,
        state: &mut State<V>,
        stride: u64,
        show: Show<'_, T>,
    ) -> Result<Effort, IntegrateError> {
        state.check(self.0.dof())?;
        self.0.run(grid, Place::of(state), stride, show)
    }

    /// One step; time stays where it is.
    ///
    /// # Errors
    /// Those of [`State::check`] and of [`Method::step`], the latter as those of a run of one step; the state is then as it was.
    pub fn step<V: Vector<Scalar = T>>(&self, h: T, state: &mut State<V>) -> Result<Effort, IntegrateError> {
        state.check(self.0.dof())?;
        let t = state.t.to_f64();
        Ok(self.0.step(h, Place::of(state)).map_err(|failure| RunError { step: 1, t, failure })?)
    }
}

/// Where a state is taken from and put back to.
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

    pub(super) fn take<V: Vector<Scalar = T>>(&self) -> State<V> {
        let copy = |part: &[T]| V::filled(part, |x| x);
        State { q: copy(self.q), p: copy(self.p), w: copy(self.w), t: *self.t }
    }

    pub(super) fn put<V: Vector<Scalar = T>>(self, state: &State<V>) {
        let StateRef { q, p, w, t } = state.state_ref();
        for (to, from) in [(self.q, q), (self.p, p), (self.w, w)] {
            to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
        }
        *self.t = t;
    }
}

trait Erased<T: Scalar>: Send + Sync {
    fn dof(&self) -> usize;
    fn run(
        &self,
        grid: Grid<T>,
        place: Place<'_, T>,
        stride: u64,
        show: Show<'_, T>,
    ) -> Result<Effort, IntegrateError>;
    fn step(&self, h: T, place: Place<'_, T>) -> Result<Effort, StepFailure>;
}

/// A method and its system, with states stored in `V` while it steps.
struct Bound<V, M, S, W> {
    method: M,
    system: S,
    /// Never stepped with.
    workspace: W,
    /// The one of the last run, where a method without a memory leaves it as good as new.
    spare: Mutex<Option<W>>,
    storage: PhantomData<fn() -> V>,
}

impl<V, S, M> Bound<V, M, S, M::Workspace>
where
    V: Vector,
    S: System<V::Scalar>,
    M: Method<V, S>,
    M::Workspace: Clone,
{
    /// Does something in a workspace as good as new. Runs side by side do not wait for each other: one of them has the spare.
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

impl<V, S, M> Erased<V::Scalar> for Bound<V, M, S, M::Workspace>
where
    V: Vector,
    S: System<V::Scalar>,
    M: Method<V, S> + Send + Sync,
    M::Workspace: Clone + Send + Sync,
{
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn run(
        &self,
        grid: Grid<V::Scalar>,
        place: Place<'_, V::Scalar>,
        stride: u64,
        show: Show<'_, V::Scalar>,
    ) -> Result<Effort, IntegrateError> {
        let mut state = place.take::<V>();
        let look = |step: u64, state: &State<V>| show(step, state.state_ref());
        let mut observer = Every::new(stride, look);
        let outcome = self.within(|workspace| {
            integrate_in(&self.method, &self.system, grid, &mut state, workspace, &mut observer)
        });
        place.put(&state);
        outcome
    }

    fn step(&self, h: V::Scalar, place: Place<'_, V::Scalar>) -> Result<Effort, StepFailure> {
        let mut state = place.take::<V>();
        let outcome = self.within(|workspace| self.method.step(&self.system, h, &mut state, workspace));
        place.put(&state);
        outcome
    }
}

/// Binds a method to a system, its states stored in `V` while it steps.
pub(super) fn bind<V, S, M>(method: M, system: S) -> Result<Run<V::Scalar>, InputError>
where
    V: Vector + 'static,
    S: System<V::Scalar> + 'static,
    M: Method<V, S> + Send + Sync + 'static,
    M::Workspace: Clone + Send + Sync + 'static,
{
    let dof = system.dof();
    if let Some(found) = V::LEN.filter(|&len| len != dof) {
        return Err(InputError::Length { quantity: Quantity::Coordinate, expected: dof, found });
    }
    let workspace = method.workspace(&system)?;
    Ok(Run(Box::new(Bound {
        method,
        system,
        workspace,
        spare: Mutex::new(None),
        storage: PhantomData::<fn() -> V>,
    })))
}
