//! An iteration converges if its update is below the rounding of the unknown: chains partly at
//! rest, tails that underflow, saturated friction, forces that cancel.

use super::scenes::{Toda, drift};
use crate::bind::{Curved, separable};
use afterbay_core::{Curvature, Grid, Separable, State};
use afterbay_methods::registry::{FIXED, Needs, Row, Run};
use afterbay_systems::{Custom, Description, DissipationText, FputChain};
use std::ops::ControlFlow;

/// The methods that are implicit in all of (q, p).
fn solvers() -> impl Iterator<Item = &'static Row> {
    FIXED.iter().filter(|row| row.needs == Needs::Curvature)
}

/// Checks that the run of every such method completes, and conserves K if the method claims to.
fn ends<S>(name: &str, system: &S, start: &State<Vec<f64>>, h: f64, steps: u64)
where
    S: Separable<f64> + Curvature<f64> + Clone + 'static,
{
    for row in solvers() {
        let run = separable(row, system.clone()).unwrap();
        finishes(name, row, system, &run, start, h, steps);
    }
}

fn finishes(
    name: &str,
    row: &Row,
    system: &Curved<f64>,
    run: &Run<f64>,
    start: &State<Vec<f64>>,
    h: f64,
    steps: u64,
) {
    let mut state = start.clone();
    let grid = Grid::of(h, steps).unwrap();
    if let Err(error) = run.run(grid, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(())) {
        panic!("{name}: {} with h = {h}: {error}", row.name);
    }
    let off = drift(system, h, start, &state);
    assert!(
        !row.keeps_k || off < 16.0 * (steps as f64).sqrt(),
        "{name}: {} with h = {h}: K is off by {off} roundings",
        row.name
    );
}

/// 200 masses, one of them displaced: far from it the chain is at rest, and the tails of the wave
/// underflow.
#[test]
fn a_chain_partly_at_rest() {
    let toda = Toda { n: 200, c: 0.05 };
    for push in [1.0, 1e-8, 1e-150] {
        let mut p = vec![0.0; 200];
        p[10] = push;
        let start = State::new(vec![0.0; 200], p).unwrap();
        for h in [0.4, 0.2, 0.1, 0.05] {
            ends("Toda", &toda, &start, h, 40);
        }
    }
}

/// The forces of neighbours cancel: each is a million times their sum.
#[test]
fn forces_that_cancel() {
    let n = 20;
    let chain = FputChain::new(n, 0.0, 0.3).unwrap();
    let stretched: Vec<f64> = (0..n).map(|j| 1e6 * (j + 1) as f64 + (j as f64).sin()).collect();
    let start = State::new(stretched, vec![0.0; n]).unwrap();
    for row in solvers() {
        for h in [0.05, 0.3, 2.0] {
            let run = separable(row, chain).unwrap();
            finishes("stretched", row, &chain, &run, &start, h, 30);
        }
    }
}

/// Friction that is saturated except within 0.003 of rest: its derivative at one point of a step
/// does not represent the step.
#[test]
fn saturated_friction() {
    for friction in ["0.2*tanh(p1/0.003)", "tanh(p1/0.003)", "0.2*tanh(p1/0.001)"] {
        let system = Custom::new(&Description {
            potential: "q1^2/2".into(),
            dissipation: DissipationText::Forces(vec![friction.into()]),
            ..Description::default()
        })
        .unwrap();
        let start = State::new(vec![2.0], vec![0.0]).unwrap();
        for row in solvers().filter(|row| row.name.starts_with("collocation")) {
            for h in [0.02, 0.1, 0.5, 1.0] {
                let run = separable(row, system.clone()).unwrap();
                finishes(friction, row, &system, &run, &start, h, (20.0 / h) as u64);
            }
        }
    }
}

/// A state at an equilibrium does not move, wherever the equilibrium is.
#[test]
fn at_rest() {
    let toda = Toda { n: 50, c: 0.1 };
    let start = State::new(vec![0.0; 50], vec![0.0; 50]).unwrap();
    for h in [0.1, 3.0] {
        ends("rest", &toda, &start, h, 3);
    }
}
