//! A bound method may reuse its workspace; this must not change any result.

use crate::bind::{linear, nonlinear, separable, uniform};
use afterbay_core::{Grid, State};
use afterbay_methods::registry::{FIXED, Row, Run};
use afterbay_systems::{DampedOscillator, Duffing, FputChain, VanDerPolRing};
use std::ops::ControlFlow;

/// Checks that a run gives the same bits after other runs, one of which failed, and one of which
/// began where the last ended.
fn knows_nothing_of_others(dof: usize, bind: impl Fn(&Row) -> Option<Run<f64>>) {
    let mut bound = 0;
    for row in FIXED {
        let Some(run) = bind(row) else { continue };
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
        let fresh = |start| bind(row).map(|run| go(&run, start, 0.1, 7));
        let [from_here, from_end] = [&here, &end].map(fresh);
        assert_eq!(
            Some(go(&run, &end, 0.1, 7)),
            from_end,
            "{}, from where another ended",
            row.name
        );
        go(&run, &there, 1e200, 7);
        assert_eq!(Some(go(&run, &here, 0.1, 7)), from_here, "{}, after others", row.name);
        for _ in 0..2 {
            assert_eq!(go(&run, &here, 0.1, 1), after_one, "{}, the same step again", row.name);
        }
        bound += 1;
    }
    assert!(bound > 3);
}

#[test]
fn of_one_degree_of_freedom() {
    knows_nothing_of_others(1, |row| nonlinear(row, Duffing::new(-1.0, 1.0, 0.2).unwrap()).ok());
    knows_nothing_of_others(1, |row| linear(row, DampedOscillator::new(1.0, 0.2).unwrap()).ok());
}

#[test]
fn of_many() {
    knows_nothing_of_others(3, |row| separable(row, FputChain::new(3, 0.5, 0.1).unwrap()).ok());
    knows_nothing_of_others(9, |row| uniform(row, VanDerPolRing::new(9, 0.5, 0.1).unwrap()).ok());
}
