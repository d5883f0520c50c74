//! Events of several functions in one step of the grid, and poles beside them.

use crate::events::{Function, STEPS, Watched, drift, fall, first, free, second, watch};
use afterbay_core::{
    Direction, Effort, Event, EventState, Grid, InputError, IntegrateError, Quantity, RunError,
    State, StateRef, StepFailure, TakeStep, Watch, integrate_with_events,
};
use std::ops::ControlFlow;

/// A ball that rises above 0.455 at t = 0.7 and falls below it at 1.3 in one step, with an event of
/// the time between the two.
#[test]
fn a_function_that_is_beyond_zero_at_another_event_crossed_it_before() {
    let ceiling: Function = |state| state.q[0] - 0.455;
    let time: Function = |state| state.t - 0.9;
    for (h, steps) in [(1.5, 2), (1.4, 1), (0.7, 2), (0.1, 20)] {
        let seen = |both: [Watched; 2]| {
            let (outcome, mut found, state) = watch(&mut fall, [&[0.0], &[1.0]], (h, steps), &both);
            outcome.expect("it runs");
            found.retain(|event| event.1 < 1.1);
            (found, state)
        };
        let ceiling = (ceiling, Direction::Rising, None);
        let time = (time, Direction::Rising, None);
        for (order, [i, j]) in [([ceiling, time], [0, 1]), ([time, ceiling], [1, 0])] {
            let (found, _) = seen(order);
            assert_eq!(found.iter().map(|event| event.0).collect::<Vec<_>>(), [i, j], "{h}");
            assert!((found[0].1 - 0.7).abs() < 1e-14, "{h}: {found:?}");
            assert!((found[1].1 - 0.9).abs() < 1e-15, "{h}: {found:?}");
        }
        // It bounces at the ceiling, with p = 0.3 there.
        let (found, state) = seen([(ceiling.0, Direction::Rising, Some(0)), time]);
        assert!((found[0].1 - 0.7).abs() < 1e-14, "{h}: {found:?}");
        let late = state.t - 0.7;
        let height = 0.455 - 0.3 * late - 0.5 * late * late;
        assert!((state.q[0] - height).abs() < 1e-13, "{h}: {state:?}");
    }
}

#[test]
fn a_pole_at_another_event_or_at_the_start_is_no_zero() {
    for (h, steps) in STEPS {
        let zero: Function = |state| state.q[0] - 0.9;
        let pole: Function = |state| 1.0 / (state.q[0] - 0.9);
        let [zero, pole] = [zero, pole].map(|function| (function, Direction::Both, None));
        for (events, i) in [([zero, pole], 0), ([pole, zero], 1)] {
            let (outcome, found, _) = free([&[2.0], &[-1.0]], (h, steps), &events);
            outcome.expect("it runs");
            assert!(
                matches!(found[..], [(j, t)] if j == i && (t - 1.1).abs() < 1e-14),
                "{h}: {found:?}"
            );
        }
        let infinite: Function = |state| state.q[0] / state.q[1];
        let events = [(infinite, Direction::Both, None)];
        let (outcome, found, _) = free([&[1.0, 0.0], &[0.0, -1.0]], (h, steps), &events);
        outcome.expect("it runs");
        assert!(found.is_empty(), "{h}: {found:?}");
        let falls: Function = |state| 1.0 / state.q[0] - 3.0;
        let (outcome, found, _) =
            free([&[0.0], &[1.0]], (h, steps), &[(falls, Direction::Falling, None)]);
        outcome.expect("it runs");
        assert!(matches!(found[..], [(0, t)] if (t - 1.0 / 3.0).abs() < 1e-15), "{h}: {found:?}");
    }
}

/// The events of a ball at an impact: of the wall, of a record of the same function, which the ball
/// does not pass, and of the momentum, which jumps over zero. All happen, also where the run ends.
#[test]
fn all_events_at_an_impact_happen() {
    let momentum: Function = |state| state.p[0];
    let wall: Watched = (first, Direction::Falling, Some(0));
    let record: Watched = (first, Direction::Falling, None);
    let turn: Watched = (momentum, Direction::Rising, None);
    for (events, order) in [
        ([wall, record, turn], [0, 1, 2]),
        ([record, wall, turn], [0, 1, 2]),
        ([turn, record, wall], [1, 2, 0]),
        ([turn, wall, record], [1, 0, 2]),
    ] {
        for (h, steps) in [(1.0, 1), (0.5, 2), (0.1, 10), (1.0 / 3.0, 4), (0.3, 4), (1.5, 1)] {
            let (outcome, found, _) = watch(&mut fall, [&[0.5], &[0.0]], (h, steps), &events);
            outcome.expect("it runs");
            assert_eq!(found.iter().map(|event| event.0).collect::<Vec<_>>(), order, "{h}");
            assert!(found.iter().all(|(_, t)| (t - 1.0).abs() < 1e-14), "{h}: {found:?}");
        }
    }
}

