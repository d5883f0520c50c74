//! K over runs in which w takes up many increments far below its rounding.

use afterbay_core::{
    Abilities, Corrected, Grid, InputError, Quad, Scalar, Separable, State, StateRef, System,
};
use afterbay_methods::registry::{FIXED, Row, Run, bind, compensated, find};
use afterbay_systems::{Duffing, FputChain};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The number of masses of the chain.
const N: usize = 4;

/// A system in f64, in 106 bits, and in corrected numbers.
struct Case {
    name: &'static str,
    system: Arc<dyn Abilities<f64>>,
    exact: Arc<dyn Abilities<Quad>>,
    corrected: Arc<dyn Separable<Corrected<f64>>>,
}

impl Case {
    /// K at the start of the long runs, where all terms of H are positive, and the state there.
    fn start(&self) -> (f64, State<Vec<f64>>) {
        let n = self.system.dof();
        let q = (0..n).map(|j| 1.0 - 0.3 * j as f64).collect();
        let start = State::new(q, vec![0.5; n]).unwrap();
        (total(&*self.exact, start.state_ref()).to_f64(), start)
    }
}

/// Systems with friction of rate `c`.
fn cases(c: f64) -> [Case; 2] {
    let duffing = Duffing::new(1.0, 1.0, c).unwrap();
    let chain = FputChain::new(N, 1.0, c).unwrap();
    [
        Case {
            name: "duffing",
            system: Arc::new(duffing),
            exact: Arc::new(duffing.map(Quad::from)),
            corrected: Arc::new(duffing.map(Corrected::from)),
        },
        Case {
            name: "chain",
            system: Arc::new(chain),
            exact: Arc::new(chain.map(Quad::from)),
            corrected: Arc::new(chain.map(Corrected::from)),
        },
    ]
}

fn total(exact: &dyn Abilities<Quad>, StateRef { q, p, w, .. }: StateRef<'_, f64>) -> Quad {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
    State { q: lift(q), p: lift(p), w: lift(w), t: Quad::ZERO }.total(exact)
}

/// K - K0 at one hundred to two hundred equally spaced times of a run.
fn drifts(
    run: &Run<f64>,
    exact: &dyn Abilities<Quad>,
    grid: Grid<f64>,
    mut state: State<Vec<f64>>,
) -> Vec<f64> {
    let (initial, mut drifts) = (total(exact, state.state_ref()), Vec::new());
    let mut look = |_: u64, state: StateRef<'_, f64>| {
        drifts.push((total(exact, state) - initial).to_f64());
        ControlFlow::Continue(())
    };
    run.run(grid, &mut state, grid.steps.div_ceil(200), &mut look).expect("a run");
    drifts
}

fn largest(drifts: &[f64]) -> f64 {
    drifts.iter().fold(0.0, |most, drift| most.max(drift.abs()))
}

/// The exponent with which differences of K grow with the time between them: 1/2 for independent
/// roundings, 1 for a bias. From the root mean squares of the differences between states 1 and 16
/// samples apart; NaN for a run of fewer.
fn growth(drifts: &[f64]) -> f64 {
    if drifts.len() <= 16 {
        return f64::NAN;
    }
    let mean_square = |apart: usize| {
        let pairs = drifts.iter().zip(&drifts[apart..]);
        let sum: f64 = pairs.map(|(before, after)| (after - before).powi(2)).sum();
        sum / (drifts.len() - apart) as f64
    };
    (mean_square(16) / mean_square(1)).ln() / (2.0 * 16_f64.ln())
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
    for Case { name, system, exact, .. } in cases(0.05) {
        let n = system.dof();
        let mut state = State::new(vec![size; n], vec![0.0; n]).unwrap();
        state.w = vec![1.0; n];
        // A step from p = 0 is at the pole of δ(q).
        for row in methods().filter(|row| row.poles().is_empty()) {
            let Ok(run) = bind(row, system.clone()) else { continue };
            let most = largest(&drifts(&run, &*exact, grid, state.clone()));
            // Each w_j is rounded once where it is shown.
            let bound = 1.01 * n as f64 * f64::EPSILON;
            assert!(most <= bound, "{} on {name}: {most:e} of {bound:e}", row.name);
        }
    }
}

/// The number of steps; a million takes minutes.
fn steps() -> u64 {
    let asked = std::env::var("AFTERBAY_LONG_STEPS").ok();
    asked.map_or(5000, |steps| steps.parse().expect("AFTERBAY_LONG_STEPS is a number of steps"))
}

/// These methods take 14 and 34 sweeps a step. In a million steps their independent roundings alone
/// change K by more than 1e-12 of K0.
const MANY_SWEEPS: [&str; 2] = ["increment-6", "increment-8"];

#[test]
fn k_stays_over_many_steps() {
    let grid = Grid::of(0.1, steps()).unwrap();
    let bound = if steps() < 100_000 { 1e-13 } else { 1e-12 };
    let mut beyond = Vec::new();
    for c in [1e-3, 1e-7] {
        for case in &cases(c) {
            let Case { system, exact, corrected, .. } = case;
            let (size, start) = case.start();
            let mut see = |what: String, run: Run<f64>, bound: f64| {
                let drifts = drifts(&run, &**exact, grid, start.clone());
                let (most, growth) = (largest(&drifts) / size, growth(&drifts));
                let found =
                    format!("{what} on {}, c = {c:e}: {most:.2e}, t^{growth:.2}", case.name);
                println!("{found}");
                if most > bound {
                    beyond.push(found);
                }
            };
            for row in methods() {
                let Ok(run) = bind(row, system.clone()) else { continue };
                let many = MANY_SWEEPS.contains(&row.name);
                see(row.name.to_owned(), run, if many { 2.0 * bound } else { bound });
                if many {
                    let run = compensated(row, system.clone(), corrected.clone()).unwrap();
                    see(format!("{}, compensated,", row.name), run, 1e-15);
                }
            }
        }
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
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
        let most = largest(&drifts(&run, &exact, grid, start.clone()));
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
