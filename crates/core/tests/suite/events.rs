//! Events: each zero is found once, at its time, wherever it lies in the grid.

use afterbay_core::{
    Direction, Effort, Event, EventState, Grid, InputError, IntegrateError, State, StateRef,
    StepFailure, TakeStep, Watch, integrate_with_events,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Free fall: exact steps, so that all errors are those of the events. Steps below the rounding of
/// t are refused, as those of a method are.
pub(crate) fn fall(
    h: f64,
    state: &mut State<Vec<f64>>,
    _: Watch<'_>,
) -> Result<Effort, IntegrateError> {
    let end = state.t + h;
    if end + h == end {
        return Err(InputError::TimeStalled { t: end, h }.into());
    }
    state.q[0] += h * (state.p[0] - 0.5 * h);
    state.p[0] -= h;
    Ok(Effort::default())
}

type Bounces = (Result<Effort, IntegrateError>, Vec<f64>, State<Vec<f64>>);

/// A ball that falls from height ½ and bounces with a restitution.
fn bounce(restitution: f64, end: f64) -> Bounces {
    bounce_from([0.5, 0.0], restitution, (0.3, (end / 0.3) as u64))
}

/// A ball that starts at height q with momentum p, on a grid of `steps` steps h.
fn bounce_from([q, p]: [f64; 2], restitution: f64, (h, steps): (f64, u64)) -> Bounces {
    let mut state = State::new(vec![q], vec![p]).expect("finite");
    let height = |state: StateRef<'_, f64>| state.q[0];
    let events = [Event { function: &height, direction: Direction::Falling, is_wall: true }];
    let mut times = Vec::new();
    let mut happen = |_: usize, state: EventState<'_>| {
        times.push(state.t);
        let lost = 0.5 * state.p[0] * state.p[0] * (1.0 - restitution * restitution);
        state.p[0] *= -restitution;
        state.w[0] += lost;
        ControlFlow::Continue(())
    };
    let grid = Grid::of(h, steps).expect("a grid");
    let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let outcome =
        integrate_with_events(&mut fall, grid, &mut state, &events, &mut happen, &mut observe);
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

/// Also where all bounces are over at a time of the grid, or at a rounding beside it: the ball then
/// never falls through the floor.
#[test]
fn a_ball_that_comes_to_rest_at_a_time_of_the_grid_stays_above_the_floor() {
    for [q, p] in [[0.5, 0.0], [0.0, -0.5], [0.0, -1.0], [1.0, 1.0], [2.0, 0.0], [0.125, 0.0]] {
        for restitution in [0.1, 0.25, 0.5, 0.75, 0.9] {
            // It meets the floor with the speed v, and then flies for 2 v r, 2 v r² and so on.
            let speed = f64::sqrt(p * p + 2.0 * q);
            let rest = p + speed + 2.0 * speed * restitution / (1.0 - restitution);
            for steps in 1..24_u32 {
                for shift in [0.0, f64::EPSILON, -f64::EPSILON] {
                    let h = rest / f64::from(steps) * (1.0 + shift);
                    let (outcome, _, state) =
                        bounce_from([q, p], restitution, (h, 2 * u64::from(steps)));
                    let scene = format!("{q} {p} {restitution} {steps} {shift}: {state:?}");
                    assert!(state.q[0] > -1e-9, "{scene}");
                    let Err(IntegrateError::Run(error)) = outcome else { panic!("{scene}") };
                    let failure = error.failure;
                    assert!(matches!(failure, StepFailure::EventsAccumulate { .. }), "{scene}");
                }
            }
        }
    }
}

#[test]
fn events_that_change_nothing_happen_once() {
    let mut state = State::new(vec![0.5], vec![0.0]).expect("finite");
    let height = |state: StateRef<'_, f64>| state.q[0];
    let late = |state: StateRef<'_, f64>| state.t - 1.2;
    let events = [
        Event { function: &height, direction: Direction::Both, is_wall: false },
        Event { function: &late, direction: Direction::Rising, is_wall: false },
    ];
    let mut seen = Vec::new();
    let mut happen = |i: usize, state: EventState<'_>| {
        seen.push((i, state.t));
        ControlFlow::Continue(())
    };
    let grid = Grid::of(0.6, 5).expect("a grid");
    let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    integrate_with_events(&mut fall, grid, &mut state, &events, &mut happen, &mut observe)
        .expect("it runs");
    assert_eq!(seen.len(), 2, "{seen:?}");
    assert!(seen[0].0 == 0 && (seen[0].1 - 1.0).abs() < 1e-14, "{seen:?}");
    assert!(seen[1].0 == 1 && (seen[1].1 - 1.2).abs() < 1e-14, "{seen:?}");
    assert!((state.t - 3.0).abs() < 1e-15 && (state.p[0] + 3.0).abs() < 1e-14);
}

