//! `adaptive-radau` on stiff systems: q, p and w at the end are right at loose tolerances too.

use crate::bind::{Curved, erased};
use crate::catalog::{chain, oscillator, pendulum, van_der_pol};
use afterbay_core::{Passive, State, StateRef, Statistics, Tolerance};
use afterbay_methods::registry::{ADAPTIVE, Row, Setting};
use std::ops::ControlFlow;
use std::sync::Arc;

fn radau() -> &'static Row {
    ADAPTIVE.iter().find(|row| row.name == "adaptive-radau").unwrap()
}

/// The end of a run, with K kept and no reservoir of a passive system drained in any step.
fn run(
    system: &Arc<Curved<f64>>,
    start: &State<Vec<f64>>,
    end: f64,
    tolerance: f64,
) -> (State<Vec<f64>>, Statistics) {
    let (mut state, mut w) = (start.clone(), start.w.clone());
    let passive = system.dissipation_form().passive;
    let (k, mut largest) = (start.total(&**system), 0.0_f64);
    let done = erased(radau(), system.clone())
        .unwrap()
        .run(Setting::Tolerance(Tolerance::all(tolerance), end), &mut state, 1, &mut |_, state| {
            assert!(!passive.violated(&w, state.w), "{tolerance:e}: w falls at {}", state.t);
            w = state.w.to_vec();
            largest = largest.max(state.energy(&**system).abs() + state.reservoir().abs());
            assert!(
                (state.total(&**system) - k).abs() <= 1e-13 * largest.max(1.0),
                "{tolerance:e}: K at {}",
                state.t
            );
            ControlFlow::Continue(())
        })
        .unwrap();
    (state, done)
}

/// The exact solution of q'' + b q' + q = 0 for b > 2: q, p, and the energy dissipated since (1,
/// 1).
fn overdamped(b: f64, t: f64) -> [f64; 3] {
    let root = (b * b / 4.0 - 1.0).sqrt();
    let fast = -(b / 2.0 + root);
    let slow = 1.0 / fast;
    let share = (1.0 - slow) / (fast - slow);
    let [a, c] = [(1.0 - share) * (slow * t).exp(), share * (fast * t).exp()];
    let [q, p] = [a + c, slow * a + fast * c];
    [q, p, 1.0 - (q * q + p * p) / 2.0]
}

#[test]
fn overdamped_oscillators_are_right_in_q_p_and_w() {
    for (b, end) in [(200.0, 10.0), (200.0, 0.1), (5000.0, 10.0), (5000.0, 1000.0)] {
        let system = oscillator(1.0, b).curved();
        let start = State::new(vec![1.0], vec![1.0]).unwrap();
        let exact = overdamped(b, end);
        for digits in 2..=10 {
            let tolerance = 10f64.powi(-digits);
            let (state, done) = run(&system, &start, end, tolerance);
            let found = [state.q[0], state.p[0], state.w[0]];
            let errors = [0, 1, 2].map(|k| (found[k] - exact[k]).abs());
            println!("b = {b}, T = {end}, {tolerance:e}: {errors:?}, {}", done.accepted);
            let bound = tolerance + 1e-13;
            assert!(errors.iter().all(|&error| error < bound), "{b} {tolerance:e}: {errors:?}");
            assert!(done.accepted < 100, "{b} {tolerance:e}: {done:?}");
        }
    }
}

/// Two coordinates that relax, in a system that is not separable and strongly damped.
#[test]
fn a_strongly_damped_double_pendulum_is_right_in_q_p_and_w() {
    let system = pendulum([1.0; 2], [1.0; 2], 9.81, [1e3, 1e4]).curved();
    let start = State::new(vec![1.5, -0.5], vec![2.0, -1.0]).unwrap();
    agrees(&system, &start, 50.0, 400);
}

