//! Ten million steps of a chain of 8 without friction: the growth of |K - K0| with t, plain and
//! compensated, and the cost of compensation. Also a million steps of the Van der Pol oscillator on
//! its limit cycle. `-- 1000000 2` sets the number of steps and of initial states.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::{
    Problem,
    long_run::{self, LongRun, Setup},
};
use afterbay_core::{Corrected, Grid, Method, State, integrate};
use afterbay_methods::{Composition, Increment, registry};
use afterbay_systems::{FPUT_CHAIN, FputChain, VAN_DER_POL};
use std::f64::consts::PI;
use std::time::Instant;

/// The name, the step size, and whether rounding is compensated.
const RUNS: [(&str, f64, bool); 6] = [
    ("increment-2", 0.05, false),
    ("increment-2", 0.1, false),
    ("increment-2", 0.2, false),
    ("increment-4", 0.1, false),
    ("increment-2", 0.1, true),
    ("increment-2", 0.2, true),
];
const STARTS: u64 = 4;

fn main() {
    // `cargo test` also runs benches, without this argument; a short run then checks that they
    // work.
    let full = std::env::args().any(|argument| argument == "--bench");
    let mut asked = std::env::args().filter_map(|argument| argument.parse().ok());
    let steps = asked.next().unwrap_or(if full { 10_000_000 } else { 10_000 });
    let starts: Vec<_> = (0..asked.next().unwrap_or(STARTS)).map(start).collect();
    let setup = |(name, h, compensated): (&str, f64, bool)| {
        registry::find(name).map(|row| Setup { row, h, compensated })
    };
    let setups: Vec<_> = RUNS.into_iter().filter_map(setup).collect();
    println!(
        "the chain: (K - K0)/E, E the largest energy, over {steps} steps, {} starts",
        starts.len()
    );
    table(&long_run::run(&starts, &setups, steps, &Silent).expect("the input is in range"));
    let cycle =
        Problem { model: Model::of(&VAN_DER_POL, &[1.0]), q: vec![2.0], p: vec![0.0], end: 0.0 };
    let setups: Vec<_> =
        [false, true].into_iter().filter_map(|how| setup(("increment-2", 0.1, how))).collect();
    println!("Van der Pol, μ = 1, on the limit cycle: the same over {} steps", steps / 10);
    table(&long_run::run(&[cycle], &setups, steps / 10, &Silent).expect("the input is in range"));
    cost(if full { 500 } else { 5 });
}

fn table(found: &[LongRun]) {
    println!(
        "{:36} {:>10}   exponent of t (95 %)   rms at 1e4, 1e5, ... steps; mean at the end",
        "", "outcome"
    );
    for run in found {
        let growth = run.growth().map_or_else(String::new, |fit| {
            format!("{:.2} ± {:.2}", fit.slope, fit.margin.unwrap_or(f64::NAN))
        });
        let decades = run.rows.iter().filter(|row| {
            let decade = (row.steps as f64).log10();
            decade >= 4.0 && decade.fract() == 0.0
        });
        let rms: Vec<_> = decades.map(|row| format!("{:.1e}", row.rms)).collect();
        let mean = run.rows.last().map_or(f64::NAN, |row| row.mean);
        println!(
            "{:36} {:>10}   {growth:>14}   {}; {mean:.1e}",
            run.setup.label(),
            run.ending.outcome,
            rms.join(" ")
        );
    }
}

/// Prints the time of a step of increment-2 on the chain, plain and compensated: the minimum over
/// `rounds` short rounds, taken in turn.
fn cost(rounds: u32) {
    let steps = 500;
    let Problem { q, .. } = start(0);
    for c in [0.0, 0.1] {
        let system = FputChain::new(q.len(), 1.0, c).expect("the parameters are in range");
        let plain = Increment::new(Composition::pair());
        let compensated = plain.clone().compensated(system.map(Corrected::from));
        let mut best = [f64::INFINITY; 2];
        for _ in 0..rounds {
            let times = [time(&plain, &system, &q, steps), time(&compensated, &system, &q, steps)];
            best = [0, 1].map(|i| best[i].min(times[i]));
        }
        let [plain, compensated] = best.map(|time| time * 1e9 / (steps * q.len() as u64) as f64);
        println!(
            "c = {c}: {plain:.0} ns a step and mass, compensated {compensated:.0} ns, \
             {:.1} times as much",
            compensated / plain
        );
    }
}

/// The time of a run in seconds.
fn time(
    method: &impl Method<[f64; 8], FputChain<f64>>,
    system: &FputChain<f64>,
    q: &[f64],
    steps: u64,
) -> f64 {
    let mut state =
        State::new(std::array::from_fn(|j| q[j]), [0.0; 8]).expect("the start is finite");
    let begin = Instant::now();
    integrate(method, system, Grid { h: 0.1, steps }, &mut state, &mut ())
        .expect("the chain is bounded");
    begin.elapsed().as_secs_f64()
}

/// The chain at rest, displaced by a sine with amplitude 1 or slightly more.
fn start(i: u64) -> Problem {
    let n = 8;
    let amplitude = 1.0 + i as f64 / 1024.0;
    let q = (1..=n).map(|j| amplitude * (PI * j as f64 / (n + 1) as f64).sin()).collect();
    Problem { model: Model::of(&FPUT_CHAIN, &[n as f64, 1.0, 0.0]), q, p: vec![0.0; n], end: 0.0 }
}