/// Free motion. Steps below the rounding of t are refused, as those of a method are.
pub(crate) fn drift(
    h: f64,
    state: &mut State<Vec<f64>>,
    _: Watch<'_>,
) -> Result<Effort, IntegrateError> {
    let end = state.t + h;
    if end + h == end {
        return Err(InputError::TimeStalled { t: end, h }.into());
    }
    let State { q, p, .. } = state;
    q.iter_mut().zip(p).for_each(|(q, p)| *q += h * *p);
    Ok(Effort::default())
}

pub(crate) type Function = fn(StateRef<'_, f64>) -> f64;
pub(crate) type Watched = (Function, Direction, Option<usize>);
pub(crate) type Found = (Result<Effort, IntegrateError>, Vec<(usize, f64)>, State<Vec<f64>>);

/// Free motion with events; those that bounce reverse the momentum of the coordinate they name.
pub(crate) fn free(start: [&[f64]; 2], grid: (f64, u64), events: &[Watched]) -> Found {
    watch(&mut drift, start, grid, events)
}

/// A motion with events.
pub(crate) fn watch(
    step: TakeStep<'_>,
    [q, p]: [&[f64]; 2],
    (h, steps): (f64, u64),
    events: &[Watched],
) -> Found {
    let mut state = State::new(q.to_vec(), p.to_vec()).expect("finite");
    let watched: Vec<Event<'_>> = events
        .iter()
        .map(|(function, direction, bounces)| Event {
            function,
            direction: *direction,
            is_wall: bounces.is_some(),
        })
        .collect();
    let mut found = Vec::new();
    let mut happen = |i: usize, state: EventState<'_>| {
        found.push((i, state.t));
        if let Some(j) = events[i].2 {
            state.p[j] = -state.p[j];
        }
        ControlFlow::Continue(())
    };
    let grid = Grid::of(h, steps).expect("a grid");
    let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let outcome =
        integrate_with_events(step, grid, &mut state, &watched, &mut happen, &mut observe);
    (outcome, found, state)
}

pub(crate) fn first(state: StateRef<'_, f64>) -> f64 {
    state.q[0]
}

pub(crate) fn second(state: StateRef<'_, f64>) -> f64 {
    state.q[1]
}

/// Steps that divide the time of the zero, steps that do not, and steps that end a rounding from
/// it.
pub(crate) const STEPS: [(f64, u64); 7] = [
    (0.25, 20),
    (0.1, 50),
    (1.0 / 3.0, 15),
    (0.3, 17),
    (1.0, 5),
    (1.0 + f64::EPSILON, 5),
    (1.0 - f64::EPSILON, 5),
];

#[test]
fn a_zero_at_a_time_of_the_grid_is_found_once() {
    for (h, steps) in STEPS {
        for direction in [Direction::Falling, Direction::Both] {
            let (outcome, found, _) =
                free([&[1.0], &[-1.0]], (h, steps), &[(first, direction, None)]);
            outcome.expect("it runs");
            assert!(
                found.len() == 1 && (found[0].1 - 1.0).abs() < 1e-15,
                "{h} {direction:?}: {found:?}"
            );
        }
        let (_, found, _) =
            free([&[1.0], &[-1.0]], (h, steps), &[(first, Direction::Rising, None)]);
        assert!(found.is_empty(), "{h}: {found:?}");
    }
}

