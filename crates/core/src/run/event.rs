//! Events: zeros of functions of the state along a run.

use super::grid::Grid;
use super::method::Effort;
use crate::error::{InputError, IntegrateError, RunError, StepFailure};
use crate::solver::zero_within;
use crate::system::{State, StateRef};
use std::ops::ControlFlow;

/// The most events in one step of the grid. A ball that comes to rest by bouncing has infinitely
/// many.
pub const MOST_EVENTS: u64 = 1000;
/// The halvings of a step after which a function that begins at zero must have left it. A choice.
const MOST_HALVES: i32 = 40;
/// The largest value of a function at its zero, in roundings of its values at the ends of the step.
/// A choice.
const NOISE_ROUNDINGS: f64 = 64.0;
/// Events whose shares of a step differ by at most this much, relative to them, are at one time and
/// happen in the order of the list. Some roundings.
const SAME_TIME: f64 = 8.0 * f64::EPSILON;

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
    /// The function.
    pub function: &'a (dyn Fn(StateRef<'_, f64>) -> f64 + Sync),
    /// The direction in which it crosses zero.
    pub direction: Direction,
    /// Whether the function must not pass zero. A run that starts at zero and moves beyond it then
    /// begins with an event; otherwise the start is none.
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

/// Takes a step of the given length. The state is unchanged after an error, and its time is not
/// set.
pub type TakeStep<'a> =
    &'a mut dyn FnMut(f64, &mut State<Vec<f64>>) -> Result<Effort, IntegrateError>;

/// [`integrate`](super::integrate) with events. An event within a step is the end of a shorter step
/// of the same method: it has the accuracy of the method, and K is kept if the method keeps it.
/// After an event the run goes on to the next time of the grid. Events at one time happen in the
/// order of the list. w is rounded at every step: it is not summed in blocks, as it is without
/// events.
///
/// A function that crosses zero twice within one step shows no event there, unless it is beyond
/// zero at an event of another function. A pole is no event.
///
/// # Errors
/// Those of [`integrate`](super::integrate), [`StepFailure::EventsAccumulate`] where more than
/// [`MOST_EVENTS`] events fall into one step of the grid, and [`InputError`] where an event leaves
/// a state that is not finite.
pub fn integrate_with_events(
    step: TakeStep<'_>,
    grid: Grid<f64>,
    state: &mut State<Vec<f64>>,
    (events, happen): (&[Event<'_>], OnEvent<'_>),
    observer: &mut dyn FnMut(u64, StateRef<'_, f64>) -> ControlFlow<()>,
) -> Result<Effort, IntegrateError> {
    let start = state.t;
    grid.check_from(start)?;
    let time = |n: u64| grid.time(start, n);
    let mut sides: Vec<Side> = events.iter().map(|event| Side::of(event.value(state))).collect();
    let mut effort = Effort::default();
    if observer(0, state.state_ref()).is_break() {
        return Ok(effort);
    }
    for n in 1..=grid.steps {
        let mut count = 0;
        while state.t < time(n) {
            let h = if count == 0 { grid.h } else { time(n) - state.t };
            let from = state.t;
            let failed = |failure| RunError { step: n, t: from, failure };
            let mut advance = |h: f64| -> Result<State<Vec<f64>>, IntegrateError> {
                let mut there = state.clone();
                match step(h, &mut there) {
                    Ok(spent) => effort += spent,
                    // Over a step below the rounding of the time the state does not change.
                    Err(IntegrateError::Input(InputError::TimeStalled { .. })) => {}
                    Err(IntegrateError::Run(error)) => return Err(failed(error.failure).into()),
                    Err(error) => return Err(error),
                }
                there.t = from + h;
                Ok(there)
            };
            let mut next = advance(h)?;
            next.t = time(n);
            let mut within = |share: f64| advance(share * h);
            let found = match first_event(events, &sides, [state, &next], &mut within)? {
                FirstEvent::Event(found) if count < MOST_EVENTS => found,
                FirstEvent::Event(_) | FirstEvent::AtOnce => {
                    return Err(failed(StepFailure::EventsAccumulate { count }).into());
                }
                FirstEvent::None => {
                    *state = next;
                    let values = events.iter().map(|event| event.value(state));
                    sides.iter_mut().zip(values).for_each(|(side, value)| side.leave(value));
                    break;
                }
            };
            count += 1;
            *state = found.there.clone();
            let State { q, p, w, t } = state;
            if happen(found.event, EventState { q, p, w, t: *t }).is_break() {
                return Ok(effort);
            }
            state.check(state.q.len())?;
            settle(&mut sides, events, &found, [state, &next]);
        }
        state.t = time(n);
        if observer(n, state.state_ref()).is_break() {
            break;
        }
    }
    Ok(effort)
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
        if was != is {
            // The event moved this function, too.
            *side = Side::of(is);
        } else if i == *happened {
            let scale = event.value(next).abs();
            // At a wall a motion that an event does not change is at rest, and not beyond it.
            side.happen(was, scale, event.is_wall || after != there);
        } else if side.at_zero.is_some() && due.contains(&i) {
            // It has been on its side since, and is at zero again.
            *side = Side { at_zero: None, turned: false, ..*side };
        } else if poles.contains(&i) || side.at_zero.is_some_and(|noise| was.abs() > noise) {
            side.leave(was);
        }
    }
}

/// The side of zero on which a function is.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// The sign of the function, or the one it has once it leaves zero; 0 if that is not known.
    sign: f64,
    /// If it is at zero, the size of a value that is a rounding of zero.
    at_zero: Option<f64>,
    /// Whether an event changed the state there, or it is at a wall.
    turned: bool,
}

