//! Motions in units in which p is far larger or far smaller than q: the steps of a tolerance do not
//! depend on them.

use crate::catalog::{As, written};
use afterbay_core::{State, StateRef, Tolerance};
use afterbay_methods::registry::{Setting, find};
use afterbay_systems::{Description, DissipationText};
use std::ops::ControlFlow;

/// A damped orbit around a centre. Returns the end and the number of steps.
fn orbit(name: &str, mass: f64, absolute: f64) -> ([f64; 4], u64) {
    let system = written(&Description {
        potential: format!("-{mass:e}/sqrt(q1^2 + q2^2)"),
        masses: vec![format!("{mass:e}"); 2],
        dissipation: DissipationText::Forces(vec![
            format!("{:e}*v1", 0.01 * mass),
            format!("{:e}*v2", 0.01 * mass),
        ]),
        ..Description::default()
    });
    let run = system.bind(find(name).unwrap(), As::Separable).expect("it applies");
    let mut state = State::new(vec![1.0, 0.0], vec![0.0, mass]).unwrap();
    let tolerance = Tolerance { absolute, w_absolute: absolute * mass, ..Tolerance::all(1e-9) };
    let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let setting = Setting::Tolerance(tolerance, 6.0);
    let done = run.run(setting, &mut state, 1, &mut show).expect("it runs");
    let [q, p] = [&state.q, &state.p];
    ([q[0], q[1], p[0] / mass, p[1] / mass], done.accepted)
}

#[test]
fn the_error_of_q_follows_from_that_of_p_in_all_units_of_mass() {
    for name in ["adaptive-collocation", "adaptive-radau", "adaptive-dop853", "adaptive-verner98"] {
        let (end, steps) = orbit(name, 1.0, 1e-12);
        for mass in [1e3, 1e24] {
            let (other, taken) = orbit(name, mass, 1e-12);
            let off = end.iter().zip(other).fold(0.0, |off: f64, (a, b)| off.max((a - b).abs()));
            assert!(off < 1e-8, "{name}, mass {mass:e}: {end:?}, {other:?}");
            assert!(taken <= steps + steps / 4, "{name}, mass {mass:e}: {steps} and {taken} steps");
        }
    }
}

/// The absolute tolerance bounds p only where p is small: q still has its own.
#[test]
fn a_coarse_tolerance_of_p_does_not_loosen_that_of_q() {
    let (end, _) = orbit("adaptive-collocation", 1.0, 1e-9);
    for mass in [1e-6, 1e-9] {
        let (other, _) = orbit("adaptive-collocation", mass, 1e-9);
        let off = (end[0] - other[0]).abs().max((end[1] - other[1]).abs());
        assert!(off < 1e-7, "mass {mass:e}: {end:?}, {other:?}");
    }
}
