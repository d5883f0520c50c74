//! States and times that a run refuses before its first step, and the message of each refusal.

use crate::failures::{Pair, assert_says, bound, closed, oscillator, state};
use afterbay_core::{Effort, Grid, InputError, IntegrateError, Quantity, State, integrate};
use afterbay_methods::{Leapfrog, ModDg, Rk4};
use afterbay_systems::Duffing;

#[test]
fn a_state_of_another_length_is_refused() {
    let refused = |outcome: Result<Effort, IntegrateError>, quantity, found| {
        let length = InputError::Length { quantity, expected: 1, found };
        assert_eq!(outcome, Err(IntegrateError::Input(length)));
    };
    for run in [
        bound("moddg", Duffing::new(1.0, 1.0, 0.1).unwrap()),
        closed("moddg", oscillator(1.0, 0.1)),
    ] {
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

#[test]
fn a_state_that_does_not_fit_is_refused_before_the_first_step() {
    let system = oscillator(1.0, 0.1);
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
        let error = integrate(&Rk4, &system, grid(), &mut state, &mut ()).unwrap_err();
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
        for error in [
            integrate(&Leapfrog, &system, grid(), &mut wrong.clone(), &mut ()),
            integrate(&Rk4, &system, grid(), &mut wrong.clone(), &mut ()),
            integrate(&ModDg::newton(), &system, grid(), &mut wrong.clone(), &mut ()),
            integrate(&ModDg::linear(), &system, grid(), &mut wrong.clone(), &mut ()),
        ] {
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

#[test]
fn the_scheme_for_one_degree_of_freedom_refuses_two() {
    let start = State::new([0.5, 0.1], [0.0, 0.0]).unwrap();
    let mut state = start.clone();
    let error = integrate(&ModDg::newton(), &Pair, Grid::of(0.1, 3).unwrap(), &mut state, &mut ())
        .unwrap_err();
    assert!(
        matches!(error, IntegrateError::Input(InputError::Unsupported { method: "moddg", .. })),
        "{error}"
    );
    assert_says(&error, &["moddg", "one degree of freedom"]);
    assert_eq!(state, start);
}

#[test]
fn time_that_stands_still_is_refused() {
    let system = oscillator(1.0, 0.1);
    for (t, h, steps) in [(1e20, 0.1, 10), (f64::NAN, 0.1, 10), (1e16, 0.5, 1)] {
        let mut late = State { t, ..state(1.0, 0.5) };
        let error =
            integrate(&ModDg::linear(), &system, Grid::of(h, steps).unwrap(), &mut late, &mut ())
                .unwrap_err();
        assert!(
            matches!(error, IntegrateError::Input(InputError::TimeStalled { .. })),
            "{t}: {error}"
        );
        assert_eq!((late.q, late.p), ([1.0], [0.5]));
    }
    assert!(matches!(Grid::<f64>::of(1e307, 100), Err(InputError::End { .. })));
}
