//! The first event within a step.

use super::pole::Crossing;
use super::side::Side;
use super::{Direction, Event, Within};
use crate::error::IntegrateError;
use crate::solver::zero_within;
use crate::system::State;

/// The halvings of a step after which a function that begins at zero must have left it. A choice.
const MOST_HALVES: i32 = 40;
/// Events whose shares of a step differ by at most this much, relative to them, are at one time and
/// happen in the order of the list. Some roundings.
const SAME_TIME: f64 = 8.0 * f64::EPSILON;

/// The first event of a step.
pub(super) enum FirstEvent {
    Event(Found),
    /// The event of this number, which changed the state, happens again at once.
    AtOnce(usize),
    None,
}

/// An event within a step.
pub(super) struct Found {
    /// Its number.
    pub(super) event: usize,
    /// The share of the step before it, and the state there.
    share: f64,
    pub(super) there: State<Vec<f64>>,
    /// The functions that pass a pole on the way, and those that reach zero at the same time, to
    /// rounding.
    pub(super) poles: Vec<usize>,
    pub(super) due: Vec<usize>,
}

impl Found {
    pub(super) fn at(event: usize, share: f64, there: State<Vec<f64>>) -> Self {
        Self { event, share, there, poles: Vec::new(), due: Vec::new() }
    }
}

/// Looks for the first event on the way from one state to the next. A function that crosses zero
/// twice within the step is seen if it is beyond zero at an event of another function: the way to
/// that event is searched again, for all others.
pub(super) fn first_event(
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
            let mut part = |share: f64| within(share * whole);
            let (share, there) = match zero_of(event, *side, [state, end], &mut part)? {
                Zero::After(share, there) => (share * whole, there),
                Zero::Now => return Ok(FirstEvent::Event(Found::at(i, 0.0, state.clone()))),
                Zero::AtOnce => return Ok(FirstEvent::AtOnce(i)),
                Zero::Pole => {
                    poles.push(i);
                    continue;
                }
                Zero::None => continue,
            };
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

/// The zero of a function between two states.
enum Zero {
    /// The function is zero after this share of the way, at this state.
    After(f64, State<Vec<f64>>),
    /// The function is zero at the start.
    Now,
    /// The function passes zero although an event there has just changed the state.
    AtOnce,
    /// The function changes its sign at a pole.
    Pole,
    /// The function does not cross zero.
    None,
}

/// Looks for the zero of a function that is on the given side, on the way between two states.
fn zero_of(
    event: &Event<'_>,
    side: Side,
    [state, end]: [&State<Vec<f64>>; 2],
    within: Within<'_>,
) -> Result<Zero, IntegrateError> {
    let (now, after) = (event.value(state), event.value(end));
    let (from, before) = match approach(event, side, now, after, within) {
        Approach::After(from, before) => (from, before),
        Approach::Now => return Ok(Zero::Now),
        Approach::AtOnce => return Ok(Zero::AtOnce),
        Approach::None => return Ok(Zero::None),
    };
    let place = |share: f64| from + share * (1.0 - from);
    let mut failure = None;
    let (share, there) = zero_within((before, after), end.clone(), |share| {
        let there = within(place(share)).map_err(|error| failure = Some(error)).ok()?;
        Some((event.value(&there), there))
    });
    if let Some(failure) = failure {
        return Err(failure);
    }
    let share = place(share);
    let crossing = Crossing { way: [state, end], values: [before, after], share, there: &there };
    if !event.is_wall && crossing.is_pole(event, within) {
        return Ok(Zero::Pole);
    }
    Ok(Zero::After(share, there))
}

/// The part of a way on which a function reaches zero.
enum Approach {
    /// The function crosses zero between a share of the step, at which its value is still on its
    /// side, and the end. Holds the share and the value.
    After(f64, f64),
    /// The function is zero at the start.
    Now,
    /// The function passes zero although an event there has just changed the state.
    AtOnce,
    /// The function does not cross zero.
    None,
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
        // A wall never lets its function pass. For a wall in both directions the start does not
        // show which side is beyond it.
        None if event.is_wall && (side.sign != 0.0 || direction != Direction::Both) => {
            Approach::Now
        }
        None => Approach::None,
    }
}