#[test]
fn a_wall_holds_wherever_it_lies_in_the_grid() {
    for (h, steps) in STEPS {
        for direction in [Direction::Falling, Direction::Both] {
            let (outcome, found, state) =
                free([&[1.0], &[-1.0]], (h, steps), &[(first, direction, Some(0))]);
            outcome.expect("it runs");
            assert!(found.len() == 1, "{h} {direction:?}: {found:?}");
            assert!((state.q[0] - (state.t - 1.0)).abs() < 1e-14, "{h} {direction:?}: {state:?}");
        }
    }
}

/// The rest of a step after an event may be too short to leave the wall.
#[test]
fn a_wall_holds_just_before_a_time_of_the_grid() {
    for k in -40..=40 {
        for (h, steps) in [(0.1, 50), (0.2, 25), (0.3, 17), (0.7, 7)] {
            let height = 1.0 + f64::from(k) * f64::EPSILON / 8.0;
            let (outcome, found, state) =
                free([&[height], &[-1.0]], (h, steps), &[(first, Direction::Falling, Some(0))]);
            outcome.expect("it runs");
            assert!(found.len() == 1, "{k} {h}: {found:?}");
            assert!((state.q[0] - (state.t - height)).abs() < 1e-13, "{k} {h}: {state:?}");
        }
    }
}

#[test]
fn events_at_one_time_all_happen() {
    for (h, steps) in STEPS {
        let watched =
            [(first as Function, Direction::Falling, None), (first, Direction::Falling, None)];
        let (outcome, found, _) = free([&[1.0], &[-1.0]], (h, steps), &watched);
        outcome.expect("it runs");
        assert!(matches!(found[..], [(0, a), (1, b)] if (a - b).abs() < 1e-15), "{h}: {found:?}");
        // Into a corner.
        let watched = [
            (first as Function, Direction::Falling, Some(0)),
            (second, Direction::Falling, Some(1)),
        ];
        for shift in [0.0, 1e-17, 1e-16, 1e-12] {
            let (outcome, found, state) =
                free([&[1.0, 1.0 + shift], &[-1.0, -1.0]], (h, steps), &watched);
            outcome.expect("it runs");
            assert_eq!(found.len(), 2, "{h} {shift}: {found:?}");
            assert!(state.p == [1.0, 1.0] && state.q.iter().all(|q| *q > 0.0), "{h}: {state:?}");
        }
    }
}

/// The momentum of a ball has its own event at each impact, at which it jumps over zero, and at each
/// highest point, where it is zero; in each direction once.
#[test]
fn a_function_that_jumps_over_zero_at_an_impact_has_an_event_there() {
    let momentum: Function = |state| state.p[0];
    for (h, steps) in STEPS {
        let events = [
            (momentum, Direction::Rising, None),
            (first as Function, Direction::Falling, Some(0)),
            (momentum, Direction::Falling, None),
            (momentum, Direction::Both, None),
        ];
        let (outcome, found, _) = watch(&mut fall, [&[0.5], &[0.0]], (h, steps), &events);
        outcome.expect("it runs");
        let found: Vec<_> = found.iter().filter(|(_, t)| *t < 4.5).collect();
        let order: Vec<_> = found.iter().map(|(i, _)| *i).collect();
        assert_eq!(order, [1, 0, 3, 2, 3, 1, 0, 3, 2, 3], "h = {h}: {found:?}");
        for ((_, t), exact) in found.iter().zip([1.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 4.0, 4.0])
        {
            assert!((t - exact).abs() < 1e-13, "h = {h}: {found:?}");
        }
    }
}

