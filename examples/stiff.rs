//! Stiff systems at loose and tight tolerances: an overdamped oscillator, whose exact solution is
//! known, and a relaxation oscillation.
//! `cargo run --release --example stiff`

use afterbay_core::{Adaptive, State, Tolerance, integrate_within};
use afterbay_methods::{AdaptiveCollocation, AdaptiveRadau};
use afterbay_systems::{DampedOscillator, VanDerPol};
use std::error::Error;

/// q, p and w of q'' + b q' + q = 0 at t, from (1, 1), for b > 2.
fn overdamped(b: f64, t: f64) -> [f64; 3] {
    let fast = -(b / 2.0 + (b * b / 4.0 - 1.0).sqrt());
    let slow = 1.0 / fast;
    let share = (1.0 - slow) / (fast - slow);
    let [a, c] = [(1.0 - share) * (slow * t).exp(), share * (fast * t).exp()];
    let [q, p] = [a + c, slow * a + fast * c];
    [q, p, 1.0 - (q * q + p * p) / 2.0]
}

fn run<M: Adaptive<[f64; 1], DampedOscillator<f64>> + Adaptive<[f64; 1], VanDerPol<f64>>>(
    name: &str,
    method: &M,
) -> Result<(), Box<dyn Error>> {
    for tolerance in [1e-2, 1e-5, 1e-8] {
        let bound = Tolerance::all(tolerance);
        for b in [200.0, 5000.0] {
            let system = DampedOscillator::new(1.0, b)?;
            let mut state = State::new([1.0], [1.0])?;
            let done = integrate_within(method, &system, &bound, 10.0, &mut state, &mut ())?;
            let (found, exact) = ([state.q[0], state.p[0], state.w[0]], overdamped(b, 10.0));
            let [q, p, w] = [0, 1, 2].map(|k| (found[k] - exact[k]).abs());
            println!(
                "{name:20} b = {b:4} {tolerance:6.0e}: q {q:.0e} p {p:.0e} w {w:.0e}, {:5} steps, \
                 {:6} evaluations",
                done.accepted, done.effort.evaluations
            );
            if q.max(p).max(w) > tolerance || (state.total(&system) - 1.0).abs() > 1e-13 {
                return Err("the error is beyond the tolerance, or K is lost".into());
            }
        }
        let system = VanDerPol::new(1000.0)?;
        let mut state = State::new([2.0], [0.0])?;
        let done = integrate_within(method, &system, &bound, 2000.0, &mut state, &mut ())?;
        println!(
            "{name:20} μ = 1000 {tolerance:6.0e}: q = {:.9}, w = {:.9}, {:5} steps, \
             {:6} evaluations",
            state.q[0], state.w[0], done.accepted, done.effort.evaluations
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    run("adaptive-radau", &AdaptiveRadau)?;
    run("adaptive-collocation", &AdaptiveCollocation)
}
