//! K over runs in which w takes up many increments far below its rounding.

#![cfg(test)]

use afterbay_core::{
    Abilities, Corrected, Grid, InputError, Quad, Scalar, State, StateRef, System,
};
use afterbay_methods::registry::{FIXED, Row, Run, bind, compensated, find};
use afterbay_systems::{Duffing, FputChain};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The number of masses of the chain.
const N: usize = 4;

/// A system, and the same in 106 bits.
type Pair = (&'static str, Arc<dyn Abilities<f64>>, Arc<dyn Abilities<Quad>>);

/// Systems with friction of rate `c`.
fn systems(c: f64) -> [Pair; 2] {
    let duffing = Duffing::new(1.0, 1.0, c).unwrap();
    let chain = FputChain::new(N, 1.0, c).unwrap();
    [
        ("duffing", Arc::new(duffing), Arc::new(duffing.map(Quad::from))),
        ("chain", Arc::new(chain), Arc::new(chain.map(Quad::from))),
    ]
}

fn total(exact: &dyn Abilities<Quad>, StateRef { q, p, w, .. }: StateRef<'_, f64>) -> Quad {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
    State { q: lift(q), p: lift(p), w: lift(w), t: Quad::ZERO }.total(exact)
}

/// The largest |K - K0| of a run, of which some hundred states are looked at.
fn largest_drift(
    run: &Run<f64>,
    exact: &dyn Abilities<Quad>,
    grid: Grid<f64>,
    mut state: State<Vec<f64>>,
) -> f64 {
    let (initial, mut most) = (total(exact, state.state_ref()), 0.0_f64);
    let mut look = |_: u64, state: StateRef<'_, f64>| {
        most = most.max((total(exact, state) - initial).to_f64().abs());
        ControlFlow::Continue(())
    };
    run.run(grid, &mut state, grid.steps.div_ceil(200), &mut look).expect("a run");
    most
}

/// Every method that keeps K, apart from relaxation: near rest, where a step changes H by a
/// rounding, that finds no root.
fn methods() -> impl Iterator<Item = &'static Row> {
    FIXED.iter().filter(|row| row.keeps_k && !row.name.starts_with("relaxed"))
}

#[test]
fn w_takes_up_what_is_dissipated_near_rest() {
    // A step dissipates less than two roundings of w, and in the end none.
    let (size, grid) = (3e-7, Grid::new(0.1, 400.0).unwrap());
    for pair in &systems(0.05) {
        let n = pair.1.dof();
        let mut state = State::new(vec![size; n], vec![0.0; n]).unwrap();
        state.w = vec![1.0; n];
        // A step from p = 0 is at the pole of δ(q).
        for row in methods().filter(|row| row.poles().is_empty()) {
            let Ok(run) = bind(row, pair.1.clone()) else { continue };
            let most = largest_drift(&run, &*pair.2, grid, state.clone());
            // Each w_j is rounded once where it is shown.
            let bound = 1.01 * n as f64 * f64::EPSILON;
            assert!(most <= bound, "{} on {}: {most:e} of {bound:e}", row.name, pair.0);
        }
    }
}

/// The number of steps; a million takes minutes.
fn steps() -> u64 {
    let asked = std::env::var("AFTERBAY_LONG_STEPS").ok();
    asked.map_or(5000, |steps| steps.parse().expect("AFTERBAY_LONG_STEPS is a number of steps"))
}

#[test]
fn k_stays_over_many_steps() {
    for c in [1e-3, 1e-7] {
        for pair in &systems(c) {
            let n = pair.1.dof();
            let (q, p) = ((0..n).map(|j| 1.0 - 0.3 * j as f64).collect(), vec![0.5; n]);
            let start = State::new(q, p).unwrap();
            let size = total(&*pair.2, start.state_ref()).to_f64();
            for row in methods() {
                let Ok(run) = bind(row, pair.1.clone()) else { continue };
                let grid = Grid::of(0.1, steps()).unwrap();
                let most = largest_drift(&run, &*pair.2, grid, start.clone());
                println!("{} on {}, c = {c:e}: {:.1e}", row.name, pair.0, most / size);
                assert!(most <= 1e-12 * size, "{} on {}: {most:e}", row.name, pair.0);
            }
        }
    }
}

#[test]
fn a_compensated_run_differs_by_the_rounding_of_its_state() {
    let system = Duffing::new(1.0, 1.0, 1e-7).unwrap();
    let exact = system.map(Quad::from);
    let start = State::new(vec![1.0], vec![0.5]).unwrap();
    for name in ["moddg", "increment-2"] {
        let corrected = Arc::new(system.map(Corrected::from));
        let run = compensated::<f64>(find(name).unwrap(), Arc::new(system), corrected).unwrap();
        let grid = Grid::of(0.1, 20 * steps()).unwrap();
        let most = largest_drift(&run, &exact, grid, start.clone());
        println!("{name}, compensated: {most:.1e}");
        // |q V'| + p² + w is at most 4 on this orbit.
        assert!(most <= 4.0 * f64::EPSILON / 2.0, "{name}: {most:e}");
    }
}

#[test]
fn only_one_degree_of_freedom_is_a_compensated_moddg() {
    let chain = FputChain::new(N, 1.0, 0.1).unwrap();
    let corrected = Arc::new(chain.map(Corrected::from));
    let bound = compensated::<f64>(find("moddg").unwrap(), Arc::new(chain), corrected);
    assert!(matches!(bound, Err(InputError::Unsupported { method: "moddg", .. })));
}
