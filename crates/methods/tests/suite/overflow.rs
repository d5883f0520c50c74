//! Overflow and divergence: a step leaves finite numbers, or fails and leaves the state unchanged.

use crate::catalog::{As, duffing, oscillator};
use crate::failures::{assert_says, bound, closed, failure, state};
use afterbay_core::{Grid, IntegrateError, Quantity, RunError, State, StateRef, StepFailure};
use afterbay_methods::registry::FIXED;

#[test]
fn divergence_ends_before_the_numbers_do() {
    for (name, h) in [("leapfrog", 2.5), ("rk4", 3.5)] {
        for run in [bound(name, &duffing(1.0, 1.0, 0.1)), closed(name, &oscillator(1.0, 0.1))] {
            let mut last = state(2.3, -3.1);
            let mut count = 0;
            let mut show = |n: u64, seen: StateRef<'_, f64>| {
                let StateRef { q: &[q], p: &[p], w: &[w], t } = seen else { panic!("{seen:?}") };
                let state = State { q: [q], p: [p], w: [w], t };
                assert!(state.check(1).is_ok(), "{name} shows {state:?}");
                (count, last) = (n, state);
                std::ops::ControlFlow::Continue(())
            };
            let mut state = state(2.3, -3.1);
            let error =
                run.run(Grid::of(h, 100_000).unwrap(), &mut state, 1, &mut show).unwrap_err();
            let IntegrateError::Run(error) = error else { panic!("{error}") };
            let StepFailure::NonFinite { value, .. } = error.failure else { panic!("{error}") };
            assert!(
                !value.is_finite() && error.step == count + 1 && error.t == last.t,
                "{name}: {error}"
            );
            assert_eq!(state, last, "{name}");
            assert_says(
                &error,
                &[&format!("step {} ", count + 1), &format!("t = {}", last.t), "1 becomes "],
            );
        }
    }
}

#[test]
fn every_method_leaves_finite_numbers_or_the_old_state() {
    let mut failures = 0;
    for row in FIXED {
        let solved = duffing(1.0, 1.0, -0.5).bind(row, As::Nonlinear).ok();
        let closed = oscillator(2.0, 0.5).bind(row, As::Linear).ok();
        for run in solved.into_iter().chain(closed) {
            for (q, p) in [(1e200, 1e200), (-1e155, 1e-300), (1e308, -1e308), (5e-324, 1e308)] {
                let (start, mut state) = (state(q, p), state(q, p));
                match run.step(0.7, &mut state) {
                    Ok(_) => assert!(state.check(1).is_ok(), "{} left {state:?}", row.name),
                    Err(failure) => {
                        assert_eq!(state, start, "{}: {failure}", row.name);
                        failures += 1;
                    }
                }
            }
        }
    }
    assert!(failures > FIXED.len(), "{failures}");
}

#[test]
fn a_reservoir_beyond_the_numbers_is_not_finite() {
    // q and p stay finite, but the dissipated energy overflows.
    let found = failure(&closed("moddg", &oscillator(1.0, 0.5)), 0.5, &state(1.0, 1e200));
    assert_eq!(
        found,
        StepFailure::NonFinite { quantity: Quantity::Reservoir, dof: 0, value: f64::INFINITY }
    );
    assert_says(&found, &["w1 becomes inf"]);
}

#[test]
fn steps_beyond_the_numbers_fail_by_name() {
    for h in [1e155, 1e160, 1e200, 1e300] {
        let found = failure(&closed("moddg", &oscillator(1.0, 0.1)), h, &state(1.3, 0.7));
        assert!(matches!(found, StepFailure::NonFinite { .. }), "{h}: {found}");
    }
}

#[test]
fn huge_steps_keep_k_or_fail_by_name() {
    let system = &oscillator(1.0, 0.1);
    for exponent in 1..150 {
        let mut after = state(1.3, 0.7);
        if bound("moddg", system).step(10.0_f64.powi(exponent), &mut after).is_ok() {
            let drift = (after.total(&**system) - state(1.3, 0.7).total(&**system)).abs();
            assert!(drift < 1e-14, "h = 1e{exponent}: {drift:e} at {after:?}");
        }
    }
}

/// H and w leave the numbers within a step. Every method reports a number that is not finite or, if
/// it raises the order, its δ. None reports a failed projection or an iteration that stalls.
#[test]
fn overflow_is_reported_by_every_method() {
    // All of H, and w alone.
    let starts = [(1e200, 0.0), (1e154, 1.75e308)];
    for (row, (p, w)) in FIXED.iter().flat_map(|row| starts.map(|start| (row, start))) {
        let Ok(run) = oscillator(1.0, 0.5).bind::<f64>(row, As::Linear) else { continue };
        let mut end = State::new([1.0], [p]).unwrap();
        end.w = [w];
        let found = run.step(0.5, &mut end).expect_err(row.name);
        let IntegrateError::Run(RunError { failure, .. }) = found else {
            panic!("{}: {found}", row.name)
        };
        let named = match failure {
            StepFailure::NonFinite { value, .. } => !value.is_finite(),
            StepFailure::Pole { .. } => !row.poles().is_empty(),
            _ => false,
        };
        assert!(named, "{}: {failure}", row.name);
        assert_eq!((end.q, end.p, end.w), ([1.0], [p], [w]), "{}", row.name);
    }
}
