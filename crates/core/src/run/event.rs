//! Events: zeros of functions of the state along a run.

mod first;
mod own_step;
mod pole;
mod side;

use super::grid::Grid;
use super::method::Effort;
use crate::error::{InputError, IntegrateError, RunError, StepFailure};
use crate::system::{State, StateRef};
use first::{FirstEvent, Found, first_event};
use own_step::{OwnStep, Rest, own_step, stepped};
use side::{Due, Side};
use std::ops::ControlFlow;

/// The most events in one step of the grid. A ball that comes to rest by bouncing has infinitely
/// many.
const MOST_EVENTS: u64 = 1000;
/// The share of a step after which a motion that leaves a wall has left it. A choice.
const SHORT_SHARE: f64 = 1.0 / 1_048_576.0;
/// The largest value of a function at its zero, in roundings of its values at the ends of the step.
/// A choice.
const EVENT_ROUNDINGS: f64 = 64.0;

/// The state after a share of a step.
type Within<'a> = &'a mut dyn FnMut(f64) -> Result<State<Vec<f64>>, IntegrateError>;

/// The direction in which a function crosses zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// From below.
    #[default]
    Rising,
    /// From above.
    Falling,
    /// From either side.
    Both,
}

impl Direction {
    /// Whether a function with these values crosses zero. A value of 0 counts for the step that
    /// ends there, not for the next.
    pub fn crosses(self, before: f64, after: f64) -> bool {
        let rises = before < 0.0 && after >= 0.0;
        let falls = before > 0.0 && after <= 0.0;
        match self {
            Self::Rising => rises,
            Self::Falling => falls,
            Self::Both => rises || falls,
        }
    }
}

/// A function of the state whose zeros are looked for.
pub struct Event<'a> {
    /// The function, continuous where it crosses zero.
    pub function: &'a (dyn Fn(StateRef<'_, f64>) -> f64 + Sync),
    /// The direction in which it crosses zero.
    pub direction: Direction,
    /// Whether the function must not pass zero. A run that starts at zero and moves beyond it then
    /// begins with an event; otherwise the start is not an event.
    pub is_wall: bool,
}

impl Event<'_> {
    fn value(&self, state: &State<Vec<f64>>) -> f64 {
        (self.function)(state.state_ref())
    }
}

/// The state at an event, which may be changed.
pub struct EventState<'a> {
    /// Coordinates.
    pub q: &'a mut [f64],
    /// Momenta.
    pub p: &'a mut [f64],
    /// Reservoir.
    pub w: &'a mut [f64],
    /// Time.
    pub t: f64,
}