/// Two impacts at one time both lower H, over the value of a stop between them; and a momentum that
/// is at the zero of its event when it jumps has that event.
#[test]
fn events_that_are_due_are_not_lost_in_another_one() {
    let energy: Function = |state| {
        let part = |j: usize| state.q[j] + 0.5 * state.p[j] * state.p[j];
        part(0) + part(1) - 0.8
    };
    let balls: TakeStep<'_> = &mut |h, state, _| {
        for j in 0..2 {
            state.q[j] += h * (state.p[j] - 0.5 * h);
            state.p[j] -= h;
        }
        Ok(Effort::default())
    };
    let direction = Direction::Falling;
    let events = [first, second, energy].map(|function| function);
    let events: Vec<_> =
        (0..3).map(|i| Event { function: &events[i], direction, is_wall: i < 2 }).collect();
    let (mut found, mut seen) =
        (Vec::new(), |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(()));
    let mut happen = |i: usize, state: EventState<'_>| {
        found.push(i);
        if i < 2 {
            state.p[i] *= -0.5;
        }
        ControlFlow::Continue(())
    };
    let mut state = State::new(vec![0.5; 2], vec![0.0; 2]).expect("finite");
    let grid = Grid::of(0.3, 4).expect("a grid");
    integrate_with_events(balls, grid, &mut state, &events, &mut happen, &mut seen).expect("a run");
    assert_eq!(found, [0, 1, 2]);
    let momentum: Function = |state| state.p[0] + 1.0;
    let record: Watched = (first, Direction::Falling, None);
    let wall: Watched = (first, Direction::Falling, Some(0));
    let falls: Watched = (momentum, Direction::Falling, None);
    let rises: Watched = (momentum, Direction::Rising, None);
    let (outcome, found, _) =
        watch(&mut fall, [&[0.5], &[0.0]], (0.3, 4), &[record, wall, falls, rises]);
    outcome.expect("it runs");
    assert_eq!(found.iter().map(|event| event.0).collect::<Vec<_>>(), [0, 1, 2]);
}

/// Two coordinates whose velocities are coupled meet their walls in a corner. The impact on the
/// first wall turns the second one, too, so that there is no impact on its wall.
#[test]
fn an_impact_in_a_corner_may_turn_both_coordinates() {
    let velocity = |p: &[f64]| [p[0] + 0.5 * p[1], 0.5 * p[0] + p[1]];
    let step: TakeStep<'_> = &mut |h, state, _| {
        let v = velocity(&state.p);
        (0..2).for_each(|j| state.q[j] += h * v[j]);
        Ok(Effort::default())
    };
    let [one, two]: [Function; 2] = [first, second];
    let wall = |function| Event { function, direction: Direction::Falling, is_wall: true };
    let mut found = Vec::new();
    let mut happen = |i: usize, state: EventState<'_>| {
        found.push((i, state.t));
        let v = velocity(state.p);
        state.p[i] -= 2.0 * v[i];
        ControlFlow::Continue(())
    };
    // v = (-1, -0.1), then (1, 0.9).
    let p = [-0.95, 0.4].map(|p| p * 4.0 / 3.0);
    for (h, steps) in STEPS {
        let mut state = State::new(vec![1.0, 0.1], p.to_vec()).expect("finite");
        let grid = Grid::of(h, steps).expect("a grid");
        let mut seen = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let events = [wall(&one), wall(&two)];
        integrate_with_events(&mut *step, grid, &mut state, &events, &mut happen, &mut seen)
            .expect("a run");
        let late = state.t - 1.0;
        assert!((state.q[0] - late).abs() < 1e-13 && (state.q[1] - 0.9 * late).abs() < 1e-13);
    }
    assert!(found.iter().all(|(i, t)| *i == 0 && (t - 1.0).abs() < 1e-14), "{found:?}");
    assert_eq!(found.len(), STEPS.len());
}

