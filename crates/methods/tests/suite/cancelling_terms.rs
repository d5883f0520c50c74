//! Potentials whose terms cancel near rest: |H| is far below the roundings of its terms.

use crate::catalog::{As, Built, written};
use afterbay_core::{Abilities, Grid, InputError, Quad, State, StateRef, Tolerance};
use afterbay_methods::registry::{ADAPTIVE, FIXED, Row, Setting, bind};
use afterbay_systems::{Custom, Description, DissipationText};
use std::ops::ControlFlow;
use std::sync::Arc;

fn system(potential: &str, n: usize) -> Built {
    let forces = (1..=n).map(|j| format!("0.5*p{j}")).collect();
    written(&Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(forces),
        dof: Some(n),
        ..Description::default()
    })
}

/// Every method that keeps K follows the decay to rest, with K at the rounding of the terms.
#[test]
fn every_method_reaches_rest() {
    let toda = "sum(i, 1, n-1, exp(q[i+1] - q[i]) - (q[i+1] - q[i]) - 1)";
    for (potential, n, start) in
        [("1 - cos(q1)", 1, 1e-3), (toda, 8, 1e-2), ("cosh(q1) - 1", 1, 1e-5)]
    {
        reaches_rest((potential, n as f64), n, start, [0.1, 20.0]);
    }
}

/// A run from afar to rest: V is small there compared with its terms and with w, which a run sums
/// in blocks of steps.
#[test]
fn every_method_comes_to_rest_from_afar() {
    let lennard_jones = "(1/(1 + q1))^12 - 2*(1/(1 + q1))^6";
    // The slopes of the last two are differences of terms of the size 12.
    for (potential, terms, start) in [
        ("1 - cos(q1)", 1.0, 1.5),
        ("cosh(q1) - 1", 1.0, 1.0),
        ("(1 - exp(-q1))^2", 1.0, 0.7),
        ("(q1^2 - 1)^2/4", 1.0, 0.4),
        (lennard_jones, 12.0, 0.1),
        (&format!("{lennard_jones} + 1"), 12.0, 0.1),
    ] {
        reaches_rest((potential, terms), 1, start, [0.05, 130.0]);
    }
}

/// Every method ends within roundings of the place of rest, where H and the force are differences of
/// larger terms. Their roundings neither stop a step nor keep the motion going.
#[test]
fn every_method_stays_at_rest() {
    let from = |q: f64, p: f64| State::new(vec![q], vec![p]).unwrap();
    for (potential, start, place) in [
        ("q1^2/2 - 2*q1 + 2", from(2.0, 0.5), 2.0),
        ("q1^2/2 - 2*q1 + 2", from(2.0, 0.01), 2.0),
        ("1 - cos(q1)", from(2.3, 1.3), std::f64::consts::TAU),
        ("q1^4/4 - q1^2/2 + 0.25", from(1.4, 0.2), 1.0),
        ("1/q1 + q1 - 2", from(1.3, 0.1), 1.0),
        ("(1 - exp(-q1))^2", from(0.4, 0.1), 0.0),
        ("exp(q1) + exp(-q1) - 2", from(0.4, 0.1), 0.0),
    ] {
        let system = system(potential, 1);
        for row in FIXED {
            for h in [0.05, 0.3] {
                let Ok(run) = system.bind(row, As::Separable) else { continue };
                let name = format!("{} with h = {h} on {potential}", row.name);
                let mut state = start.clone();
                let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
                let grid = Setting::Step(Grid::new(h, 240.0).unwrap());
                let done = run.run(grid, &mut state, 1, &mut ignore);
                done.unwrap_or_else(|error| panic!("{name}: {error}"));
                let off = (state.q[0] - place).abs().max(state.p[0].abs());
                assert!(off < 1e-13, "{name}: {off:e}");
                let drift = (state.total(&*system) - start.total(&*system)).abs();
                assert!(!row.keeps_k || drift < 1e-13, "{name}: K {drift:e}");
            }
        }
    }
}

/// In 106 bits 1 - cos q is a rounding of 1 where q is 1e-16, as the neighbours of a state at rest
/// are whose distance measures Lyapunov exponents.
#[test]
fn terms_that_cancel_in_106_bits_stop_no_method() {
    let description = Description {
        potential: "1 - cos(q1)".to_owned(),
        dissipation: DissipationText::Forces(vec!["0.5*v1".to_owned()]),
        ..Description::default()
    };
    let system = Custom::new(&description).unwrap().lift(|_, x| Quad::from(x));
    let system: Arc<dyn Abilities<Quad>> = Arc::new(system);
    let relaxed = |row: &Row| row.name.starts_with("relaxed");
    for row in FIXED.iter().filter(|row| !relaxed(row)) {
        let Ok(run) = bind(row, system.clone()) else { continue };
        for q in [1e-14, 1e-16, 1e-18] {
            let mut state = State::new(vec![Quad::from(q)], vec![Quad::from(0.3 * q)]).unwrap();
            let grid = Setting::Step(Grid::new(0.05, 1.0).unwrap());
            let done = run.run(grid, &mut state, 1, &mut |_, _| ControlFlow::Continue(()));
            assert!(done.is_ok(), "{} from {q:e}: {done:?}", row.name);
        }
    }
}

/// Checks that every method that keeps K follows the decay from q_j = start cos j to rest, with
/// steps h or within a tolerance. `terms` is the size of the terms of the potential.
fn reaches_rest((potential, terms): (&str, f64), n: usize, start: f64, [h, end]: [f64; 2]) {
    let system = system(potential, n);
    let q: Vec<f64> = (0..n).map(|j| start * (1.0 + j as f64).cos()).collect();
    let start = State::new(q, vec![0.0; n]).unwrap();
    let rows = FIXED.iter().filter(|row| row.keeps_k).chain(ADAPTIVE);
    for row in rows {
        let adaptive = row.is_adaptive();
        let form = if adaptive { As::Curved } else { As::Separable };
        let run = match system.bind(row, form) {
            Ok(run) => run,
            Err(InputError::Unsupported { .. }) => continue,
            Err(error) => panic!("{}: {error}", row.name),
        };
        let setting: Setting<f64> = if adaptive {
            Setting::Tolerance(Tolerance::all(1e-8), end)
        } else {
            Setting::Step(Grid::new(h, end).unwrap())
        };
        let (mut state, before) = (start.clone(), start.total(&*system));
        let (mut off, mut steps) = (0.0_f64, 0);
        let mut look = |_: u64, at: StateRef<'_, f64>| {
            off = off.max((at.total(&*system) - before).abs());
            steps += 1;
            if steps < 20_000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let result = run.run(setting, &mut state, 1, &mut look);
        assert!(result.is_ok(), "{} on {potential}: {result:?}", row.name);
        assert!(steps < 20_000, "{} on {potential} does not come to an end", row.name);
        assert!(off <= 2e-14 * terms, "{} on {potential}: {off:e}", row.name);
        let moving = state.p.iter().fold(0.0_f64, |most, p| most.max(p.abs()));
        assert!(moving <= 1e-2 * start.q[0].abs(), "{} on {potential}: {state:?}", row.name);
    }
}
