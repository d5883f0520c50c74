//! States and times that a run refuses before its first step, and the message of each refusal.

use crate::bind::by_force;
use crate::catalog::{As, duffing, oscillator, written};
use crate::failures::{Pair, assert_says, bound, closed, state};
use crate::motors::{Model, Scene, Shaker};
use afterbay_core::{
    Effort, Grid, InputError, IntegrateError, Quantity, State, StateRef, Tolerance, integrate,
    integrate_within, with_motors,
};
use afterbay_methods::registry::{FIXED, Setting, bind, find};
use afterbay_methods::{AdaptiveDop853, ModDg, Rk4};
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

/// Mathieu's equation under a drive has a clock and a motor.
#[test]
fn a_state_without_motors_is_told_how_to_add_them() {
    let drive = Some(Shaker::of_first(1.0, 1.0));
    let system = Scene { model: Model::Mathieu, drive }.system::<f64>();
    let curved = system.clone().second_derivatives().unwrap();
    let alone = State::new(vec![1.0], vec![0.5]).unwrap();
    let (grid, tolerance) = (Grid::of(0.1, 3).unwrap(), Tolerance::all(1e-6));
    let run = |name: &str| bind::<f64>(find(name).unwrap(), system.clone()).unwrap();
    let (fixed, chosen) = (run("rk4"), run("adaptive-dop853"));
    let mut look = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let mut unwatched = |_: StateRef<'_, f64>| ControlFlow::Continue(());
    let mut state = alone.clone();
    let outcomes = [
        fixed.run(grid, &mut state, 1, &mut look).map(drop),
        fixed.step(0.1, &mut state).map(drop),
        fixed.stepper(None, 1.0).unwrap()(0.1, &mut state, &mut unwatched).map(drop),
        chosen.run(Setting::Tolerance(tolerance, 1.0), &mut state, 1, &mut look).map(drop),
        chosen.sample(&tolerance, &[1.0], &mut state, &mut look, &mut || false).map(drop),
        integrate(&Rk4, &*system, grid, &mut state, &mut ()).map(drop),
        integrate_within(&AdaptiveDop853, &*curved, &tolerance, 1.0, &mut state, &mut ()).map(drop),
    ];
    for outcome in outcomes {
        let error = outcome.unwrap_err();
        assert_eq!(error, InputError::NoMotors { found: 1, motors: 2 }.into());
        assert_says(&error, &["1 degree of freedom", "2 motors", "`with_motors(&state, 2)`"]);
    }
    assert_eq!(state, alone);
    fixed.run(grid, &mut with_motors(&alone, 2), 1, &mut look).unwrap();
    // A state that lacks one of two motors may lack anything.
    let expected = InputError::Length { quantity: Quantity::Coordinate, expected: 3, found: 2 };
    let outcome = fixed.run(grid, &mut with_motors(&alone, 1), 1, &mut look);
    assert_eq!(outcome.unwrap_err(), expected.into());
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
fn a_system_without_a_formula_for_delta_is_told_the_trait() {
    let system = Scene { model: Model::Single { drag: true }, drive: None }.system::<f64>();
    let mut refused = 0;
    for row in FIXED {
        if let Err(error) = bind::<f64>(row, system.clone())
            && error.to_string().contains('δ')
        {
            assert_says(&error, &[row.name, "`OrderRaising`"]);
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