/// Two balls bounce at the same times, twice in a step, in the order of the list.
#[test]
fn balls_that_bounce_together_bounce_again_within_the_step() {
    fn fall_both(
        h: f64,
        state: &mut State<Vec<f64>>,
        _: Watch<'_>,
    ) -> Result<Effort, IntegrateError> {
        let end = state.t + h;
        if end + h == end {
            return Err(InputError::TimeStalled { t: end, h }.into());
        }
        for j in 0..2 {
            state.q[j] += h * (state.p[j] - 0.5 * h);
            state.p[j] -= h;
        }
        Ok(Effort::default())
    }
    let floors =
        [(first as Function, Direction::Falling, Some(0)), (second, Direction::Falling, Some(1))];
    for (h, steps) in [(4.0, 2), (8.0, 1), (0.5, 16), (0.3, 26)] {
        let (outcome, found, state) =
            watch(&mut fall_both, [&[0.5, 0.5], &[0.0, 0.0]], (h, steps), &floors);
        outcome.expect("it runs");
        let order: Vec<usize> = found.iter().map(|event| event.0).collect();
        assert_eq!(order, [0, 1, 0, 1, 0, 1, 0, 1], "{h}: {found:?}");
        for (k, (_, t)) in found.iter().enumerate() {
            assert!((t - (1 + 2 * (k / 2)) as f64).abs() < 1e-12, "{h}: {found:?}");
        }
        assert!(state.q.iter().all(|&q| q > -1e-12), "{h}: {state:?}");
    }
}

/// After an event of its own a function is on the side that it has at the next event of another.
#[test]
fn a_function_that_has_left_zero_is_followed_from_event_to_event() {
    let wave: Function = |state| (state.t - 0.5).sin();
    let time: Function = |state| state.t - 5.0;
    for (h, steps) in [(8.0, 1), (3.0, 3), (0.1, 80)] {
        let watched = [(wave, Direction::Rising, None), (time, Direction::Rising, None)];
        let (outcome, found, _) = free([&[1.0], &[1.0]], (h, steps), &watched);
        outcome.expect("it runs");
        let expected = [(0, 0.5), (1, 5.0), (0, 0.5 + std::f64::consts::TAU)];
        assert_eq!(found.len(), 3, "{h}: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-13,
                "{h}: {found:?}"
            );
        }
    }
}

/// Two events at each second zero, with steps that end at numbers of t, so that q is 0 there only
/// to a rounding of t.
#[test]
fn events_at_the_same_zero_all_happen_at_late_times() {
    let mut step = |h: f64, state: &mut State<Vec<f64>>, watch: Watch<'_>| {
        let whole = (state.t + h) - state.t;
        drift(whole, state, watch)
    };
    let wave: Function = |state| state.q[0].sin();
    let events = [(wave, Direction::Both, None), (wave, Direction::Rising, None)];
    for (h, steps) in [(0.037, 20_000), (0.74, 1000)] {
        let (outcome, found, _) = watch(&mut step, [&[0.3], &[1.0]], (h, steps), &events);
        outcome.expect("it runs");
        let count = |i: usize| found.iter().filter(|event| event.0 == i).count();
        assert_eq!([count(0), count(1)], [235, 117], "{h}");
    }
}

/// Free fall of a method that chooses steps of 0.07.
fn fall_by_own_steps(
    h: f64,
    state: &mut State<Vec<f64>>,
    watch: Watch<'_>,
) -> Result<Effort, IntegrateError> {
    let start = state.clone();
    for n in 1..=(h / 0.07) as u64 {
        let mut there = start.clone();
        fall(0.07 * n as f64, &mut there, &mut |_| ControlFlow::Continue(()))?;
        there.t = start.t + 0.07 * n as f64;
        *state = there;
        if state.t < start.t + h && watch(state.state_ref()).is_break() {
            return Ok(Effort::default());
        }
    }
    *state = start;
    fall(h, state, watch)
}

