//! A bound method may reuse its workspace; this must not change any result.

use crate::catalog::{As, Built, chain, duffing, oscillator, ring};
use afterbay_core::{Formulas, FromFormulas, Grid, Method, Scalar, State};
use afterbay_methods::Leapfrog;
use afterbay_methods::registry::{FIXED, Run};
use std::ops::ControlFlow;

/// Checks that a run gives the same bits after other runs, one of which failed, and one of which
/// began where the last ended.
fn knows_nothing_of_others(system: &Built, form: As) {
    let (mut bound, dof) = (0, system.dof());
    for row in FIXED {
        let Ok(run) = system.bind(row, form) else { continue };
        let go = |run: &Run<f64>, start: &State<Vec<f64>>, h: f64, steps: u64| {
            let mut state = start.clone();
            let grid = Grid::of(h, steps).unwrap();
            // Some of these runs fail.
            let _ = run.run(grid, &mut state, 1, &mut |_, _| ControlFlow::Continue(()));
            State { t: 0.0, ..state }
        };
        let begin = |a: f64| {
            State::new(vec![a; dof], (0..dof).map(|j| 0.3 - a * j as f64).collect()).unwrap()
        };
        let (here, there) = (begin(0.7), begin(-0.2));
        let after_one = go(&run, &here, 0.1, 1);
        let end = go(&run, &there, 0.05, 7);
        let fresh = |start| go(&system.bind(row, form).unwrap(), start, 0.1, 7);
        let [from_here, from_end] = [&here, &end].map(fresh);
        assert_eq!(go(&run, &end, 0.1, 7), from_end, "{}, from where another ended", row.name);
        go(&run, &there, 1e200, 7);
        assert_eq!(go(&run, &here, 0.1, 7), from_here, "{}, after others", row.name);
        for _ in 0..2 {
            assert_eq!(go(&run, &here, 0.1, 1), after_one, "{}, the same step again", row.name);
        }
        bound += 1;
    }
    assert!(bound > 3);
}

#[test]
fn of_one_degree_of_freedom() {
    knows_nothing_of_others(&duffing(-1.0, 1.0, 0.2), As::Nonlinear);
    knows_nothing_of_others(&oscillator(1.0, 0.2), As::Linear);
}

#[test]
fn of_many() {
    knows_nothing_of_others(&chain(3, 0.5, 0.1), As::Separable);
    knows_nothing_of_others(&ring(9, 0.5, 0.1), As::Uniform);
}

/// V = q1 q2, D_1 = 0 and D_2 = -100 v2². The equation for the second p½ has no solution where the
/// second mass is fast.
struct WithoutSecondKick;

impl Formulas for WithoutSecondKick {
    fn dof(&self) -> usize {
        2
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        q[0] * q[1]
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        if j == 1 { T::from_f64(-100.0) * v[1] * v[1] } else { T::zero() }
    }
}

#[test]
fn leapfrog_keeps_no_forces_of_a_step_that_failed() {
    let (system, h) = (FromFormulas(WithoutSecondKick), 0.125);
    let fresh = || Method::<[f64; 2], _>::workspace(&Leapfrog, &system).unwrap();
    let mut used = fresh();
    let mut fast = State::new([0.5, 0.25], [1.0, 4.0]).unwrap();
    Leapfrog.step(&system, h, &mut fast, &mut used).unwrap_err();

    // The failed step has already moved the first coordinate here. Its forces are those of the old
    // place.
    let moved = 0.5 + h * (1.0 - h / 2.0 * 0.25);
    let start = State::new([moved, 0.25], [1.0, 0.0]).unwrap();
    let mut ends = [start.clone(), start];
    Leapfrog.step(&system, h, &mut ends[0], &mut fresh()).unwrap();
    Leapfrog.step(&system, h, &mut ends[1], &mut used).unwrap();
    assert_eq!(ends[0], ends[1]);
}
