//! Methods with step size control where the roundings of slopes and of the time exceed what the
//! tolerance allows, and where a drive begins from rest.

use crate::bind::{Curved, erased};
use afterbay_core::{Driven, State, StateRef, Tolerance, with_motors};
use afterbay_methods::registry::{ADAPTIVE, Setting, find};
use afterbay_systems::{Custom, CustomDrive, Description, DissipationText, DriveDescription};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A custom system of one degree of freedom under a force.
fn driven(potential: &str, dissipation: &str, force: &str) -> Arc<Curved<f64>> {
    let forces = DriveDescription { forces: vec![force.into()], ..Default::default() };
    let (drive, _) = CustomDrive::new(&forces, 1).unwrap();
    let description = Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(vec![dissipation.into()]),
        ..Default::default()
    };
    Arc::new(Driven::new(Arc::new(Custom::new(&description).unwrap()), Arc::new(drive)).unwrap())
}

/// q and p at the end of a run from rest at q, the deviation of K, and the number of attempts.
fn end(
    method: &str,
    system: &Arc<Curved<f64>>,
    [q, tolerance, end]: [f64; 3],
) -> ([f64; 2], f64, u64) {
    let mut state = with_motors(&State::new(vec![q], vec![0.0]).unwrap(), 1);
    let total = state.total(&**system);
    let run = erased(find(method).unwrap(), system.clone()).unwrap();
    let setting = Setting::Tolerance(Tolerance::all(tolerance), end);
    let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let done = run
        .run(setting, &mut state, 1, &mut ignore)
        .unwrap_or_else(|error| panic!("{method} at {tolerance:e}: {error}"));
    let off = (state.total(&**system) - total).abs();
    ([state.q[0], state.p[0]], off, done.accepted + done.rejected)
}

/// On an oscillator under 20 cos 50 t the roundings of t change the force by ε t |F'|, 1e-10 at the
/// end, whatever the steps are. The motion there is the steady one, Re 20 e^{50it}/(5i - 2499).
#[test]
fn a_fast_drive_is_followed_for_a_long_time() {
    let (potential, friction) = ("q1^2/2", "0.1*v1");
    let system = driven(potential, friction, "20*cos(50*t)");
    let (sin, cos) = 50_000_f64.sin_cos();
    let size = 20.0 / (2499.0_f64.powi(2) + 25.0);
    let exact = [size * (5.0 * sin - 2499.0 * cos), 50.0 * size * (5.0 * cos + 2499.0 * sin)];
    for (method, tolerance) in [
        ("adaptive-verner87", 1e-7),
        ("adaptive-verner98", 1e-8),
        ("adaptive-dop853", 1e-12),
        ("adaptive-radau", 1e-12),
    ] {
        let (found, drift, attempts) = end(method, &system, [1.0, tolerance, 1000.0]);
        let error = (found[0] - exact[0]).abs().max((found[1] - exact[1]).abs());
        assert!(error < 10.0 * tolerance + 1e-10, "{method}: {error:e}");
        assert!(drift < 1e-10, "{method}: K {drift:e}");
        assert!(attempts < 800_000, "{method}: {attempts}");
    }
}

/// The force is no part of V, and the motion begins at rest. It ends at rest, at q = 1000.
#[test]
fn a_large_constant_force_takes_few_steps() {
    let system = driven("q1^2/2", "0.1*v1", "1000");
    for row in ADAPTIVE {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let (found, drift, attempts) = end(row.name, &system, [0.0, tolerance, 1000.0]);
            let exact = [1000.0, 0.0];
            let error = (found[0] - exact[0]).abs().max((found[1] - exact[1]).abs());
            assert!(error < 1e4 * tolerance + 1e-9, "{} {tolerance:e}: {error:e}", row.name);
            assert!(drift < 1e-6, "{} {tolerance:e}: K {drift:e} of 1e6", row.name);
            assert!(attempts < 100_000, "{} {tolerance:e}: {attempts}", row.name);
        }
    }
}

/// The force and its slope are 0 at the start. A free mass moves by t²/2 + cos t - 1.
#[test]
fn a_force_that_begins_as_t_squared_is_followed() {
    let (free, bound) =
        (driven("0", "0", "1 - cos(t)"), driven("(q1 - 5)^2/2", "0.1*v1", "1 - cos(t)"));
    let (sin, cos) = 40_f64.sin_cos();
    for row in ADAPTIVE {
        for tolerance in [1e-5, 1e-7, 1e-9] {
            let label = format!("{} {tolerance:e}", row.name);
            let (found, ..) = end(row.name, &free, [1000.0, tolerance, 40.0]);
            let exact = [1000.0 + 800.0 + cos - 1.0, 40.0 - sin];
            let error = [0, 1].map(|i| (found[i] - exact[i]).abs() / exact[i]);
            assert!(error.iter().all(|&error| error < 10.0 * tolerance), "{label}: {error:?}");
            let (found, drift, _) = end(row.name, &bound, [5.0, tolerance, 40.0]);
            let exact = -0.317_698_794_654_6;
            assert!((found[0] - exact).abs() < 50.0 * tolerance, "{label}: {}", found[0]);
            assert!(drift < 1e-11, "{label}: K {drift:e}");
        }
    }
}

