//! Scenes in units in which p is far smaller than q: the same motion, which no method refuses.

use crate::catalog::{As, written};
use afterbay_core::{Grid, InputError, State, StateRef};
use afterbay_methods::registry::{FIXED, Setting};
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
