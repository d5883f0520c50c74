//! States and times that a run refuses before its first step, and the message of each refusal.

use crate::bind::by_force;
use crate::catalog::{As, duffing, oscillator, written};
use crate::failures::{Pair, assert_says, bound, closed, state};
use afterbay_core::{
    Effort, Grid, InputError, IntegrateError, Quantity, State, StateRef, integrate,
};
use afterbay_methods::ModDg;
use afterbay_methods::registry::{FIXED, find};
use afterbay_systems::{Description, DissipationText};
use std::ops::ControlFlow;

#[test]
fn a_state_of_another_length_is_refused() {
    let refused = |outcome: Result<Effort, IntegrateError>, quantity, found| {
        let length = InputError::Length { quantity, expected: 1, found };
        assert_eq!(outcome, Err(IntegrateError::Input(length)));
    };
    for run in [bound("moddg", &duffing(1.0, 1.0, 0.1)), closed("moddg", &oscillator(1.0, 0.1))] {
        for n in [0, 2] {
            let mut state = State::new(vec![1.0; n], vec![0.5; n]).unwrap();
            let before = state.clone();
            refused(run.step(0.1, &mut state), Quantity::Coordinate, n);
            assert_eq!(state, before);
        }
        let mut state = State { p: vec![], ..State::new(vec![1.0], vec![0.5]).unwrap() };
        refused(run.step(0.1, &mut state), Quantity::Momentum, 0);
    }
}

/// Methods named physical reasons, as a singularity between q1 = 1 and NaN.
#[test]
fn a_step_that_is_not_finite_is_refused() {
    for row in FIXED {
        let system = oscillator(1.0, 0.1);
        let Ok(run) = system.bind::<f64>(row, As::Curved) else { continue };
        for h in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut state = State::new(vec![1.0], vec![0.5]).unwrap();
            let outcome = run.step(h, &mut state);
            let Err(IntegrateError::Input(error @ InputError::Step { .. })) = outcome else {
                panic!("{}: {outcome:?}", row.name)
            };
            // Steps back in time are taken.
            assert_eq!(error.to_string(), format!("the step h = {h:?} is not finite"));
        }
    }
}

#[test]
fn a_state_that_does_not_fit_is_refused_before_the_first_step() {
    let linear = &*oscillator(1.0, 0.1).abilities::<f64>().linear().unwrap();
    let grid = || Grid::of(0.1, 3).unwrap();
    let vec = |q: &[f64], p: &[f64], w: &[f64]| State {
        q: q.to_vec(),
        p: p.to_vec(),
        w: w.to_vec(),
        t: 0.0,
    };
    for (wrong, quantity, found) in [
        (vec(&[1.0, 2.0], &[1.0, 2.0], &[0.0, 0.0]), Quantity::Coordinate, 2),
        (vec(&[1.0], &[], &[0.0]), Quantity::Momentum, 0),
        (vec(&[1.0], &[1.0], &[0.0, 0.0, 0.0]), Quantity::Reservoir, 3),
    ] {
        let mut state = wrong.clone();
        let error = integrate(&ModDg::linear(), linear, grid(), &mut state, &mut ()).unwrap_err();
        let expected = InputError::Length { quantity, expected: 1, found };
        assert_eq!(error, IntegrateError::Input(expected.clone()));
        assert_eq!(wrong.check(1), Err(expected));
        assert_eq!(state, wrong);
        assert_says(
            &error,
            &[&quantity.to_string(), &format!("{found} entries"), "degrees of freedom is 1"],
        );
    }
    for (wrong, quantity) in [
        (vec(&[f64::INFINITY], &[1.0], &[0.0]), Quantity::Coordinate),
        (vec(&[1.0], &[f64::NEG_INFINITY], &[0.0]), Quantity::Momentum),
        (vec(&[1.0], &[1.0], &[f64::INFINITY]), Quantity::Reservoir),
    ] {
        let bound = ["leapfrog", "rk4", "moddg"].map(|name| {
            let run = oscillator(1.0, 0.1).bind(find(name).unwrap(), As::Separable).unwrap();
            let mut look = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            run.run(grid(), &mut wrong.clone(), 1, &mut look).map(|done| done.effort)
        });
        let alone = integrate(&ModDg::linear(), linear, grid(), &mut wrong.clone(), &mut ());
        for error in bound.into_iter().chain([alone]) {
            let error = error.unwrap_err();
            let IntegrateError::Input(InputError::NotFinite { quantity: found, dof: 0, .. }) =
                error
            else {
                panic!("{error}")
            };
            assert_eq!(found, quantity);
            assert_says(&error, &[&format!("{quantity}1 = "), "inf"]);
        }
    }
    assert_says(&State::new([1.0], [f64::NAN]).unwrap_err(), &["p1 = NaN"]);
    assert_says(
        &State::new(vec![1.0, 2.0], vec![1.0]).unwrap_err(),
        &["p has 1 entry", "degrees of freedom is 2"],
    );
}

/// A method knows its family only, as `increment` for `increment-8`.
#[test]
fn a_method_that_does_not_apply_is_named_as_in_the_registry() {
    let system = written(&Description {
        potential: "q1^2/2 + q2^2/2".to_owned(),
        dissipation: DissipationText::Forces(["v1*v2^2", "v2*v1^2"].map(str::to_owned).to_vec()),
        ..Description::default()
    });
    let mut refused = 0;
    for row in FIXED {
        if let Err(InputError::Unsupported { method, why }) = system.bind::<f64>(row, As::Separable)
        {
            assert_eq!(method, row.name, "{why}");
            refused += 1;
        }
    }
    assert!(refused > 10, "{refused}");
}

#[test]
fn the_scheme_for_one_degree_of_freedom_refuses_two() {
    let Err(error) = by_force::<f64, _>(find("moddg").unwrap(), Pair) else { panic!("it applies") };
    assert!(matches!(error, InputError::Unsupported { method: "moddg", .. }), "{error}");
    assert_says(&error, &["moddg", "one degree of freedom"]);
}

#[test]
fn time_that_stands_still_is_refused() {
    let run = closed("moddg", &oscillator(1.0, 0.1));
    for (t, h, steps) in [(1e20, 0.1, 10), (f64::NAN, 0.1, 10), (1e16, 0.5, 1)] {
        let mut late = State { t, ..state(1.0, 0.5) };
        let grid = Grid::of(h, steps).unwrap();
        let mut look = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let error = run.run(grid, &mut late, 1, &mut look).unwrap_err();
        assert!(
            matches!(error, IntegrateError::Input(InputError::TimeStalled { .. })),
            "{t}: {error}"
        );
        assert_eq!((late.q, late.p), ([1.0], [0.5]));
    }
    assert!(matches!(Grid::<f64>::of(1e307, 100), Err(InputError::End { .. })));
}
