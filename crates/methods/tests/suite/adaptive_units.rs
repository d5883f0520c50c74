//! Motions in units in which p is far larger or far smaller than q: the steps of a tolerance do not
//! depend on them.

use crate::catalog::{As, written};
use crate::motors::Shaker;
use afterbay_core::{
    Abilities, Drive, Driven, State, StateRef, Statistics, Tolerance, with_motors,
};
use afterbay_methods::registry::{ADAPTIVE, Row, Setting, bind, find};
use afterbay_systems::{DampedOscillator, Description, DissipationText};
use std::ops::ControlFlow;
use std::sync::Arc;

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

/// A driven oscillator to the time 10 in a unit of time of 1/`unit`, with the tolerance 1e-8
/// relative to sizes near 1 in units of their own. Returns q at the end.
fn driven(row: &Row, unit: f64) -> (f64, Statistics) {
    let oscillator = DampedOscillator::new(1.0 / (unit * unit), 0.1 / unit).unwrap();
    let oscillator: Arc<dyn Abilities<f64>> = Arc::new(oscillator);
    let shaker = Shaker::of_first(0.3 / (unit * unit), 1.0 / unit);
    let system = Driven::<_, dyn Drive<f64>>::new(oscillator, Arc::new(shaker)).unwrap();
    let run = bind(row, Arc::new(system)).unwrap();
    let mut state = with_motors(&State::new(vec![0.5], vec![0.0]).unwrap(), 1);
    let absolute = 1e-8 / unit.max(1.0);
    let w_absolute = absolute / unit.max(1.0);
    let tolerance = Tolerance { absolute, w_absolute, ..Tolerance::all(1e-8) };
    let (setting, mut taken) = (Setting::Tolerance(tolerance, 10.0 * unit), 0);
    let mut show = |_: u64, _: StateRef<'_, f64>| {
        taken += 1;
        if taken < 2000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let done = run.run(setting, &mut state, 1, &mut show).unwrap();
    (state.q[0], done)
}

/// The time is the coordinate of a motor, and the energy supplied is its momentum. Neither is
/// measured by the tolerance of q or p.
#[test]
fn a_drive_costs_the_same_in_all_units_of_time() {
    for row in ADAPTIVE {
        let (end, steps) = driven(row, 1.0);
        for unit in [2_f64.powi(-43), 2_f64.powi(-20), 2_f64.powi(27), 2_f64.powi(43)] {
            let (other, taken) = driven(row, unit);
            assert!((end - other).abs() < 2e-7, "{} {unit:e}: {end} {other}", row.name);
            let (steps, taken) = (steps.accepted, taken.accepted);
            assert!(taken < 8 * steps, "{} {unit:e}: {steps} and {taken} steps", row.name);
        }
    }
}

/// D vanishes at the start, so that w is far below the roundings of H for a while.
#[test]
fn an_empty_reservoir_beside_a_large_energy_does_not_shorten_steps() {
    for row in ADAPTIVE {
        let ends = [1.0, 1e24].map(|mass| {
            let system = written(&Description {
                potential: format!("{mass:e}*q1^2/2"),
                masses: vec![format!("{mass:e}")],
                dissipation: DissipationText::Forces(vec![format!(
                    "{:e}*(1 - q1^2)*v1",
                    0.3 * mass
                )]),
                ..Description::default()
            });
            let run = system.bind(row, As::Curved).unwrap();
            let mut state = State::new(vec![1.0], vec![0.0]).unwrap();
            let mut taken = 0;
            let mut show = |_: u64, _: StateRef<'_, f64>| {
                taken += 1;
                if taken < 1000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            let setting = Setting::Tolerance(Tolerance::all(1e-8), 10.0);
            run.run(setting, &mut state, 1, &mut show).unwrap();
            (state.q[0], state.w[0] / mass)
        });
        let off = (ends[0].0 - ends[1].0).abs().max((ends[0].1 - ends[1].1).abs());
        assert!(off < 1e-6, "{}: {ends:?}", row.name);
    }
}

/// The steps over [0, 30] of two oscillators, a mass m on a spring m beside a mass 1 on a spring 1,
/// coupled by a spring m.
fn steps_beside(name: &str, m: f64) -> u64 {
    let system = written(&Description {
        potential: format!("{m:e}*(q1^2 + (q2 - q1)^2)/2 + q2^2/2 + q2^4/4"),
        masses: vec![format!("{m:e}"), "1".into()],
        dissipation: DissipationText::Forces(vec![format!("{:e}*v1", 0.1 * m), "0.1*v2".into()]),
        ..Description::default()
    });
    let run = system.bind(find(name).unwrap(), As::Separable).expect("it applies");
    let mut state = State::new(vec![1.0, 0.3], vec![0.0, 1.0]).unwrap();
    let setting = Setting::Tolerance(Tolerance::all(1e-6), 30.0);
    let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    run.run(setting, &mut state, 1, &mut show).expect("it runs").accepted
}

/// The limit of stability of explicit methods is that of the motion.
#[test]
fn a_light_mass_on_a_soft_spring_takes_no_more_steps() {
    for name in ["adaptive-dop853", "adaptive-verner98", "adaptive-verner87"] {
        let [alike, light] = [1.0, 1e-12].map(|m| steps_beside(name, m));
        assert!(light < 2 * alike, "{name}: {light} steps, and {alike} with equal masses");
    }
}
