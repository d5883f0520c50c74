//! The first of a method's own steps, within a step of the grid, that may contain an event.

use super::side::Side;
use super::{Event, TakeStep, Watch, leave};
use crate::error::{InputError, IntegrateError, RunError};
use crate::run::method::Effort;
use crate::system::{State, StateRef};
use std::ops::ControlFlow;

/// A step of the grid, or the part of it that is left after an event.
#[derive(Clone, Copy)]
pub(super) struct Rest {
    /// The number of the step, from 1.
    pub(super) step: u64,
    /// Its length, and the time at which it ends.
    pub(super) h: f64,
    pub(super) end: f64,
}

/// A step that may contain an event, from the state that [`own_step`] leaves.
pub(super) struct OwnStep {
    pub(super) h: f64,
    pub(super) end: State<Vec<f64>>,
    pub(super) effort: Effort,
}

/// Goes on to the end of the first own step of the method that may contain an event, at most to the
/// end of `rest`. It moves `state` and `sides` to the start of that own step.
pub(super) fn own_step(
    take: TakeStep<'_>,
    rest: Rest,
    events: &[Event<'_>],
    sides: &mut [Side],
    state: &mut State<Vec<f64>>,
) -> Result<OwnStep, IntegrateError> {
    let (mut clear, mut stop) = (None, None);
    let mut watch = |there: StateRef<'_, f64>| {
        let before = clear.as_ref().unwrap_or(state).state_ref();
        let mut watched = events.iter().zip(&*sides);
        if watched.any(|(event, side)| {
            side.may_reach_zero(event.direction, [before, there].map(event.function))
        }) {
            stop = Some(there.t);
            return ControlFlow::Break(());
        }
        leave(sides, events, there);
        let StateRef { q, p, w, t } = there;
        clear = Some(State { q: q.to_vec(), p: p.to_vec(), w: w.to_vec(), t });
        ControlFlow::Continue(())
    };
    let (mut end, effort) = stepped(take, rest.h, rest.step, state, &mut watch)?;
    end.t = stop.unwrap_or(rest.end);
    // A method of fixed step takes one step of exactly this length.
    let is_whole = clear.is_none() && stop.is_none();
    *state = clear.unwrap_or_else(|| state.clone());
    let h = if is_whole { rest.h } else { end.t - state.t };
    Ok(OwnStep { h, end, effort })
}

/// The state after a step of length h from `from`, and the work of the step. A failure is that of
/// the step `number`.
pub(super) fn stepped(
    take: TakeStep<'_>,
    h: f64,
    number: u64,
    from: &State<Vec<f64>>,
    watch: Watch<'_>,
) -> Result<(State<Vec<f64>>, Effort), IntegrateError> {
    let mut there = from.clone();
    let effort = match take(h, &mut there, watch) {
        Ok(effort) => effort,
        // Over a step below the rounding of the time the state does not change.
        Err(IntegrateError::Input(InputError::TimeStalled { .. })) => Effort::default(),
        Err(IntegrateError::Run(error)) => {
            return Err(RunError { step: number, t: from.t, ..error }.into());
        }
        Err(error) => return Err(error),
    };
    there.t = from.t + h;
    Ok((there, effort))
}
