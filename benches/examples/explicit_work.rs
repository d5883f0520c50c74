//! Evaluations that methods need for an error of (q, p) at the end: those with step size control,
//! for several errors that their steps aim at, and the relaxed ones with fixed steps.
//!
//! `cargo run --release -p afterbay-benches --example explicit_work` prints for each problem,
//! method and target the fewest evaluations of a run with an error of at most 1e-4, 1e-8 and 1e-11,
//! among runs with tolerances four to a decade, and the share of rejected attempts in all of them.
//! Of the fixed steps it takes 5 to 20,000, each number larger by a twentieth than the one before.

use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Adaptive, Curvature, Effort, Grid, Series, State, StepControl, System, Tolerance, integrate,
    integrate_controlled,
};
use afterbay_methods::{
    AdaptiveCollocation, AdaptiveDop853, AdaptiveVerner87, AdaptiveVerner98, Relaxed,
};
use afterbay_systems::{
    DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, VanDerPol,
};
use std::f64::consts::PI;

/// The errors to be reached.
const ERRORS: [f64; 3] = [1e-4, 1e-8, 1e-11];
/// The safeties compared; the default is 0.2.
const TARGET_ERRORS: [f64; 3] = [0.1, 0.2, 0.4];

/// An initial state and the solution at the end.
struct Problem<'a, S> {
    name: &'a str,
    system: &'a S,
    start: State<Vec<f64>>,
    end: State<Vec<f64>>,
}

fn error(found: &State<Vec<f64>>, exact: &State<Vec<f64>>) -> f64 {
    let pairs = found.q.iter().zip(&exact.q).chain(found.p.iter().zip(&exact.p));
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// The fewest evaluations with which each error was reached.
struct Fewest([u64; 3]);

impl Fewest {
    fn see(&mut self, error: f64, evaluations: u64) {
        let reached = ERRORS.iter().zip(&mut self.0).filter(|(bound, _)| error <= **bound);
        reached.for_each(|(_, fewest)| *fewest = evaluations.min(*fewest));
    }

    fn columns(&self) -> String {
        let column = |&count: &u64| match count {
            u64::MAX => format!("{:>8}", "-"),
            count => format!("{count:8}"),
        };
        self.0.iter().map(column).collect()
    }
}

/// Prints a line for each target error.
fn lines<S, M>(problem: &Problem<'_, S>, name: &str, method: &M)
where
    S: Curvature<f64>,
    M: Adaptive<Vec<f64>, S>,
{
    for target_error in TARGET_ERRORS {
        let control = StepControl { target_error, ..StepControl::default() };
        let mut fewest = Fewest([u64::MAX; 3]);
        let (mut rejected, mut attempts) = (0, 0);
        for quarter in 4..=52 {
            let tolerance = Tolerance::all(10_f64.powf(-0.25 * f64::from(quarter)));
            let (mut state, system) = (problem.start.clone(), problem.system);
            let end = problem.end.t;
            let done =
                integrate_controlled(method, system, &tolerance, control, end, &mut state, &mut ());
            let Ok(done) = done else { continue };
            let Effort { evaluations, .. } = done.effort;
            fewest.see(error(&state, &problem.end), evaluations);
            rejected += done.rejected;
            attempts += done.rejected + done.accepted;
        }
        let (columns, share) = (fewest.columns(), 100.0 * rejected as f64 / attempts as f64);
        println!("{:24}{name:16}{target_error:6}{columns}{share:9.1} %", problem.name);
    }
}

/// Prints the line of a method with fixed steps.
fn line<S: Curvature<f64>>(problem: &Problem<'_, S>, name: &str, method: &Relaxed) {
    let (mut fewest, mut steps) = (Fewest([u64::MAX; 3]), 5_u64);
    while steps <= 20_000 {
        let mut state = problem.start.clone();
        let grid = Grid::of(problem.end.t / steps as f64, steps).expect("a grid");
        // Steps beyond the limit of stability fail.
        if let Ok(effort) = integrate(method, problem.system, grid, &mut state, &mut ()) {
            fewest.see(error(&state, &problem.end), effort.evaluations);
        }
        steps += (steps / 20).max(1);
    }
    println!("{:24}{name:16}{:6}{}", problem.name, "", fewest.columns());
}

fn all<S>(name: &str, system: &S, series: &impl System<Series<f64, 24>>, z: [&[f64]; 2], end: f64)
where
    S: Curvature<f64>,
{
    let start = State::new(z[0].to_vec(), z[1].to_vec()).expect("a state");
    let exact = trajectory::<_, _, 24>(series, &start, end, 1).expect("a series").pop();
    let problem = Problem { name, system, start, end: exact.expect("the end") };
    lines(&problem, "collocation", &AdaptiveCollocation);
    lines(&problem, "dop853", &AdaptiveDop853);
    lines(&problem, "verner98", &AdaptiveVerner98);
    lines(&problem, "verner87", &AdaptiveVerner87);
    line(&problem, "relaxed-dop853", &Relaxed::dop853());
    line(&problem, "relaxed-verner98", &Relaxed::verner98());
}

fn main() {
    let columns: String = ERRORS.iter().map(|error| format!("{error:8.0e}")).collect();
    println!("{:40}{:>6}{columns} {:>10}", "evaluations for the error", "target", "rejected");
    macro_rules! problem {
        ($name:literal, $system:expr, $q:expr, $p:expr, $end:expr) => {
            let system = $system.expect("parameters in their range");
            all($name, &system, &system.map(Series::constant), [&$q, &$p], $end);
        };
    }
    let wave = |n: usize| -> Vec<f64> {
        (1..=n).map(|i| (PI * i as f64 / (n + 1) as f64).sin()).collect()
    };
    problem!("damped oscillator", DampedOscillator::new(1.0, 0.1), [2.3], [-3.1], 100.0);
    problem!("Duffing", Duffing::new(-1.0, 1.0, 0.1), [1.5], [0.5], 50.0);
    problem!("Van der Pol", VanDerPol::new(1.0), [2.0], [0.0], 50.0);
    problem!("FPUT chain of 64", FputChain::new(64, 1.0, 0.01), wave(64), [0.0; 64], 100.0);
    problem!("Duffing, undamped", Duffing::new(-1.0, 1.0, 0.0), [1.5], [0.5], 200.0);
    problem!("Van der Pol, mu 5", VanDerPol::new(5.0), [2.0], [0.0], 30.0);
    problem!("modified Van der Pol", ModifiedVanDerPol::new(0.5, -1.0, 1.0), [1.0], [0.5], 40.0);
    problem!(
        "double pendulum",
        DampedDoublePendulum::new([1.0; 2], [1.0; 2], 1.0, [0.1; 2]),
        [1.5, -0.5],
        [0.0; 2],
        10.0
    );
}
