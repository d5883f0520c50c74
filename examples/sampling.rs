//! States at given times: the decay of an oscillator, at times in equal ratios, written as CSV.
//! `cargo run --example sampling`

use afterbay_core::{State, Tolerance, sample_within};
use afterbay_methods::AdaptiveCollocation;
use afterbay_systems::DampedOscillator;
use std::error::Error;
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn Error>> {
    let (k, b) = (1.0, 0.02);
    let system = DampedOscillator::new(k, b)?;
    let mut state = State::new([1.0], [0.0])?;
    let before = state.total(&system);

    // Any times that ascend. The method chooses its own steps, which do not depend on them.
    let times: Vec<f64> = (0..=12).map(|i| 0.5 * 2.0_f64.powf(0.75 * f64::from(i))).collect();
    let mut seen = Vec::new();
    let tolerance = Tolerance::all(1e-10);
    let mut keep = |_, state: &State<[f64; 1]>| {
        seen.push(state.clone());
        ControlFlow::Continue(())
    };
    let method = AdaptiveCollocation;
    let statistics = sample_within(&method, &system, &tolerance, &times, &mut state, &mut keep)?;

    println!("t,q,p,w,H,K");
    let (mut drift, mut error) = (0.0_f64, 0.0_f64);
    for state in &seen {
        let (t, q, p, w) = (state.t, state.q[0], state.p[0], state.w[0]);
        let (h, total) = (state.energy(&system), state.total(&system));
        println!("{t:.4},{q:.9},{p:.9},{w:.9},{h:.9},{total:.9}");
        // The solution: q = e^{-bt/2} (cos ωt + b/(2ω) sin ωt), with ω² = k - b²/4.
        let omega = (k - b * b / 4.0).sqrt();
        let (sin, cos) = (omega * t).sin_cos();
        error = error.max(((-b * t / 2.0).exp() * (cos + b / (2.0 * omega) * sin) - q).abs());
        drift = drift.max((total - before).abs());
    }
    let steps = statistics.accepted;
    println!("{steps} steps; q is off by {error:.0e} at most, K by {drift:.0e}.");
    if seen.len() != times.len() || error > 1e-9 {
        return Err("the samples are not the solution".into());
    }
    if drift < 1e-13 { Ok(()) } else { Err("K is not kept".into()) }
}
