//! Deliberate errors, each of which the properties of `k_is_kept.rs` must detect; and the limits of
//! what methods claim.

use crate::catalog::Both;
use crate::one_step::*;
use afterbay_core::{RunError, State, StepFailure};
use afterbay_methods::registry::{FIXED, Run, find};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;

/// A generic state of a generic damped system.
const ORDINARY: Case = Case {
    model: Model::Duffing { alpha: 1.0, beta: 1.0, c: 0.3 },
    q: 1.3,
    p: -0.7,
    w: 0.0,
    h: 0.1,
};

fn solved<T: Both>(case: &Case, name: &str) -> Run<T> {
    case.model.bind(find(name).unwrap()).pop().unwrap().run
}

#[test]
fn a_reservoir_update_off_by_1e_minus_10_is_caught() {
    let run = solved::<f64>(&ORDINARY, "moddg");
    let broken = |h: f64, state: &mut State<[f64; 1]>| {
        let w0 = state.w[0];
        let effort = run.step(h, state)?;
        state.w[0] = w0 + (state.w[0] - w0) * (1.0 + 1e-10);
        Ok(effort)
    };
    assert_eq!(ORDINARY.keeps_k(&|h, state| run.step(h, state), ROUNDINGS), Ok(None));
    let wrong = ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err();
    assert!(wrong.contains("K moved by") && wrong.contains("step 1 "), "{wrong}");
}

#[test]
fn a_reservoir_fed_with_the_old_dissipation_is_caught() {
    let run = solved::<f64>(&ORDINARY, "moddg");
    let broken = |h: f64, state: &mut State<[f64; 1]>| {
        let (q0, p0, w0) = (state.q[0], state.p[0], state.w[0]);
        let effort = run.step(h, state)?;
        let [c, d] = ORDINARY.model.friction();
        state.w[0] = w0 + (c + d * q0 * q0) * p0 * (state.q[0] - q0);
        Ok(effort)
    };
    assert!(ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err().contains("K moved by"));
}

#[test]
fn a_step_left_unsolved_is_caught() {
    let run = solved::<f64>(&ORDINARY, "moddg");
    let broken = |h: f64, state: &mut State<[f64; 1]>| {
        let effort = run.step(h, state)?;
        state.p[0] += 1e-13;
        Ok(effort)
    };
    assert!(ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err().contains("K moved by"));
}

#[test]
fn a_failed_step_that_changes_the_state_is_caught() {
    let broken = |_, state: &mut State<[f64; 1]>| {
        state.w[0] += 1e-15;
        Err(RunError { step: 1, t: 0.0, failure: StepFailure::Singular { dof: 0, slope: None } }
            .into())
    };
    assert!(ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err().contains("changed"));
}

#[test]
fn what_does_not_claim_k_does_not_keep_it() {
    for row in FIXED.iter().filter(|row| !row.keeps_k) {
        let oscillator = Case { model: Model::DampedOscillator { k: 1.0, b: 0.3 }, ..ORDINARY };
        // The midpoint rule keeps K where H is quadratic.
        let quadratic = (row.name != "implicit-midpoint").then_some(oscillator);
        for case in [ORDINARY].into_iter().chain(quadratic) {
            for Bound { run, closed } in case.model.bind::<f64>(row) {
                let wrong = case.keeps_k(&|h, state| run.step(h, state), 1e6 * ROUNDINGS);
                assert!(
                    wrong.is_err_and(|wrong| wrong.contains("K moved by")),
                    "{} ({closed})",
                    row.name
                );
            }
        }
    }
}

#[test]
fn a_shared_step_is_not_passive_beside_its_pole() {
    // δ₃(q) → -∞ as b q/p grows, and a negative δ takes energy from the reservoir.
    let case =
        Case { model: Model::DampedOscillator { k: 1.0, b: 0.5 }, q: 2.0, p: 1e-3, w: 0.0, h: 0.3 };
    for Bound { run, .. } in case.model.bind::<f64>(find("moddg-q3-shared").unwrap()) {
        assert!(case.only_fills(&|h, state| run.step(h, state)).is_err());
    }
}

#[test]
fn positive_weights_fill_the_reservoir_while_the_energy_rises() {
    // rk4 adds h Σ b_i D_i ∂H/∂p_i with b_i > 0, so w increases even beyond the limit of stability.
    let case =
        Case { model: Model::DampedOscillator { k: 1.0, b: 0.1 }, q: 2.3, p: -3.1, w: 0.0, h: 3.5 };
    let energy_rises = |name: &str| {
        let run = solved::<f64>(&case, name);
        assert_eq!(case.only_fills(&|h, state| run.step(h, state)), Ok(None));
        let (before, mut after) = (case.start(), case.start());
        run.step(case.h, &mut after).unwrap();
        let energy = |state: &State<[f64; 1]>| case.model.total(state).0 - state.w[0];
        energy(&after) > energy(&before)
    };
    assert!(energy_rises("rk4") && energy_rises("leapfrog") && !energy_rises("moddg"));
}

#[test]
fn the_property_is_mostly_about_steps_that_are_taken() {
    let mut runner = TestRunner::deterministic();
    let cases: Vec<Case> =
        (0..400).map(|_| case(model()).new_tree(&mut runner).unwrap().current()).collect();
    for row in FIXED.iter().filter(|row| row.keeps_k && on_one_degree(row)) {
        let (mut all, mut taken) = (0, 0);
        for case in &cases {
            for Bound { run, .. } in case.model.bind::<f64>(row) {
                all += 1;
                taken += u32::from(
                    case.keeps_k(&|h, state| run.step(h, state), ROUNDINGS_FIXED_POINT) == Ok(None),
                );
            }
        }
        let share = f64::from(taken) / f64::from(all);
        println!("{:26} {share:.2} of {all}", row.name);
        let floor = if row.name == "moddg" { 0.9 } else { 0.5 };
        assert!(share > floor, "{}: {share}", row.name);
    }
}
