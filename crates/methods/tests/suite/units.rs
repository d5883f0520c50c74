//! Scenes in units in which p is far smaller than q: the same motion, which no method refuses.

use crate::catalog::{As, written};
use afterbay_core::{Grid, InputError, State, StateRef};
use afterbay_methods::registry::{FIXED, Setting, find};
use afterbay_systems::{Description, DissipationText};
use std::ops::ControlFlow;

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
