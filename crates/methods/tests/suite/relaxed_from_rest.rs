//! Relaxation on the first motion of a system at rest, which a drive begins within a step.

use afterbay_core::{Abilities, Drive, Driven, Grid, State, StateRef, with_motors};
use afterbay_methods::registry::{bind, find};
use afterbay_systems::{Custom, CustomDrive, Description, DissipationText, DriveDescription};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A damped nonlinear pair at rest at t = 0, the first one pushed by a force.
fn pair(force: &str) -> Arc<dyn Abilities<f64>> {
    let description = Description {
        potential: "q1^2/2 + q2^4/4 + (q1 - q2)^2/2".into(),
        dissipation: DissipationText::Forces(vec!["0.1*v1".into(), "0.2*v2^3".into()]),
        ..Description::default()
    };
    let system: Arc<dyn Abilities<f64>> = Arc::new(Custom::new(&description).unwrap());
    let forces = DriveDescription { forces: vec![force.into(), "0".into()], ..Default::default() };
    let (drive, _) = CustomDrive::new(&forces, 2).unwrap();
    let drive: Arc<dyn Drive<f64>> = Arc::new(drive);
    Arc::new(Driven::new(system, drive).unwrap())
}

/// (q, p) at t = 4, and the largest deviation of K. Checks that no step fails.
fn end(method: &str, system: &Arc<dyn Abilities<f64>>, steps: u64) -> ([f64; 4], f64) {
    let run = bind(find(method).unwrap(), system.clone()).unwrap();
    let mut state = with_motors(&State::new(vec![0.0; 2], vec![0.0; 2]).unwrap(), 1);
    let mut drift = 0.0_f64;
    run.run(Grid::of(4.0 / steps as f64, steps).unwrap(), &mut state, 1, &mut |_, state| {
        drift = drift.max(state.total(&**system).abs());
        ControlFlow::Continue(())
    })
    .unwrap_or_else(|error| panic!("{method}, {steps} steps: {error}"));
    ([state.q[0], state.q[1], state.p[0], state.p[1]], drift)
}

fn distance(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// 2 is a grid point but for roundings, so that the force begins in the last stage of a step.
#[test]
fn a_force_that_begins_at_a_grid_point_is_followed() {
    for force in ["max(t - 2, 0)", "max(t - 2, 0)^3", "t^5/100"] {
        let system = pair(force);
        let (exact, _) = end("rk4", &system, 16_000);
        for steps in [20, 40, 60, 80, 140, 400] {
            let (plain, _) = end("rk4", &system, steps);
            let h = 4.0 / steps as f64;
            let most = 3.0 * distance(plain, exact) + 0.01 * h.powi(3);
            for method in ["relaxed-rk4", "relaxed-dop853", "relaxed-verner98"] {
                let (found, drift) = end(method, &system, steps);
                let error = distance(found, exact);
                assert!(drift < 1e-12, "{force}, {method}, {steps} steps: K {drift:e}");
                assert!(error < most, "{force}, {method}, {steps} steps: {error:e}");
            }
        }
    }
}

/// The energy of the motion begins as t⁴, and the first steps leave K off by h⁵: (q, p) is moved by
/// h³ to restore it.
#[test]
fn a_ramp_from_rest_has_order_three_and_a_switch_order_four() {
    for (force, expected) in [("max(t - 2, 0)", 3.0), ("1", 4.0)] {
        let system = pair(force);
        let (exact, _) = end("rk4", &system, 64_000);
        let error = |steps| distance(end("relaxed-rk4", &system, steps).0, exact);
        let order = (error(1000) / error(2000)).log2();
        assert!((order - expected).abs() < 0.1, "{force}: {order}");
    }
}

/// The momentum of a heavy mass is far larger than its energy, and a constant in V far larger than
/// that. K is kept to the rounding of the largest term of H.
#[test]
fn neither_a_heavy_mass_nor_a_constant_hides_the_motion() {
    for (potential, mass, force, h_rounding) in [
        ("q1^2/2", "1e12", "1e6*max(t - 2, 0)", 1e-12),
        ("1e6 + q1^2/2", "1", "max(t - 2, 0)", 1e-8),
    ] {
        let description = Description {
            potential: potential.into(),
            dissipation: DissipationText::Forces(vec!["0.1*v1".into()]),
            masses: vec![mass.into()],
            ..Description::default()
        };
        let system: Arc<dyn Abilities<f64>> = Arc::new(Custom::new(&description).unwrap());
        let forces = DriveDescription { forces: vec![force.into()], ..Default::default() };
        let (drive, _) = CustomDrive::new(&forces, 1).unwrap();
        let drive: Arc<dyn Drive<f64>> = Arc::new(drive);
        let system: Arc<dyn Abilities<f64>> = Arc::new(Driven::new(system, drive).unwrap());
        let run = |method: &str| {
            let run = bind(find(method).unwrap(), system.clone()).unwrap();
            let mut state = with_motors(&State::new(vec![0.0], vec![0.0]).unwrap(), 1);
            let total = state.total(&*system);
            let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            run.run(Grid::of(0.1, 40).unwrap(), &mut state, 1, &mut ignore)
                .unwrap_or_else(|error| panic!("{method}, {potential}: {error}"));
            (state.q[0], (state.total(&*system) - total).abs())
        };
        let (exact, _) = run("rk4");
        for method in ["relaxed-rk4", "relaxed-dop853", "relaxed-verner98"] {
            let (found, drift) = run(method);
            assert!((found / exact - 1.0).abs() < 1e-3, "{method}, {potential}: {found} {exact}");
            assert!(drift < h_rounding, "{method}, {potential}: K {drift:e}");
        }
    }
}
