//! Ten million steps of a chain of 8 without friction: how |K - K0| grows with t.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::{Problem, long_run};
use afterbay_methods::registry;
use std::f64::consts::PI;

const RUNS: [(&str, f64); 4] =
    [("increment-2", 0.05), ("increment-2", 0.1), ("increment-2", 0.2), ("increment-4", 0.1)];
const STARTS: u32 = 4;

fn main() {
    // `cargo test` runs benches too, without this argument: a short run is enough to see that they work.
    let full = std::env::args().any(|argument| argument == "--bench");
    let steps = if full { 10_000_000 } else { 10_000 };
    let starts: Vec<_> = (0..STARTS).map(start).collect();
    let runs: Vec<_> =
        RUNS.iter().filter_map(|&(name, h)| registry::find(name).map(|row| (row, h))).collect();
    let found = long_run::run(&starts, &runs, steps, &Silent).expect("the input is in range");
    println!("(K - K0)/K0 over {steps} steps, {STARTS} starts");
    println!(
        "{:12} {:>5} {:>10}   exponent of t (95 %)   rms at 1e4, 1e5, ... steps; mean at the end",
        "", "h", "outcome"
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
            "{:12} {:5} {:>10}   {growth:>14}   {}; {mean:.1e}",
            run.method,
            run.h,
            run.outcome,
            rms.join(" ")
        );
    }
}

/// At rest as a sine of the amplitude 1 or a little more.
fn start(i: u32) -> Problem {
    let n = 8;
    let amplitude = 1.0 + f64::from(i) / 1024.0;
    let q = (1..=n).map(|j| amplitude * (PI * j as f64 / (n + 1) as f64).sin()).collect();
    Problem { model: Model::FputChain { n, beta: 1.0, c: 0.0 }, q, p: vec![0.0; n], end: 0.0 }
}
