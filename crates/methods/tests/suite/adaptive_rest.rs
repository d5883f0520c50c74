//! Damped motions that come to rest and go on, where H is a difference of larger terms.

use crate::adaptive_accuracy::described;
use crate::bind::erased;
use crate::many::start;
use afterbay_core::{StateRef, Tolerance};
use afterbay_methods::registry::{ADAPTIVE, Row, Setting, find};
use std::ops::ControlFlow;

/// H is a rounding of its terms, and no change of (q, p) of the size of the motion takes K back to
/// its value. The roundings of ∇H do not show that it is another gradient.
#[test]
fn a_motion_that_rests_goes_on() {
    for potential in [
        "exp(q1) - q1 - 1",
        "tan(q1) - q1 + q1^2/2",
        "(1 + q1)^1.5 - 1.5*q1 - 1",
        "1/(1 + q1) + q1 - 1",
        "(exp(q1 - q2) - (q1 - q2) - 1) + q1^2/2",
    ] {
        let coupled = potential.contains("q2");
        let friction: &[&str] = if coupled { &["0.3*v1", "0.3*v2"] } else { &["0.3*v1"] };
        let from: [&[f64]; 2] = if coupled { [&[0.4, 0.1], &[0.0; 2]] } else { [&[0.4], &[0.0]] };
        let system = described(potential, friction).curved();
        for row in ADAPTIVE {
            for tolerance in [1e-4, 1e-7] {
                let mut state = start(from);
                let total = state.total(&*system);
                let run = erased(row, system.clone()).unwrap();
                let setting = Setting::Tolerance(Tolerance::all(tolerance), 1000.0);
                let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
                let done = run.run(setting, &mut state, 1, &mut ignore);
                let name = format!("{} at {tolerance:e}: {potential}", row.name);
                let done = done.unwrap_or_else(|error| panic!("{name}: {error}"));
                let drift = (state.total(&*system) - total).abs();
                assert!(drift < 1e-12, "{name}: K {drift:e}");
                let left =
                    state.q.iter().chain(&state.p).fold(0.0_f64, |most, z| most.max(z.abs()));
                assert!(left < tolerance, "{name}: {left:e}");
                let attempts = done.accepted + done.rejected;
                assert!(attempts < 40_000, "{name}: {attempts}");
            }
        }
    }
}

/// The state at the end of a run, and the change of K.
fn run(potential: &str, row: &'static Row, setting: Setting<f64>, from: [f64; 2]) -> [f64; 3] {
    let system = described(potential, &["0.1*v1"]).curved();
    let mut state = start([&from[..1], &from[1..]]);
    let total = state.total(&*system);
    let run = erased(row, system.clone()).unwrap();
    let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let done = run.run(setting, &mut state, 1, &mut ignore);
    done.unwrap_or_else(|error| panic!("{} on {potential}: {error}", row.name));
    [state.q[0], state.p[0], state.total(&*system) - total]
}

/// A small change of K needs a large move of (q, p) where ∇H is small. A method that restores K to
/// the roundings of |H|, which are below those of the terms of H, would keep the motion going.
#[test]
fn roundings_of_h_do_not_keep_a_motion_from_rest() {
    let spring = "q1^2/2 - 2*q1 + 2";
    for row in ["adaptive-collocation", "adaptive-radau"].map(|name| find(name).unwrap()) {
        for speed in [0.5, 0.01] {
            for end in [100.0, 300.0, 800.0] {
                let setting = Setting::Tolerance(Tolerance::all(1e-11), end);
                let [q, p, drift] = run(spring, row, setting, [2.0, speed]);
                // x'' + x'/10 + x = 0 for x = q - 2
                let (decay, omega) = ((-0.05 * end).exp(), 0.9975_f64.sqrt());
                let (sin, cos) = (omega * end).sin_cos();
                let exact = speed * decay * sin / omega;
                let slope = speed * decay * (cos - 0.05 * sin / omega);
                let error = (q - 2.0 - exact).abs().max((p - slope).abs());
                assert!(error < 2e-11, "{} at t = {end} from {speed}: {error:e}", row.name);
                assert!(drift.abs() < 1e-13, "{}: K {drift:e}", row.name);
            }
        }
    }
}