#[test]
fn a_run_may_start_at_zero() {
    let grid = (0.3, 10);
    for p in [-1.0, 1.0] {
        for direction in [Direction::Falling, Direction::Rising, Direction::Both] {
            let (outcome, found, _) = free([&[0.0], &[p]], grid, &[(first, direction, None)]);
            outcome.expect("it runs");
            assert!(found.is_empty(), "{p} {direction:?}: {found:?}");
        }
    }
    // A wall holds from the start.
    let wall = [(first as Function, Direction::Falling, Some(0))];
    let (outcome, found, state) = free([&[0.0], &[-1.0]], grid, &wall);
    outcome.expect("it runs");
    assert!(found == [(0, 0.0)] && (state.q[0] - 3.0).abs() < 1e-14, "{found:?} {state:?}");
    let (outcome, found, _) = free([&[0.0], &[1.0]], grid, &wall);
    outcome.expect("it runs");
    assert!(found.is_empty());
    let both = [(first as Function, Direction::Both, Some(0))];
    for p in [-1.0, 1.0] {
        let (outcome, found, _) = free([&[0.0], &[p]], grid, &both);
        outcome.expect("it runs");
        assert!(found.is_empty(), "{p}: {found:?}");
    }
    // A ball at rest on the floor falls as soon as it is let go.
    let mut state = State::new(vec![0.0], vec![0.0]).expect("finite");
    let event = Event { function: &first, direction: Direction::Falling, is_wall: true };
    let mut happen = |_: usize, state: EventState<'_>| {
        state.p[0] = -state.p[0];
        ControlFlow::Continue(())
    };
    let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let grid = Grid::of(0.1, 10).expect("a grid");
    let outcome =
        integrate_with_events(&mut fall, grid, &mut state, &[event], &mut happen, &mut observe);
    let Err(IntegrateError::Run(error)) = outcome else { panic!("{outcome:?}") };
    assert!(matches!(error.failure, StepFailure::EventsAccumulate { .. }), "{error}");
}

#[test]
fn a_pole_is_no_zero() {
    for (h, steps) in STEPS {
        let inverse: Function = |state| 1.0 / (state.q[0] - 0.9);
        let (outcome, found, _) =
            free([&[2.0], &[-1.0]], (h, steps), &[(inverse, Direction::Both, None)]);
        outcome.expect("it runs");
        assert!(found.is_empty(), "{h}: {found:?}");
    }
}

/// Steps of 1/100 end at every zero up to the roundings of t, of q = t + 1000.1 and of the
/// function.
#[test]
fn zeros_within_roundings_of_the_ends_of_steps_are_found() {
    let of_time: Function = |state| (TAU * state.t).sin();
    let of_place: Function = |state| (TAU * state.q[0]).sin();
    let above: Function = |state| 1e3 * (state.q[0] - 1150.0);
    for (function, direction, count) in [
        (of_time, Direction::Rising, 300),
        (of_time, Direction::Both, 600),
        (of_place, Direction::Falling, 300),
        (of_place, Direction::Both, 600),
        (above, Direction::Rising, 1),
    ] {
        let events = [(function, direction, None)];
        let (outcome, found, _) = free([&[1000.1], &[1.0]], (0.01, 30_030), &events);
        outcome.expect("it runs");
        assert_eq!(found.len(), count, "{direction:?}");
    }
}

#[test]
fn steps_backwards_are_refused() {
    for h in [-0.1, 0.0, f64::NAN] {
        let mut state = State::new(vec![1.0], vec![0.0]).expect("finite");
        let mut happen = |_: usize, _: EventState<'_>| ControlFlow::Continue(());
        let mut observe = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let grid = Grid { h, steps: 10 };
        let outcome =
            integrate_with_events(&mut fall, grid, &mut state, &[], &mut happen, &mut observe);
        let Err(IntegrateError::Input(error)) = outcome else { panic!("{h}: {outcome:?}") };
        let says = if h.is_nan() { "is not finite" } else { "must be positive" };
        assert_eq!(error.to_string(), format!("the step h = {h:?} {says}"));
        assert_eq!((state.t, state.q[0]), (0.0, 1.0));
    }
}