impl Side {
    /// The side of a value.
    fn of(value: f64) -> Self {
        let (sign, at_zero) = if value == 0.0 { (0.0, Some(0.0)) } else { (value.signum(), None) };
        Self { sign, at_zero, turned: false }
    }

    /// Records an event at a zero with this value: the function is then beyond zero, or back on its
    /// side if the event `turned` it there.
    fn happen(&mut self, value: f64, scale: f64, turned: bool) {
        let noise = NOISE_ROUNDINGS * value.abs().max(f64::EPSILON * scale);
        let sign = if turned { self.sign } else { -self.sign };
        *self = Self { sign, at_zero: Some(noise), turned };
    }

    /// Records the value at the end of a step without another event.
    fn leave(&mut self, value: f64) {
        match self.at_zero {
            // A rounding on the wrong side of zero is not yet a side.
            Some(noise) if value * self.sign <= 0.0 && value.abs() <= noise => self.turned = false,
            _ if value == 0.0 => {}
            _ => *self = Self::of(value),
        }
    }
}

/// The first event of a step.
enum FirstEvent {
    Event(Found),
    /// The event that changed the state happens again at once.
    AtOnce,
    None,
}

/// An event within a step.
struct Found {
    /// Its number.
    event: usize,
    /// The share of the step before it, and the state there.
    share: f64,
    there: State<Vec<f64>>,
    /// The functions that pass a pole on the way, and those that reach zero at the same time, to
    /// rounding.
    poles: Vec<usize>,
    due: Vec<usize>,
}

impl Found {
    fn at(event: usize, share: f64, there: State<Vec<f64>>) -> Self {
        Self { event, share, there, poles: Vec::new(), due: Vec::new() }
    }
}

/// The place in a step at which a function reaches zero.
enum Approach {
    /// It crosses zero between a share of the step, at which it has a value on its side, and the
    /// end: the share and the value.
    After(f64, f64),
    /// It is at zero at the start.
    Now,
    /// It passes zero although an event there has just changed the state.
    AtOnce,
    None,
}

/// The state after a share of a step.
type Within<'a> = &'a mut dyn FnMut(f64) -> Result<State<Vec<f64>>, IntegrateError>;

