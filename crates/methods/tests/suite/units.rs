//! Scenes in units of mass and of time: the same motion, which no method refuses.

use crate::catalog::{As, written};
use crate::motors::Shaker;
use afterbay_core::{Abilities, Drive, Driven, Grid, InputError, State, StateRef, with_motors};
use afterbay_methods::registry::{FIXED, Row, Setting, bind, find};
use afterbay_systems::{Description, DissipationText, Duffing};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Steps that end nearly at rest, in units of mass down to 1e-27. At v = 0 no change of p makes up
/// for an error of K.
#[test]
fn a_step_that_ends_at_rest_is_taken_in_all_units_of_mass() {
    for mass in [1.0, 1e-3, 1e-6, 1e-10, 1e-27] {
        let system = written(&Description {
            potential: format!("{mass:e}*(q1^2/2 - q1^3/10)"),
            masses: vec![format!("{mass:e}")],
            dissipation: DissipationText::Forces(vec![format!("{:e}*v1", 0.02 * mass)]),
            ..Description::default()
        });
        for row in FIXED.iter().filter(|row| row.keeps_k) {
            let run = match system.bind(row, As::Separable) {
                Ok(run) => run,
                Err(InputError::Unsupported { .. }) => continue,
                Err(error) => panic!("{}: {error}", row.name),
            };
            for h in [0.1, 0.025, 1e-3] {
                for off in [0.0, 1e-3, -1e-3, 1e-7, 0.02] {
                    // The force is about 0.64 times the mass.
                    let p = mass * (0.87 - 0.3 * 0.87 * 0.87) * h * (1.0 + off);
                    let mut state = State::new(vec![0.87], vec![p]).unwrap();
                    let before = state.total(&*system);
                    let setting = Setting::Step(Grid::new(h, h).unwrap());
                    let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
                    let ended = run.run(setting, &mut state, 1, &mut show);
                    let scene = format!("{}, mass {mass:e}, h = {h}, {off}", row.name);
                    assert!(ended.is_ok(), "{scene}: {ended:?}");
                    let k = (state.total(&*system) - before).abs();
                    assert!(k <= 4e-15 * before, "{scene}: K off by {k:e}");
                }
            }
        }
    }
}

/// Steps so long that sweeps diverge: Newton's method solves them in all units of mass alike.
#[test]
fn a_long_step_is_the_same_in_all_units_of_mass() {
    let end = |mass: f64, name: &str, h: f64| {
        let system = written(&Description {
            potential: format!("{mass:e}*(q1^2/2 + q1^4/10)"),
            masses: vec![format!("{mass:e}")],
            dissipation: DissipationText::Forces(vec![format!("{:e}*v1", 0.02 * mass)]),
            ..Description::default()
        });
        let row = find(name).expect("a method");
        let run = system.bind(row, As::Separable).expect("it applies");
        let mut state = State::new(vec![0.87], vec![0.3 * mass]).unwrap();
        let setting = Setting::Step(Grid::new(h, 4.0 * h).unwrap());
        let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let ended = run.run(setting, &mut state, 1, &mut show);
        assert!(ended.is_ok(), "{name}, mass {mass:e}, h = {h}: {ended:?}");
        [state.q[0], state.p[0] / mass]
    };
    for name in ["collocation-2", "collocation-4", "collocation-8", "collocation-16"] {
        for h in [1.5, 3.0, 5.0] {
            let one = end(1.0, name, h);
            for mass in [1e-27, 1e27] {
                let other = end(mass, name, h);
                let off = (one[0] - other[0]).abs().max((one[1] - other[1]).abs());
                assert!(off <= 1e-12, "{name}, mass {mass:e}, h = {h}: {one:?}, {other:?}");
            }
        }
    }
}

/// A driven oscillator with a hardening spring, to the time 90 in a unit of time of 1/`unit`, by
/// steps of 0.3. Returns q at the end and the number of evaluations.
fn driven(row: &Row, unit: f64) -> Result<(f64, u64), InputError> {
    let stiffness = 1.0 / (unit * unit);
    let duffing = Duffing::new(stiffness, stiffness, 0.1 / unit)?;
    let shaker = Shaker::of_first(0.3 / (unit * unit), 1.1 / unit);
    let (duffing, shaker): (Arc<dyn Abilities<f64>>, Arc<dyn Drive<f64>>) =
        (Arc::new(duffing), Arc::new(shaker));
    let run = bind(row, Arc::new(Driven::new(duffing, shaker)?))?;
    let mut state = with_motors(&State::new(vec![0.5], vec![0.0])?, 1);
    let setting = Setting::Step(Grid::new(0.3 * unit, 90.0 * unit)?);
    let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let done = run.run(setting, &mut state, 1, &mut show).expect("it runs");
    Ok((state.q[0], done.effort.evaluations))
}

/// The time is a coordinate of a driven system, and may be far larger than q. Some methods use the
/// Euclidean norm of (q, p) and depend on units. In both units here p is far smaller than q, and
/// does not count in that norm.
#[test]
fn a_driven_step_is_solved_to_rounding_in_all_units_of_time() {
    let [coarse, fine] = [20, 43].map(|power| 2_f64.powi(power));
    for row in FIXED {
        let Ok((q, evaluations)) = driven(row, coarse) else { continue };
        let (other, spent) = driven(row, fine).expect("it applies");
        assert!((q - other).abs() < 1e-9, "{}: {q} {other}", row.name);
        let least = evaluations - evaluations / 10;
        assert!(spent >= least, "{}: {evaluations} and {spent} evaluations", row.name);
    }
}

/// The energy supplied is the momentum of a motor, and may be far larger than p.
#[test]
fn locally_exact_steps_are_solved_where_energies_are_far_larger_than_momenta() {
    let row = find("locally-exact").expect("a method");
    let [(q, _), (other, _)] =
        [-30, -43].map(|power| driven(row, 2_f64.powi(power)).expect("it applies"));
    assert!((q - other).abs() < 1e-9, "{q} {other}");
}