/// Friction is far stiffer than the springs, and linear in a row: Thomas' algorithm.
#[test]
fn a_chain_with_strong_friction_is_right_in_q_p_and_w() {
    let n = 200;
    let q = (1..=n).map(|i| (std::f64::consts::PI * f64::from(i) / 201.0).sin()).collect();
    let system = chain(200, 1.0, 1e4).curved();
    assert_eq!(system.dissipation_form().passive, Passive::Each);
    agrees(&system, &State::new(q, vec![1.0; 200]).unwrap(), 100.0, 100);
}

/// The runs at loose tolerances agree with those at 1e-12, in few steps.
fn agrees(system: &Arc<Curved<f64>>, start: &State<Vec<f64>>, end: f64, most: u64) {
    let (exact, _) = run(system, start, end, 1e-12);
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
        let (state, done) = run(system, start, end, tolerance);
        for (found, exact) in [(&state.q, &exact.q), (&state.p, &exact.p), (&state.w, &exact.w)] {
            let size = exact.iter().fold(1.0, |size: f64, x| size.max(1.0 + x.abs()));
            let far = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(far < 10.0 * tolerance * size, "{tolerance:e}: {far:e}");
        }
        assert!(done.accepted < most, "{tolerance:e}: {done:?}");
    }
}

/// Three half periods for μ up to 1e5, whose jumps take a small part of a period. At the end w = K
/// - H of the slow part, whatever w has been in the jumps: 1e6 and more.
#[test]
fn relaxation_oscillations_are_right_in_q_p_and_w() {
    for mu in [1e3, 1e4, 1e5] {
        let system = van_der_pol(mu).curved();
        let start = State::new(vec![2.0], vec![0.0]).unwrap();
        let (exact, _) = run(&system, &start, 2.5 * mu, 1e-12);
        for tolerance in [1e-4, 1e-6, 1e-8] {
            let (state, done) = run(&system, &start, 2.5 * mu, tolerance);
            let errors = [
                (state.q[0] - exact.q[0]).abs(),
                (state.p[0] - exact.p[0]).abs(),
                (state.w[0] - exact.w[0]).abs(),
            ];
            println!("μ = {mu:e}, {tolerance:e}: {errors:?}, {}", done.accepted);
            // H and w reach μ² in a jump.
            let rounding = 64.0 * f64::EPSILON * mu * mu;
            assert!(errors[0].max(errors[1]) < 10.0 * tolerance + rounding, "{mu}: {errors:?}");
            assert!(errors[2] < 20.0 * tolerance + rounding, "{mu}: {errors:?}");
            assert!(done.accepted < 1000, "{mu}: {done:?}");
        }
    }
}

/// The momentum of an overdamped oscillator is far below its start for nearly all of a long run,
/// and so is its rounding. Sweeps that stop above it leave an error that only short steps reduce.
#[test]
fn long_runs_of_overdamped_oscillators_take_few_steps() {
    let implicit = ["adaptive-collocation", "adaptive-radau"];
    for row in ADAPTIVE.iter().filter(|row| implicit.contains(&row.name)) {
        for (b, end) in [(1e5, 1e6), (1e6, 1e7)] {
            let system = oscillator(1.0, b).curved();
            let mut state = State::new(vec![0.1], vec![5.0]).unwrap();
            let mut steps = 0;
            let mut count = |_: u64, _: StateRef<'_, f64>| {
                steps += 1;
                if steps < 20_000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            let setting = Setting::Tolerance(Tolerance::all(1e-8), end);
            let ended = erased(row, system).unwrap().run(setting, &mut state, 1, &mut count);
            assert!(ended.is_ok() && steps < 20_000, "{}, b = {b}: {ended:?}", row.name);
            // Less than the start by what the fast mode takes: q = q0 + p0/b, then e^(-t/b).
            let exact = (0.1 + 5.0 / b) * (-end / b).exp();
            assert!((state.q[0] - exact).abs() < 1e-8, "{}, b = {b}: {state:?}", row.name);
        }
    }
}
