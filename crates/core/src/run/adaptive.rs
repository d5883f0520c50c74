//! The time loop with error control: steps as long as a tolerance allows.

use super::adaptive_run::{AdaptiveRun, Statistics, backwards, is_uncontrolled};
use super::controller::StepControl;
use super::method::{Adaptive, Effort};
use super::observer::Observer;
use super::tolerance::Tolerance;
use crate::error::IntegrateError;
use crate::numbers::{Mask, Scalar, Vector};
use crate::system::{State, System};

/// Integrates from `state` to the time `end` and passes every accepted step to `observer`.
///
/// # Errors
/// [`IntegrateError::Input`] if [`System::check`] refuses the system, the state does not fit it,
/// the method does not apply, or the tolerance or the end is invalid; nothing was computed then.
/// [`IntegrateError::Run`] if steps fail at every length, or shrink to roundings of t; `state` is
/// then that of the last successful step.
pub fn integrate_within<V, S, M, O>(
    method: &M,
    system: &S,
    tolerance: &Tolerance,
    end: V::Scalar,
    state: &mut State<V>,
    observer: &mut O,
) -> Result<Statistics, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    integrate_controlled(method, system, tolerance, StepControl::default(), end, state, observer)
}

/// [`integrate_within`] with other options of the step size control.
///
/// # Errors
/// Those of [`integrate_within`], and [`InputError::Parameter`](crate::InputError::Parameter) if
/// an option is out of range.
pub fn integrate_controlled<V, S, M, O>(
    method: &M,
    system: &S,
    tolerance: &Tolerance,
    control: StepControl,
    end: V::Scalar,
    state: &mut State<V>,
    observer: &mut O,
) -> Result<Statistics, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    let mut run = AdaptiveRun::new(method, system, tolerance, control, end, state)?;
    if observer.observe(0, state).is_continue() {
        run.advance(end, state, observer)?;
    }
    Ok(run.statistics)
}

/// Integrates from `state` to the last of `times`, which ascend from the time of the state, and
/// passes the states at these times to `observer`, each with its index in `times` in place of the
/// number of steps. They are as accurate as the ends of steps, and keep K as these do. If the
/// observer breaks, `state` is at the end of the step that contains the last time shown.
///
/// # Errors
/// Those of [`integrate_within`], and [`InputError::Backwards`](crate::InputError::Backwards) if
/// the times do not ascend.
pub fn sample_within<V, S, M, O>(
    method: &M,
    system: &S,
    tolerance: &Tolerance,
    times: &[V::Scalar],
    state: &mut State<V>,
    observer: &mut O,
) -> Result<Statistics, IntegrateError>
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
    M: Adaptive<V, S> + ?Sized,
    O: Observer<V> + ?Sized,
{
    let Some(&end) = times.last() else { return Ok(Statistics::default()) };
    if let Some(pair) = times.windows(2).find(|pair| !pair[0].le(pair[1]).all()) {
        return Err(backwards(pair[0], pair[1]).into());
    }
    if !state.t.le(times[0]).all() {
        return Err(backwards(state.t, times[0]).into());
    }
    let control = StepControl::default();
    let mut run = AdaptiveRun::new(method, system, tolerance, control, end, state)?;
    let (mut before, mut shown) = (state.clone(), state.clone());
    for (n, &time) in (0..).zip(times) {
        while state.t.lt(time).all() {
            if observer.stops() {
                return Ok(run.statistics);
            }
            before.copy(state);
            run.step(end, state)?;
        }
        let seen = if state.t == time {
            observer.observe(n, state)
        } else {
            let h = time - before.t;
            run.statistics.effort +=
                match method.between(system, h, &before, &mut run.workspace, &mut shown) {
                    Ok(effort) => effort,
                    // Within so short a step across a break, the end of the step is as accurate.
                    Err(_) if is_uncontrolled(state.t - before.t, state.t.to_f64().abs()) => {
                        shown.copy(state);
                        Effort::default()
                    }
                    // A state that cannot be computed within one step is reached by separate steps.
                    Err(_) => run.apart(&before, time, &mut shown)?,
                };
            shown.t = time;
            observer.observe(n, &shown)
        };
        if seen.is_break() {
            break;
        }
    }
    Ok(run.statistics)
}