/// Looks for the first event on the way from one state to the next. A function that crosses zero
/// twice within the step is seen if it is beyond zero at an event of another function: the way to
/// that event is searched again, for all others.
fn first_event(
    events: &[Event<'_>],
    sides: &[Side],
    [state, next]: [&State<Vec<f64>>; 2],
    within: Within<'_>,
) -> Result<FirstEvent, IntegrateError> {
    let (mut first, mut located): (Option<Found>, _) = (None, Vec::new());
    loop {
        let (end, whole) = first.as_ref().map_or((next, 1.0), |first| (&first.there, first.share));
        let (mut sooner, mut poles): (Option<Found>, _) = (None, Vec::new());
        for (i, (event, side)) in events.iter().zip(sides).enumerate() {
            if first.as_ref().is_some_and(|first| first.event == i) {
                continue;
            }
            let (now, after) = (event.value(state), event.value(end));
            let mut part = |share: f64| within(share * whole);
            let (from, before) = match approach(event, *side, now, after, &mut part) {
                Approach::After(from, before) => (from, before),
                Approach::Now => {
                    return Ok(FirstEvent::Event(Found::at(i, 0.0, state.clone())));
                }
                Approach::AtOnce => return Ok(FirstEvent::AtOnce),
                Approach::None => continue,
            };
            let mut failure = None;
            let (share, there) = zero_within((before, after), end.clone(), |share| {
                let there = part(from + share * (1.0 - from));
                let there = there.map_err(|error| failure = Some(error)).ok()?;
                Some((event.value(&there), there))
            });
            if let Some(failure) = failure {
                return Err(failure);
            }
            if !event.is_wall && is_pole([before, event.value(&there), after]) {
                poles.push(i);
                continue;
            }
            let share = whole * (from + share * (1.0 - from));
            located.push((i, share));
            let ahead = sooner.as_ref().or(first.as_ref());
            if ahead.is_none_or(|ahead| share < ahead.share * (1.0 - SAME_TIME)) {
                sooner = Some(Found::at(i, share, there));
            }
        }
        match sooner {
            Some(sooner) => first = Some(sooner),
            None => {
                let Some(first) = first else { return Ok(FirstEvent::None) };
                let same = |(_, share): &(usize, f64)| *share <= first.share * (1.0 + SAME_TIME);
                let due = located.iter().filter(|at| same(at)).map(|at| at.0).collect();
                return Ok(FirstEvent::Event(Found { poles, due, ..first }));
            }
        }
    }
}

/// Whether a function that changes its sign has a pole and no zero, by its values at the ends of
/// the way and at the point found between them. At a pole the value found is no smaller than those
/// at the ends, unless all three are roundings.
fn is_pole([before, found, after]: [f64; 3]) -> bool {
    let (least, most) = (before.abs().min(after.abs()), before.abs().max(after.abs()));
    let size = if most.is_finite() { most } else { least };
    2.0 * found.abs() >= least && found.abs() > NOISE_ROUNDINGS * f64::EPSILON * size
}

/// Finds out how a function that is on the given side reaches zero, with its values at the start
/// and at the end of the step.
fn approach(event: &Event<'_>, side: Side, now: f64, after: f64, within: Within<'_>) -> Approach {
    let direction = event.direction;
    let Some(noise) = side.at_zero else {
        return if now * side.sign <= 0.0 && direction.crosses(side.sign, now) {
            // It reaches zero at the time of an event of another function.
            Approach::Now
        } else if direction.crosses(now, after) {
            Approach::After(0.0, now)
        } else {
            Approach::None
        };
    };
    if after.abs() <= noise {
        // It is still at zero.
        return Approach::None;
    }
    let sign = if side.sign == 0.0 { -after.signum() } else { side.sign };
    if !direction.crosses(sign, after) {
        return Approach::None;
    }
    // It must have been on its side before it crosses zero again.
    let halves = (1..=MOST_HALVES).map(|k| 0.5f64.powi(k));
    let left = halves.filter_map(|share| Some((share, event.value(&within(share).ok()?))));
    let mut left = left.filter(|(_, value)| value * sign > 0.0);
    match left.next() {
        Some((share, value)) => Approach::After(share, value),
        None if side.turned => Approach::AtOnce,
        // No wall lets its function pass. Of one for both directions the start does not tell which
        // side is beyond it.
        None if event.is_wall && (side.sign != 0.0 || direction != Direction::Both) => {
            Approach::Now
        }
        None => Approach::None,
    }
}