/// As before, at the origin, where H is 0 to the last digit: cos t is first below 1 at t = 1.05e-8.
#[test]
fn a_force_that_begins_by_a_rounding_is_followed() {
    for force in ["1 - cos(t)", "0.1*(1 - cos(2*t))", "10*(1 - cos(3*t))"] {
        let system = driven("q1^2/2", "0.1*v1", force);
        let (exact, ..) = end("adaptive-collocation", &system, [0.0, 1e-12, 20.0]);
        for row in ADAPTIVE {
            for tolerance in [1e-5, 1e-7, 1e-9] {
                let label = format!("{force} {} {tolerance:e}", row.name);
                let (found, drift, _) = end(row.name, &system, [0.0, tolerance, 20.0]);
                let error = [0, 1].map(|i| (found[i] - exact[i]).abs());
                assert!(error.iter().all(|&error| error < 50.0 * tolerance), "{label}: {error:?}");
                assert!(drift < 1e-11, "{label}: K {drift:e}");
            }
        }
    }
}

/// V is 0 at the start of a throw, and q too, whose tolerance is far below the roundings of p.
#[test]
fn a_throw_from_the_origin_is_followed() {
    let description = Description {
        potential: "9.81*q2".into(),
        dissipation: DissipationText::Forces(
            ["1e-5*v1*sqrt(v1^2 + v2^2)", "1e-5*v2*sqrt(v1^2 + v2^2)"].map(String::from).into(),
        ),
        ..Default::default()
    };
    let system: Arc<Curved<f64>> = Arc::new(Custom::new(&description).unwrap());
    let setting = Setting::Tolerance(Tolerance::all(1e-12), 80.0);
    let ends = ADAPTIVE.iter().map(|row| {
        let mut state = State::new(vec![0.0; 2], vec![300.0, 400.0]).unwrap();
        let run = erased(row, system.clone()).unwrap();
        let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        run.run(setting, &mut state, 1, &mut ignore)
            .unwrap_or_else(|error| panic!("{}: {error}", row.name));
        state
    });
    let ends: Vec<_> = ends.collect();
    for (row, found) in ADAPTIVE.iter().zip(&ends) {
        let off = found.q.iter().zip(&ends[0].q).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-7, "{}: {off:e}", row.name);
    }
}

/// Samples between the steps do not change the run, although their estimates are roundings too.
#[test]
fn samples_do_not_change_a_run_of_roundings() {
    let system = driven("q1^2/2", "0.1*v1", "20*cos(50*t)");
    let times: Vec<f64> = (0..=50).map(|i| 95.0 + 0.1 * f64::from(i)).collect();
    for method in ["adaptive-verner87", "adaptive-verner98", "adaptive-dop853"] {
        let run = erased(find(method).unwrap(), system.clone()).unwrap();
        let start = with_motors(&State::new(vec![1.0], vec![0.0]).unwrap(), 1);
        let (all, mut ignore) =
            (Tolerance::all(1e-11), |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(()));
        let (mut sampled, mut plain) = (start.clone(), start);
        run.sample(&all, &times, &mut sampled, &mut ignore, &mut || false).unwrap();
        run.run(Setting::Tolerance(all, 100.0), &mut plain, 1, &mut ignore).unwrap();
        assert_eq!(sampled, plain, "{method}");
    }
}

/// ∂F/∂t is infinite at the start, which bounds no rounding of the later steps.
#[test]
fn a_force_that_begins_as_a_root_is_supplied_rightly() {
    let system = driven("q1^2/2", "0.1*v1", "sqrt(t)");
    let supplied = |method: &str, tolerance: f64| {
        let mut state = with_motors(&State::new(vec![1.0], vec![0.0]).unwrap(), 1);
        let run = erased(find(method).unwrap(), system.clone()).unwrap();
        let setting = Setting::Tolerance(Tolerance::all(tolerance), 11.0);
        let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        run.run(setting, &mut state, 1, &mut ignore).unwrap();
        state.p[1]
    };
    let exact = supplied("adaptive-collocation", 1e-12);
    for row in ADAPTIVE {
        let off = (supplied(row.name, 1e-9) - exact).abs();
        assert!(off < 1e-7, "{}: {off:e}", row.name);
    }
}
