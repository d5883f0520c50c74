//! Damped motion that approaches an equilibrium away from the origin, where forces are differences
//! of large terms.

use crate::catalog::{As, Built, duffing, oscillator, written};
use afterbay_core::{Grid, State, StateRef, Tolerance};
use afterbay_methods::registry::{self, FIXED, Needs, Setting};
use afterbay_systems::{Description, DissipationText};
use std::ops::ControlFlow;

const END: f64 = 100.0;
const STEPS: [f64; 3] = [0.025, 0.125, 0.2];

/// A Morse potential with its minimum at q1 = 2, coupled to a spring of length 3.
fn bond(potential: &str, friction: &[&str]) -> Built {
    let friction = DissipationText::Forces(friction.iter().map(ToString::to_string).collect());
    written(&Description {
        potential: potential.into(),
        dissipation: friction,
        ..Description::default()
    })
}

/// Checks that every method that applies and has no pole at rest completes the run, ends at the
/// equilibrium, and conserves K if it claims to.
fn comes_to_rest((system, form): (&Built, As), start: &State<Vec<f64>>, rest: &[f64]) {
    let total = start.total(&**system);
    let judge = |name: &str, h: f64, keeps_k: bool, state: &State<Vec<f64>>| {
        // H, and with it K, determines the equilibrium only to the square root of a rounding.
        let near = if registry::find(name).is_some_and(registry::Row::is_adaptive) {
            1e-7_f64.max(10.0 * h)
        } else {
            1e-7
        };
        for (&q, &rest) in state.q.iter().zip(rest) {
            assert!((q - rest).abs() < near, "{name}, h = {h}: {state:?}");
        }
        let off = (state.total(&**system) - total).abs();
        assert!(!keeps_k || off < 1e-11, "{name}, h = {h}: K is off by {off:e}");
    };
    for row in FIXED.iter().filter(|row| row.poles().is_empty() && row.needs != Needs::Linear) {
        let Ok(run) = system.bind::<f64>(row, form) else { continue };
        for h in STEPS {
            let mut state = start.clone();
            let done = run.run(Grid::new(h, END).unwrap(), &mut state, u64::MAX, &mut |_, _| {
                ControlFlow::Continue(())
            });
            match done {
                Ok(_) => judge(row.name, h, row.keeps_k, &state),
                Err(error) => panic!("{}, h = {h}: {error}", row.name),
            }
        }
    }
    let tolerances = [1e-3, 1e-6, 1e-9, 1e-12];
    for (row, tolerance) in
        registry::ADAPTIVE.iter().flat_map(|row| tolerances.map(|tolerance| (row, tolerance)))
    {
        let mut state = start.clone();
        let within = system.bind(row, As::Curved).unwrap();
        let done = within.run(
            Setting::Tolerance(Tolerance::all(tolerance), END),
            &mut state,
            1,
            &mut |_, _| ControlFlow::Continue(()),
        );
        match done {
            Ok(_) => judge(row.name, tolerance, true, &state),
            Err(error) => panic!("{}, {tolerance}: {error}", row.name),
        }
        let times: Vec<f64> = (0..200).map(|i| 0.5 * f64::from(i)).collect();
        let (mut state, mut off) = (start.clone(), 0.0_f64);
        let mut look = |_: u64, state: StateRef<'_, f64>| {
            off = off.max((state.total(&**system) - total).abs());
            ControlFlow::Continue(())
        };
        let seen =
            within.sample(&Tolerance::all(tolerance), &times, &mut state, &mut look, &mut || false);
        assert!(
            seen.is_ok() && off < 1e-11,
            "{}, {tolerance}: K is off by {off:e}, {seen:?}",
            row.name
        );
    }
}

#[test]
fn in_a_well() {
    for c in [0.8, 2.0, 3.0] {
        let system = duffing(-1.0, 1.0, c);
        let start = State::new(vec![1.5], vec![0.5]).unwrap();
        comes_to_rest((&system, As::Nonlinear), &start, &[1.0]);
    }
}

#[test]
fn of_a_bond() {
    let system = bond("(1 - exp(-(q1 - 2)))^2 + (q2 - 3)^2*(1 + q1^2/4)", &["p1", "0.7*p2"]);
    let start = State::new(vec![2.6, 2.0], vec![0.5, 0.2]).unwrap();
    comes_to_rest((&system, As::Separable), &start, &[2.0, 3.0]);
    assert_eq!(system.dof(), 2);
}

/// Runs in which H becomes less than the least number, while w keeps nearly all of K.
#[test]
fn motion_that_decays_below_the_least_number_goes_on() {
    let start = State::new(vec![1.0], vec![0.0]).unwrap();
    for (system, form) in
        [(oscillator(1.0, 1.0), As::Linear), (duffing(1.0, 0.5, 1.0), As::Nonlinear)]
    {
        let total = start.total(&*system);
        for row in FIXED.iter().filter(|row| row.poles().is_empty()) {
            let Ok(run) = system.bind::<f64>(row, form) else { continue };
            let (mut state, grid) = (start.clone(), Grid::new(0.1, 2000.0).unwrap());
            let done = run.run(grid, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(()));
            assert!(done.is_ok(), "{}: {done:?}", row.name);
            let off = (state.total(&*system) - total).abs();
            assert!(!row.keeps_k || off < 1e-13, "{}: K is off by {off:e}", row.name);
        }
    }
}

/// Steps that lose so much that a block of steps ends far below the least number.
#[test]
fn long_steps_decay_below_the_least_number() {
    let start = State::new(vec![1.0], vec![0.2]).unwrap();
    for (b, h) in [(1.0, 1.0), (1.0, 2.0), (2.0, 0.25)] {
        let system = oscillator(1.0, b);
        for row in FIXED.iter().filter(|row| row.a_stable && row.poles().is_empty()) {
            let Ok(run) = system.bind::<f64>(row, As::Linear) else { continue };
            let (mut state, grid) = (start.clone(), Grid::of(h, 6000).unwrap());
            let done = run.run(grid, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(()));
            assert!(done.is_ok(), "{} with b = {b}, h = {h}: {done:?}", row.name);
            assert_eq!((state.q[0], state.p[0]), (0.0, 0.0), "{} with b = {b}", row.name);
        }
    }
}
