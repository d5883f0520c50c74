//! The time loop with a fixed step.

use super::breaks::step_in_parts;
use super::grid::Grid;
use super::method::{Effort, Method};
use super::observer::Observer;
use super::reservoir::{Reservoir, STEPS_OF_BLOCK};
use super::undefined::or_undefined;
use crate::error::{InputError, IntegrateError, RunError, StepFailure};
use crate::numbers::{Scalar, Vector};
use crate::quantity::Quantity;
use crate::system::{State, System};
use std::ops::ControlFlow;

/// Integrates over the grid from `state` and passes the states that `observer` asks for. The times
/// are `t + n h`, with t the time of the initial state.
///
/// # Errors
/// [`IntegrateError::Input`] if [`System::check`] refuses the system, the state does not fit it or
/// the method does not apply; nothing was computed then. [`IntegrateError::Run`] if a step fails;
/// `state` is then that of the last successful step, or, if w overflows, one of up to
/// [`STEPS_OF_BLOCK`] steps before.
pub fn integrate<V, S, M, O>(
    method: &M,
    system: &S,
    grid: Grid<V::Scalar>,
    state: &mut State<V>,
    observer: &mut O,
) -> Result<Effort, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    system.check()?;
    state.check_with(system.dof(), || system.motors())?;
    let (mut workspace, mut remainder) = (method.workspace(system)?, V::zeros(system.dof()));
    integrate_in(method, system, grid, state, &mut remainder, &mut workspace, observer)
}

/// [`integrate`] in a given workspace for the method and the system. It must be new, unless the
/// method is memoryless ([`Method::is_memoryless`]).
///
/// `remainder` is the part of w that is below its rounding. It is 0 at the start. At the end it is
/// the value that a further run needs to continue this one. A run in parts of a multiple of
/// [`STEPS_OF_BLOCK`] steps gives the same w as a run in one.
///
/// # Errors
/// Those of [`integrate`].
#[inline(always)]
pub fn integrate_in<V, S, M, O>(
    method: &M,
    system: &S,
    grid: Grid<V::Scalar>,
    state: &mut State<V>,
    remainder: &mut V,
    workspace: &mut M::Workspace,
    observer: &mut O,
) -> Result<Effort, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    system.check()?;
    state.check_with(system.dof(), || system.motors())?;
    if remainder.as_slice().len() != system.dof() {
        let (expected, found) = (system.dof(), remainder.as_slice().len());
        let quantity = Quantity::Reservoir;
        return Err(InputError::Length { quantity, expected, found }.into());
    }
    grid.check_from(state.t)?;
    if observer.observe(0, state).is_break() {
        return Ok(Effort::default());
    }
    let in_parts = !system.dissipation_form().zero && !method.sums_reservoir();
    let mut reservoir = Reservoir::begin(state, remainder, in_parts);
    let examined = system.may_be_singular() && !method.refuses_singularities();
    let outcome = if examined || system.has_breaks() {
        examined_blocks(method, system, grid, state, &mut reservoir, workspace, observer)
    } else {
        blocks(method, system, grid, state, &mut reservoir, workspace, observer)
    };
    reservoir.end(state, remainder);
    outcome
}

/// The time loop. The state holds the part of w that `reservoir` does not.
#[inline(always)]
fn blocks<V, S, M, O>(
    method: &M,
    system: &S,
    grid: Grid<V::Scalar>,
    state: &mut State<V>,
    reservoir: &mut Reservoir<V>,
    workspace: &mut M::Workspace,
    observer: &mut O,
) -> Result<Effort, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    let (mut effort, mut done) = (Effort::default(), 0);
    let start = state.t;
    let time = |n: u64| grid.time(start, n);
    let failed = |step, good, failure| RunError { step, t: time(good).to_f64(), failure };
    let mut before = state.clone();
    // The work of a step, once steps leave the state unchanged.
    let mut idle = None;
    while done < grid.steps {
        let end_of_block = grid.steps.min(done + STEPS_OF_BLOCK);
        // A local copy whose address is not shared lets small states stay in registers.
        let mut current = std::mem::replace(state, State::vacant());
        let mut outcome = Ok(ControlFlow::Continue(()));
        while done < end_of_block && matches!(outcome, Ok(ControlFlow::Continue(()))) {
            let count = observer.next(done).min(end_of_block).saturating_sub(done).max(1);
            let taken = match idle {
                // All further steps leave the state unchanged, too.
                Some(each) => Ok(Effort::times(each, count)),
                None => method.steps(system, grid.h, count, &mut current, workspace),
            };
            match taken {
                Ok(spent) => {
                    effort += spent;
                    done += count;
                    current.t = time(done);
                    let seen = reservoir.show(&mut current, |state| observer.observe(done, state));
                    outcome = seen.map_err(|failure| failed(done, done - 1, failure));
                }
                Err((good, failure)) => {
                    done += good;
                    current.t = time(done);
                    // A copy, for the reason given at `current`.
                    let failure = or_undefined(system, &current.clone(), done == 0, failure);
                    outcome = Err(failed(done + 1, done, failure));
                }
            }
        }
        *state = current;
        // A step from numbers that are nearly 0 may fail where one from 0 does not.
        if outcome.is_err() && state.set_tiny_to_zero() {
            outcome = Ok(ControlFlow::Continue(()));
        }
        if let Err(failure) = reservoir.end_block(state) {
            state.copy(&before);
            return Err(failed(done, done.saturating_sub(1), failure).into());
        }
        let seen = outcome?;
        state.set_tiny_to_zero();
        if seen.is_break() {
            break;
        }
        if idle.is_none()
            && done < grid.steps
            && method.is_memoryless()
            && state.stands_where(&before)
        {
            idle = effort_at_rest(method, system, grid.h, state);
        }
        before.copy(state);
    }
    Ok(effort)
}