/// Receives the index of an event in the list and the state there. `Break` ends the run.
pub type OnEvent<'a> = &'a mut dyn FnMut(usize, EventState<'_>) -> ControlFlow<()>;

/// Receives a state between two of a method's own steps. `Break` ends the step there.
pub type Watch<'a, T = f64> = &'a mut dyn FnMut(StateRef<'_, T>) -> ControlFlow<()>;

/// Takes a step of the given length. A method that chooses its steps passes the states between its
/// own steps to the watch. The state is unchanged after an error, and its time is not set.
pub type TakeStep<'a> =
    &'a mut dyn FnMut(f64, &mut State<Vec<f64>>, Watch<'_>) -> Result<Effort, IntegrateError>;

/// [`integrate`](super::integrate) with events. An event within a step is the end of a shorter step
/// of the same method: it has the accuracy of the method, and K is kept if the method keeps it.
/// After an event the run goes on to the next time of the grid. Events at one time happen in the
/// order of the list. w is rounded at every step: it is not summed in blocks, as it is without
/// events.
///
/// Events are looked for in each step of the grid, and with a method that chooses its steps in each
/// of these. A function that crosses zero twice within one step shows no event there, unless it is
/// beyond zero at an event of another function. A pole is no event. Nor is a jump over zero, such
/// as that of sign x or of an angle reduced to [-π, π), unless the function is a wall: pass a
/// function that is continuous at its zeros. Where an event changes the state, and a function that
/// is no wall jumps over zero, as p at an impact, the event of that function follows at once.
///
/// # Errors
/// Those of [`integrate`](super::integrate), [`InputError::Step`] if h is not positive,
/// [`StepFailure::EventsAccumulate`] where more than 1000 events fall into one step of the grid,
/// and [`StepFailure::LeftByEvent`] where an event leaves a state that is not finite; `state` is
/// then the one before the event.
pub fn integrate_with_events(
    step: TakeStep<'_>,
    grid: Grid<f64>,
    state: &mut State<Vec<f64>>,
    events: &[Event<'_>],
    happen: OnEvent<'_>,
    observer: &mut dyn FnMut(u64, StateRef<'_, f64>) -> ControlFlow<()>,
) -> Result<Effort, IntegrateError> {
    let start = state.t;
    if grid.h <= 0.0 {
        return Err(InputError::Step { h: grid.h }.into());
    }
    grid.check_from(start)?;
    // A function of an event may index q, p and w alike.
    state.check(state.q.len())?;
    let time = |n: u64| grid.time(start, n);
    let mut sides: Vec<Side> = events.iter().map(|event| Side::of(event.value(state))).collect();
    let mut effort = Effort::default();
    if observer(0, state.state_ref()).is_break() {
        return Ok(effort);
    }
    for n in 1..=grid.steps {
        let (mut count, mut h) = (0, grid.h);
        while state.t < time(n) {
            let from = state.t;
            let rest = Rest { step: n, h, end: time(n) };
            let own = own_step(&mut *step, rest, events, &mut sides, state)?;
            let (event, spent) = event_within(&mut *step, &own, n, events, &sides, state)?;
            effort += own.effort;
            effort += spent;
            let failed = |failure| RunError { step: n, t: from, failure };
            let accumulate = |count, event| failed(StepFailure::EventsAccumulate { count, event });
            let mut next = match event {
                FirstEvent::Event(found) => Some(found),
                FirstEvent::AtOnce(event) => return Err(accumulate(count, event).into()),
                FirstEvent::None => {
                    state.copy(&own.end);
                    leave(&mut sides, events, state.state_ref());
                    None
                }
            };
            while let Some(found) = next {
                if count == MOST_EVENTS {
                    return Err(accumulate(count, found.event).into());
                }
                count += 1;
                *state = found.there.clone();
                let State { q, p, w, t } = state;
                let seen = happen(found.event, EventState { q, p, w, t: *t });
                if let Some(failure) = not_finite(found.event, state) {
                    state.copy(&found.there);
                    return Err(failed(failure).into());
                }
                if seen.is_break() {
                    return Ok(effort);
                }
                settle(&mut sides, events, &found, [state, &own.end]);
                let (due, spent) = next_due(&mut *step, &own, n, events, &mut sides, state);
                effort += spent;
                next = due.map(|event| Found::at(event, 0.0, state.clone()));
            }
            h = time(n) - state.t;
        }
        state.t = time(n);
        if observer(n, state.state_ref()).is_break() {
            break;
        }
    }
    Ok(effort)
}

/// The failure of an event that leaves a state which is not finite.
fn not_finite(event: usize, state: &State<Vec<f64>>) -> Option<StepFailure> {
    match state.check(state.q.len()) {
        Err(InputError::NotFinite { quantity, dof, value }) => {
            Some(StepFailure::LeftByEvent { event, quantity, dof, value })
        }
        _ => None,
    }
}

/// The first event within a step of the method from `state`, in step `number` of the grid, and the
/// work of the shorter steps that locate it.
fn event_within(
    step: TakeStep<'_>,
    own: &OwnStep,
    number: u64,
    events: &[Event<'_>],
    sides: &[Side],
    state: &State<Vec<f64>>,
) -> Result<(FirstEvent, Effort), IntegrateError> {
    let mut effort = Effort::default();
    let mut within = |share: f64| {
        let unwatched = &mut |_: StateRef<'_, f64>| ControlFlow::Continue(());
        let (there, spent) = stepped(&mut *step, share * own.h, number, state, unwatched)?;
        effort += spent;
        Ok(there)
    };
    let event = first_event(events, sides, [state, &own.end], &mut within)?;
    Ok((event, effort))
}

/// The next of the events that are due at this time, and the work to find it. An impact on a wall
/// is not due if another event has turned the motion away from the wall, as an impact in a corner
/// may.
fn next_due(
    step: TakeStep<'_>,
    own: &OwnStep,
    number: u64,
    events: &[Event<'_>],
    sides: &mut [Side],
    state: &State<Vec<f64>>,
) -> (Option<usize>, Effort) {
    let mut effort = Effort::default();
    while let Some(i) = sides.iter().position(|side| side.due != Due::No) {
        let (side, event) = (&mut sides[i], &events[i]);
        if !event.is_wall {
            return (Some(i), effort);
        }
        let unwatched = &mut |_: StateRef<'_, f64>| ControlFlow::Continue(());
        let ahead = stepped(&mut *step, SHORT_SHARE * own.h, number, state, unwatched);
        let scale = event.value(&own.end).abs();
        let noise = EVENT_ROUNDINGS * f64::EPSILON * scale + 2.0 * event.value(state).abs();
        let leaves = ahead.is_ok_and(|(ahead, spent)| {
            effort += spent;
            event.value(&ahead) * side.sign > noise
        });
        if !leaves {
            return (Some(i), effort);
        }
        side.happen(event.value(state), scale, true);
    }
    (None, effort)
}

/// Updates the sides at the end of a step without an event.
fn leave(sides: &mut [Side], events: &[Event<'_>], state: StateRef<'_, f64>) {
    for (side, event) in sides.iter_mut().zip(events) {
        side.leave((event.function)(state));
    }
}

/// Updates the sides after an event that left the first state, within a step that led to the
/// second.
fn settle(
    sides: &mut [Side],
    events: &[Event<'_>],
    Found { event: happened, there, poles, due, .. }: &Found,
    [after, next]: [&State<Vec<f64>>; 2],
) {
    for (i, (side, event)) in sides.iter_mut().zip(events).enumerate() {
        let [was, is] = [there, after].map(|state| event.value(state));
        if i == *happened && (was != is || side.due == Due::Moved) {
            *side = Side::of(is);
        } else if was != is {
            side.moved(event, [was, is], side.due != Due::No || due.contains(&i));
        } else if i == *happened {
            let scale = event.value(next).abs();
            // At a wall, a motion that the event does not change is at rest and not beyond it.
            side.happen(was, scale, event.is_wall || after != there);
        } else if due.contains(&i) {
            *side = Side { at_zero: None, turned: false, due: Due::AtZero, ..*side };
        } else if poles.contains(&i) || side.at_zero.is_some_and(|noise| was.abs() > noise) {
            side.leave(was);
        }
    }
}