/// A ball that rises from the floor with p = 1 bounces at t = 2, 4, .. and is above 0.48 between
/// 0.8 and 1.2, 2.8 and 3.2, ..
#[test]
fn events_are_looked_for_in_each_of_the_steps_that_a_method_chooses() {
    let above: Function = |state| state.q[0] - 0.48;
    let both = [(above, Direction::Both, None), (first as Function, Direction::Falling, Some(0))];
    for (h, steps) in [(8.1, 1), (2.7, 3), (0.9, 9), (0.045, 180)] {
        let (outcome, found, state) =
            watch(&mut fall_by_own_steps, [&[0.0], &[1.0]], (h, steps), &both);
        outcome.expect("it runs");
        let flight = |k: f64| [(0, 2.0 * k + 0.8), (0, 2.0 * k + 1.2), (1, 2.0 * k + 2.0)];
        let all: Vec<_> = (0..4).flat_map(|k| flight(f64::from(k))).collect();
        assert_eq!(found.len(), all.len(), "{h}: {found:?}");
        for ((i, t), (event, time)) in found.iter().zip(all) {
            assert!(*i == event && (t - time).abs() < 1e-12, "{h}: {i} at {t}, not {time}");
        }
        assert!((state.q[0] - 0.095).abs() < 1e-12 && (state.t - 8.1).abs() < 1e-14, "{state:?}");
    }
}

/// The function of an event may index q and p alike.
#[test]
fn a_state_with_too_few_momenta_is_refused_before_an_event_sees_it() {
    let momentum = |state: StateRef<'_, f64>| state.p[1];
    let events = [Event { function: &momentum, direction: Direction::Both, is_wall: false }];
    let mut state = State { q: vec![0.0; 2], p: vec![0.0], w: vec![0.0; 2], t: 0.0 };
    let mut happen = |_: usize, _: EventState<'_>| ControlFlow::Continue(());
    let mut seen = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let grid = Grid::of(0.1, 4).expect("a grid");
    let outcome =
        integrate_with_events(&mut fall, grid, &mut state, &events, &mut happen, &mut seen);
    let expected = InputError::Length { quantity: Quantity::Momentum, expected: 2, found: 1 };
    assert_eq!(outcome, Err(expected.into()));
}

/// A ball that meets the floor at t = 1, the second event of its list, and has another momentum
/// then.
fn meet_the_floor(
    momentum: impl Fn(f64) -> f64,
    then: ControlFlow<()>,
) -> (RunError, State<Vec<f64>>) {
    let floor = Event { function: &first, direction: Direction::Falling, is_wall: true };
    let late = |state: StateRef<'_, f64>| state.t - 0.5;
    let late = Event { function: &late, direction: Direction::Rising, is_wall: false };
    let mut state = State::new(vec![0.5], vec![0.0]).expect("finite");
    let mut happen = |i: usize, state: EventState<'_>| {
        if i == 0 {
            return ControlFlow::Continue(());
        }
        state.p[0] = momentum(state.p[0]);
        then
    };
    let mut seen = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let grid = Grid::of(0.3, 10).expect("a grid");
    let events = [late, floor];
    match integrate_with_events(&mut fall, grid, &mut state, &events, &mut happen, &mut seen) {
        Err(IntegrateError::Run(error)) => (error, state),
        outcome => panic!("{outcome:?}"),
    }
}

#[test]
fn a_wall_whose_action_does_not_turn_the_motion_is_named() {
    let (error, _) = meet_the_floor(|p| p, ControlFlow::Continue(()));
    assert_eq!(error.failure, StepFailure::EventsAccumulate { count: 1, event: 1 });
    assert!(error.to_string().contains("event 2 of the list"), "{error}");
    // Turned back a thousand times in one step.
    let (error, _) = meet_the_floor(|_| 1e-5, ControlFlow::Continue(()));
    assert_eq!(error.failure, StepFailure::EventsAccumulate { count: 1000, event: 1 });
}

#[test]
fn an_event_that_leaves_a_state_which_is_not_finite_is_named() {
    for then in [ControlFlow::Continue(()), ControlFlow::Break(())] {
        let (error, state) = meet_the_floor(|_| f64::NAN, then);
        let StepFailure::LeftByEvent { event: 1, quantity: Quantity::Momentum, dof: 0, .. } =
            error.failure
        else {
            panic!("{error}")
        };
        assert!(error.to_string().contains("event 2 of the list leaves p1 = NaN"), "{error}");
        assert_eq!(error.step, 4);
        assert!((state.p[0] + 1.0).abs() < 1e-14 && (state.t - 1.0).abs() < 1e-14, "{state:?}");
    }
}