/// The time loop for a system that may be singular or has breaks: it refuses the first step that
/// crosses a singularity of H, and divides steps at the breaks.
///
/// It is marked as cold and not as never to be inlined. The latter would compile it for every
/// system, while the call now disappears where the system has no singularities.
#[cold]
fn examined_blocks<V, S, M, O>(
    method: &M,
    system: &S,
    grid: Grid<V::Scalar>,
    state: &mut State<V>,
    reservoir: &mut Reservoir<V>,
    workspace: &mut M::Workspace,
    observer: &mut O,
) -> Result<Effort, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    let (mut effort, mut before) = (Effort::default(), state.clone());
    let start = state.t;
    for step in 1..=grid.steps {
        before.copy(state);
        let mut taken = step_in_parts(method, system, grid.h, state, workspace);
        if taken.is_err() && state.set_tiny_to_zero() {
            before.copy(state);
            taken = step_in_parts(method, system, grid.h, state, workspace);
        }
        let taken = taken.map_err(|failure| or_undefined(system, &before, step == 1, failure));
        let examined = taken.and_then(|spent| {
            check_between(system, before.q.as_slice(), state.q.as_slice()).map(|()| spent)
        });
        state.t = grid.time(start, step);
        let seen = examined.and_then(|spent| {
            effort += spent;
            reservoir.show(state, |state| observer.observe(step, state))
        });
        let failed = |failure| RunError { step, t: before.t.to_f64(), failure };
        let last = !matches!(seen, Ok(ControlFlow::Continue(()))) || step == grid.steps;
        if seen.is_err() {
            state.copy(&before);
        }
        if last || step % STEPS_OF_BLOCK == 0 {
            // This sum was shown before, and did not overflow.
            reservoir.end_block(state).map_err(failed)?;
        }
        let seen = seen.map_err(failed)?;
        if seen.is_break() {
            break;
        }
        if step % STEPS_OF_BLOCK == 0 {
            state.set_tiny_to_zero();
        }
    }
    Ok(effort)
}

/// Refuses a step between whose ends H is singular.
///
/// # Errors
/// [`StepFailure::AcrossSingularity`], with a coordinate whose move meets the singularity.
pub(crate) fn check_between<T, S>(system: &S, from: &[T], to: &[T]) -> Result<(), StepFailure>
where
    T: Scalar,
    S: System<T> + ?Sized,
{
    if !system.is_singular_between(from, to) {
        return Ok(());
    }
    // A move of the coordinates below `low` does not meet the singularity; of those below `high` it
    // does.
    let (mut low, mut high) = (0, to.len());
    while high - low > 1 {
        let middle = low.midpoint(high);
        let end = [&to[..middle], &from[middle..]].concat();
        if system.is_singular_between(from, &end) { high = middle } else { low = middle }
    }
    let dof = low;
    let [from, to] = [from, to].map(|q| q.get(dof).map_or(0.0, |q| q.to_f64()));
    Err(StepFailure::AcrossSingularity { dof, from, to })
}

/// The work of a step that leaves the state unchanged; none if the step changes it. It uses its own
/// workspace, so that the one of the loop can stay in registers.
#[cold]
#[inline(never)]
fn effort_at_rest<V, S, M>(method: &M, system: &S, h: V::Scalar, state: &State<V>) -> Option<Effort>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Method<V, S> + ?Sized,
{
    let (mut next, mut workspace) = (state.clone(), method.workspace(system).ok()?);
    let spent = method.steps(system, h, 1, &mut next, &mut workspace).ok()?;
    next.stands_where(state).then_some(spent)
}
