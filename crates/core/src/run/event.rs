//! Events: zeros of functions of the state along a run.

use super::grid::Grid;
use super::method::Effort;
use crate::error::{InputError, IntegrateError, RunError, StepFailure};
use crate::system::{State, StateRef};
use std::ops::ControlFlow;

/// The most corrections of the time of an event. Bisection alone would take 53.
const MOST_CORRECTIONS: usize = 100;
/// The most events in one step of the grid. A ball that comes to rest by bouncing has infinitely
/// many.
pub const MOST_EVENTS: u64 = 1000;

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

/// Receives event number i of the list and the state there. `Break` ends the run.
pub type Happen<'a> = &'a mut dyn FnMut(usize, EventState<'_>) -> ControlFlow<()>;

/// The share in (0, 1] of a step after which a function is zero, and what `at` gives there. `off`
/// and `beyond` are its values at the ends, which differ in sign, and `end` belongs to the second.
///
/// Regula falsi with the rule of Illinois (M. Dowell and P. Jarratt, BIT 11 (1971) 168-174) finds
/// the share to rounding. Where `at` fails, the nearest value so far is taken.
pub fn zero_within<R>(
    (mut off, mut beyond): (f64, f64),
    end: R,
    mut at: impl FnMut(f64) -> Option<(f64, R)>,
) -> (f64, R) {
    let mut found = (1.0, end);
    let (mut low, mut high, mut nearest) = (0.0, 1.0, beyond.abs());
    let mut moved = None;
    for _ in 0..MOST_CORRECTIONS {
        let share = (low * beyond - high * off) / (beyond - off);
        if nearest == 0.0 || !(low < share && share < high) {
            break;
        }
        let Some((now, there)) = at(share) else { break };
        let is_beyond = (now > 0.0) == (beyond > 0.0);
        if is_beyond {
            (high, beyond) = (share, now);
            off *= if moved == Some(true) { 0.5 } else { 1.0 };
        } else {
            (low, off) = (share, now);
            beyond *= if moved == Some(false) { 0.5 } else { 1.0 };
        }
        moved = Some(is_beyond);
        if now.abs() < nearest {
            (nearest, found) = (now.abs(), (share, there));
        }
    }
    found
}

/// Takes a step of the given length. The state is unchanged after an error, and its time is not
/// set.
pub type Step<'a> = &'a mut dyn FnMut(f64, &mut State<Vec<f64>>) -> Result<Effort, IntegrateError>;

/// [`integrate`](super::integrate) with events. An event within a step is the end of a shorter step
/// of the same method: it has the accuracy of the method, and K is kept if the method keeps it.
/// After an event the run goes on to the next time of the grid.
///
/// A function that crosses zero twice within one step shows no event there.
///
/// # Errors
/// Those of [`integrate`](super::integrate), [`StepFailure::EventsAccumulate`] where more than
/// [`MOST_EVENTS`] events fall into one step of the grid, and [`InputError`] where an event leaves
/// a state that is not finite.
pub fn integrate_with_events(
    step: Step<'_>,
    grid: Grid<f64>,
    state: &mut State<Vec<f64>>,
    (events, happen): (&[Event<'_>], Happen<'_>),
    observer: &mut dyn FnMut(u64, StateRef<'_, f64>) -> ControlFlow<()>,
) -> Result<Effort, IntegrateError> {
    let start = state.t;
    let time = |n: u64| (n as f64).mul_add(grid.h, start);
    let end = time(grid.steps);
    if end + grid.h == end || !end.is_finite() {
        return Err(InputError::TimeStalled { t: end, h: grid.h }.into());
    }
    let values = |state: StateRef<'_, f64>| -> Vec<f64> {
        events.iter().map(|event| (event.function)(state)).collect()
    };
    let mut before = values(state.state_ref());
    // The event that changed the state last, in this step.
    let mut changed = None;
    let mut effort = Effort::default();
    if observer(0, state.state_ref()).is_break() {
        return Ok(effort);
    }
    for n in 1..=grid.steps {
        let mut count = 0;
        while state.t < time(n) {
            let h = if count == 0 { grid.h } else { time(n) - state.t };
            let failed = |t, failure| RunError { step: n, t, failure };
            let mut next = state.clone();
            effort += step(h, &mut next).map_err(|error| match error {
                IntegrateError::Run(error) => failed(state.t, error.failure).into(),
                error => error,
            })?;
            next.t = time(n);
            let mut within = |share: f64| {
                let mut there = state.clone();
                step(share * h, &mut there).ok()?;
                there.t = state.t + share * h;
                Some(there)
            };
            let (i, there) = match first(events, &before, &next, changed, &mut within) {
                First::Event(i, there) if count < MOST_EVENTS => (i, there),
                First::Event(..) | First::AtOnce => {
                    let failure = StepFailure::EventsAccumulate { count };
                    return Err(failed(state.t, failure).into());
                }
                First::None => {
                    *state = next;
                    before = values(state.state_ref());
                    break;
                }
            };
            count += 1;
            *state = there.clone();
            let State { q, p, w, t } = state;
            if happen(i, EventState { q, p, w, t: *t }).is_break() {
                return Ok(effort);
            }
            state.check(state.q.len())?;
            let side = (events[i].function)(next.state_ref());
            before = values(state.state_ref());
            changed = (*state != there).then_some(i);
            // Without a change the function is now on the other side.
            before[i] = if changed.is_some() { 0.0 } else { f64::MIN_POSITIVE.copysign(side) };
        }
        changed = None;
        state.t = time(n);
        if observer(n, state.state_ref()).is_break() {
            break;
        }
    }
    Ok(effort)
}

/// The first event of a step.
enum First {
    /// Its number, and the state there.
    Event(usize, State<Vec<f64>>),
    /// The event that changed the state happens again at once.
    AtOnce,
    None,
}

/// Looks for the first event on the way to `next`. `within` gives the state after a share of the
/// step, and `changed` is the event at its start that changed the state.
fn first(
    events: &[Event<'_>],
    before: &[f64],
    next: &State<Vec<f64>>,
    changed: Option<usize>,
    within: &mut dyn FnMut(f64) -> Option<State<Vec<f64>>>,
) -> First {
    let mut first: Option<(f64, usize, State<Vec<f64>>)> = None;
    for (i, (event, &before)) in events.iter().zip(before).enumerate() {
        let value = |state: &State<Vec<f64>>| (event.function)(state.state_ref());
        let after = value(next);
        let (mut from, mut before) = (0.0, before);
        if before == 0.0 && event.direction.crosses(-after, after) {
            // The function is 0 at the start. Which side it leaves to shows soon after.
            let halves = (1..=MOST_HALVES).map(|k| 0.5f64.powi(k));
            let leaves = |share| within(share).map(|there| (share, value(&there)));
            let crosses = |&(_, value): &(f64, f64)| event.direction.crosses(value, after);
            match halves.filter_map(leaves).find(crosses) {
                Some(found) => (from, before) = found,
                None if changed == Some(i) => return First::AtOnce,
                None => continue,
            }
        }
        if !event.direction.crosses(before, after) {
            continue;
        }
        let (share, there) = zero_within((before, after), next.clone(), |share| {
            let there = within(from + share * (1.0 - from))?;
            Some((value(&there), there))
        });
        let share = from + share * (1.0 - from);
        if first.as_ref().is_none_or(|first| share < first.0) {
            first = Some((share, i, there));
        }
    }
    first.map_or(First::None, |(_, i, there)| First::Event(i, there))
}

/// The halvings of a step after which a function that begins at 0 must have left it.
const MOST_HALVES: i32 = 40;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_is_found_to_rounding() {
        let zero =
            |f: &dyn Fn(f64) -> f64| zero_within((f(0.0), f(1.0)), (), |x| Some((f(x), ()))).0;
        assert!((zero(&|x| x.exp() - 2.0) - 2f64.ln()).abs() < 1e-15);
        assert!((zero(&|x| (x - 0.3).powi(3)) - 0.3).abs() < 1e-5);
        assert!((zero(&|x| (1e6 * (x - 0.77)).tanh()) - 0.77).abs() < 1e-15);
        assert!((zero(&|x| 1.0 - 2.0 * x) - 0.5).abs() < 1e-16);
        // The end itself is the zero.
        assert_eq!(zero(&|x| x - 1.0), 1.0);
    }

    /// Free fall: exact steps, so that all errors are those of the events.
    fn fall(h: f64, state: &mut State<Vec<f64>>) -> Result<Effort, IntegrateError> {
        state.q[0] += h * (state.p[0] - 0.5 * h);
        state.p[0] -= h;
        Ok(Effort::default())
    }

    type Bounces = (Result<Effort, IntegrateError>, Vec<f64>, State<Vec<f64>>);

    /// A ball that falls from height ½ and bounces with a restitution.
    fn bounce(restitution: f64, end: f64) -> Bounces {
        let mut state = State::new(vec![0.5], vec![0.0]).expect("finite");
        let height = |state: StateRef<'_, f64>| state.q[0];
        let events = [Event { function: &height, direction: Direction::Falling }];
        let mut times = Vec::new();
        let mut happen = |_: usize, state: EventState<'_>| {
            times.push(state.t);
            let lost = 0.5 * state.p[0] * state.p[0] * (1.0 - restitution * restitution);
            state.p[0] *= -restitution;
            state.w[0] += lost;
            ControlFlow::Continue(())
        };
        let grid = Grid::of(0.3, (end / 0.3) as u64).expect("a grid");
        let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let outcome = integrate_with_events(
            &mut fall,
            grid,
            &mut state,
            (&events, &mut happen),
            &mut observe,
        );
        (outcome, times, state)
    }

    #[test]
    fn a_ball_bounces_at_the_exact_times() {
        let (outcome, times, state) = bounce(1.0, 30.0);
        outcome.expect("it runs");
        for (k, t) in times.iter().enumerate() {
            assert!((t - (1.0 + 2.0 * k as f64)).abs() < 1e-12, "{k}: {t}");
        }
        assert_eq!(times.len(), 15);
        let energy = state.q[0] + 0.5 * state.p[0] * state.p[0] + state.w[0];
        assert!((energy - 0.5).abs() < 1e-12, "{energy}");
        // With a loss, each flight is shorter by the restitution.
        let (outcome, times, state) = bounce(0.9, 12.0);
        outcome.expect("it runs");
        let flights: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(flights.len() > 6);
        for (k, flight) in flights.iter().enumerate() {
            assert!((flight - 2.0 * 0.9f64.powi(k as i32 + 1)).abs() < 1e-11, "{k}: {flight}");
        }
        let energy = state.q[0] + 0.5 * state.p[0] * state.p[0] + state.w[0];
        assert!((energy - 0.5).abs() < 1e-12, "{energy}");
    }

    #[test]
    fn bounces_without_end_are_a_failure_with_a_name() {
        let (outcome, times, _) = bounce(0.5, 9.0);
        let Err(IntegrateError::Run(error)) = outcome else { panic!("{outcome:?}") };
        assert!(matches!(error.failure, StepFailure::EventsAccumulate { .. }), "{error}");
        // All bounces are over at t = 3.
        assert!(times.iter().all(|t| *t < 3.0 + 1e-9) && error.t < 3.0 + 1e-9, "{error}");
    }

    #[test]
    fn events_that_change_nothing_happen_once() {
        let mut state = State::new(vec![0.5], vec![0.0]).expect("finite");
        let height = |state: StateRef<'_, f64>| state.q[0];
        let late = |state: StateRef<'_, f64>| state.t - 1.2;
        let events = [
            Event { function: &height, direction: Direction::Both },
            Event { function: &late, direction: Direction::Rising },
        ];
        let mut seen = Vec::new();
        let mut happen = |i: usize, state: EventState<'_>| {
            seen.push((i, state.t));
            ControlFlow::Continue(())
        };
        let grid = Grid::of(0.6, 5).expect("a grid");
        let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        integrate_with_events(&mut fall, grid, &mut state, (&events, &mut happen), &mut observe)
            .expect("it runs");
        assert_eq!(seen.len(), 2, "{seen:?}");
        assert!(seen[0].0 == 0 && (seen[0].1 - 1.0).abs() < 1e-14, "{seen:?}");
        assert!(seen[1].0 == 1 && (seen[1].1 - 1.2).abs() < 1e-14, "{seen:?}");
        assert!((state.t - 3.0).abs() < 1e-15 && (state.p[0] + 3.0).abs() < 1e-14);
    }
}
