//! Runs across kinks of V(q, t) in t, at which fixed steps are divided.

use crate::catalog::{Built, written};
use crate::slope::slope;
use afterbay_core::{Grid, InputError, State, with_motors};
use afterbay_methods::registry::{FIXED, bind, find};
use afterbay_systems::{Description, DissipationText};
use std::ops::ControlFlow;

fn system(potential: &str, forces: &[&str]) -> Built {
    let forces = forces.iter().map(ToString::to_string).collect();
    written(&Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(forces),
        ..Description::default()
    })
}

/// A state with the clock behind `q.len()` degrees of freedom.
fn start(q: &[f64], p: &[f64]) -> State<Vec<f64>> {
    with_motors(&State::new(q.to_vec(), p.to_vec()).unwrap(), 1)
}

/// Runs the methods over [0, 6] and returns the number of those that keep K.
fn check_k(system: &Built, start: &State<Vec<f64>>, steps: u64) -> usize {
    let (total, mut kept) = (start.total(&**system), 0);
    for row in FIXED.iter().filter(|row| row.keeps_k) {
        let Ok(run) = bind::<f64>(row, system.abilities()) else { continue };
        let mut state = start.clone();
        let grid = Grid::of(6.0 / steps as f64, steps).unwrap();
        run.run(grid, &mut state, 1, &mut |step, state| {
            let off = (state.total(&**system) - total).abs();
            assert!(off < 1e-12, "{} at step {step}: K is off by {off:e}", row.name);
            ControlFlow::Continue(())
        })
        .unwrap_or_else(|error| panic!("{} with {steps} steps: {error}", row.name));
        let late = (state.q.last().unwrap() - 6.0).abs();
        assert!(late < 1e-12, "{}: the clock is off by {late:e}", row.name);
        kept += 1;
    }
    kept
}

#[test]
fn k_is_kept_across_kinks_in_time() {
    let alone = start(&[0.3], &[0.3]);
    for potential in [
        "q1^2/2 + max(cos(3*t), 0.2)*q1",
        "q1^2/2 + abs(sin(t))*q1^2",
        // The kinks are at times of the grid.
        "q1^2/2 + abs(t - 3)*q1^4/4 + min(t, 1.5)*q1",
        "cos(q1)*(1 + min(t, 3))",
    ] {
        let system = system(potential, &["0.1*v1*(1 + abs(sin(2*t)))"]);
        for steps in [60, 240, 601] {
            assert_eq!(check_k(&system, &alone, steps), 19, "{potential}");
        }
    }
    let coupled = "q1^4/4 + q2^2 + q1^2*q2^2*abs(cos(2*t)) + max(sin(t), 0.3)*cos(q1 - q2)";
    let coupled = system(coupled, &["0.1*v1", "0.2*v2^3"]);
    let start = start(&[0.3, -0.2], &[0.3, 0.5]);
    assert_eq!(check_k(&coupled, &start, 120), 18);
}

/// `increment-6` is left out: its substeps leave the step and meet the kink from either side.
#[test]
fn orders_hold_across_kinks_in_time() {
    let potential = "q1^4/4 + q2^2 + max(cos(3*t), 0.2)*q1*q2 + abs(sin(t))*sin(q1)";
    let system = system(potential, &["0.1*v1", "0.2*v2^3"]);
    let end = |name: &str, steps: u64| {
        let run = bind::<f64>(find(name).unwrap(), system.abilities()).unwrap();
        let mut state = start(&[0.3, -0.2], &[0.3, 0.5]);
        let grid = Grid::of(4.0 / steps as f64, steps).unwrap();
        run.run(grid, &mut state, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
        [state.q, state.p, state.w].concat()
    };
    let exact = end("collocation-16", 200);
    for (name, order, counts) in [
        ("leapfrog", 2.0, [160, 240, 320]),
        ("increment-2", 2.0, [160, 240, 320]),
        ("gonzalez", 2.0, [160, 240, 320]),
        ("locally-exact", 2.0, [160, 240, 320]),
        ("implicit-midpoint", 2.0, [160, 240, 320]),
        ("rk4", 4.0, [160, 240, 320]),
        ("splitting-4", 4.0, [160, 240, 320]),
        ("splitting-6", 6.0, [60, 80, 100]),
        ("collocation-4", 4.0, [80, 120, 160]),
        ("increment-4", 4.0, [160, 240, 320]),
        ("increment-8", 8.0, [24, 32, 40]),
        ("collocation-6", 6.0, [80, 120, 160]),
    ] {
        let off = |&steps: &u64| {
            let parts = end(name, steps).into_iter().zip(&exact);
            parts.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let steps = counts.map(|count| 4.0 / count as f64);
        let found = slope(&steps, &counts.each_ref().map(off));
        assert!((found - order).abs() < 0.1, "{name}: {found:.3}, not {order}");
    }
}

#[test]
fn a_single_step_is_divided_as_in_a_run() {
    let system = system("q1^2/2 + abs(t - 0.4)*q1", &["0.1*v1"]);
    for row in FIXED {
        let Ok(run) = bind::<f64>(row, system.abilities()) else { continue };
        let [mut single, mut first] = [(); 2].map(|()| start(&[0.3], &[0.3]));
        run.step(1.0, &mut single).unwrap();
        run.run(Grid::of(1.0, 1).unwrap(), &mut first, 1, &mut |_, _| ControlFlow::Continue(()))
            .unwrap();
        assert_eq!((single.q, single.p, single.w), (first.q, first.p, first.w), "{}", row.name);
    }
}

/// Their steps end late by their error, and would cross a kink.
#[test]
fn relaxed_methods_are_refused_beside_kinks_in_time() {
    for (potential, force) in [("q1^2/2 + abs(t - 1)*q1", "0.1*v1"), ("q1^2/2", "abs(t - 1)*v1")] {
        let system = system(potential, &[force]);
        for name in ["relaxed-rk4", "relaxed-dop853", "relaxed-verner98"] {
            let refused = bind::<f64>(find(name).unwrap(), system.abilities());
            assert!(matches!(refused, Err(InputError::Unsupported { .. })), "{name}");
        }
    }
}
