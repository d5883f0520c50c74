//! Trajectories in legs.

use crate::after::AfterAsked;
use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::outcome::{Ending, INTERRUPTED};
use afterbay_analysis::study::trajectory::{Legs, Steps, TrajectoryRow, dense, run};
use afterbay_methods::registry::{Row, find};
use afterbay_systems::{
    Custom, CustomDrive, DUFFING, Described, Description, DissipationText, DriveDescription,
    FPUT_CHAIN,
};
use std::ops::ControlFlow;
use std::sync::atomic::AtomicU64;

const STEP: f64 = 0.01;

/// A driven oscillator whose runs take three legs, the last of them short.
fn problem() -> Problem {
    let forces = vec!["0.3*cos(1.2*t)".to_owned()];
    let description = DriveDescription { forces, ..DriveDescription::default() };
    let (drive, _) = CustomDrive::new(&description, 1).expect("a drive");
    let duffing = [("alpha", 1.0), ("beta", 0.5), ("c", 0.1)];
    let model = Model::named(&DUFFING, duffing).expect("a system");
    let model = Model::Driven(Box::new(model), drive);
    Problem { model, q: vec![1.0], p: vec![0.0], end: 22_000.0 }
}

/// The states that a run of five legs keeps, and its ending. `kept` writes what is kept between two
/// legs, and reads it back.
fn in_legs(problem: &Problem, row: &'static Row, kept: bool) -> (Vec<TrajectoryRow>, Ending) {
    let steps = Steps { h: STEP, every: 7001, tolerance: Some(1e-6) };
    let mut legs = Legs::new(problem, row).expect("a start");
    let (mut rows, mut count) = (Vec::new(), 0);
    while !legs.has_ended() {
        count += 1;
        if kept {
            let mut bytes = Vec::new();
            ciborium::into_writer(&legs, &mut bytes).expect("bytes");
            legs = ciborium::from_reader(&bytes[..]).expect("the same legs");
        }
        let mut keep = |row| {
            rows.push(row);
            ControlFlow::Continue(())
        };
        legs.advance(problem, row, steps, &mut keep, &Silent).expect("a leg");
    }
    assert_eq!(count, 5, "the motor of the drive is a second degree of freedom");
    (rows, legs.ending)
}

#[test]
fn legs_go_on_from_what_was_kept_to_the_bit() {
    let problem = problem();
    for name in ["moddg", "adaptive-dop853"] {
        let row = find(name).expect("a method");
        let [(alone, ending), (resumed, _)] =
            [false, true].map(|kept| in_legs(&problem, row, kept));
        assert!(ending.is_completed(), "{ending:?}");
        assert_eq!(format!("{alone:?}"), format!("{resumed:?}"));
        let numbers: Vec<u64> = alone.iter().map(|row| row.step).collect();
        let expected: Vec<u64> = (0..=314).map(|n| 7001 * n).chain([2_200_000]).collect();
        assert_eq!(numbers, expected, "{name}");
        assert!(alone.iter().all(|row| row.t == row.step as f64 * STEP));
        let first = alone[0].total;
        let off = alone.iter().map(|row| (row.total - first).abs()).fold(0.0, f64::max);
        assert!(name != "moddg" || off < 1e-10, "K is off by {off:e}");
    }
}

#[test]
fn w_does_not_depend_on_the_states_that_are_kept() {
    let problem = problem();
    let row = find("moddg").expect("a method");
    let end = |every| {
        let runs = run(&problem, &[row], STEP, every, &Silent).expect("runs");
        format!("{:?}", runs[0].rows.last())
    };
    assert_eq!(end(7001), end(100_000));
}

#[test]
fn a_run_that_fails_in_a_later_leg_names_its_step() {
    let model = Model::of(&DUFFING, &[-1e-7, 0.0, 0.0]);
    let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 2e7 };
    let row = find("rk4").expect("a method");
    let found = run(&problem, &[row], 1.0, 1000, &Silent).expect("a run");
    let [run] = &found[..] else { panic!("one run") };
    assert_eq!(run.ending.outcome, "not-finite", "{:?}", run.ending);
    let last = run.rows.last().expect("rows").step;
    assert!(last > 1 << 20, "{last}");
    let named = format!("step {}", last + 1);
    let said = run.ending.failure.as_deref().unwrap_or_default();
    assert!(said.contains(&named), "{said}: {named}");
}

/// The last good state of a run that fails lies between two states that are kept.
#[test]
fn the_deviation_of_k_is_that_of_the_last_good_state_too() {
    let model = Model::of(&DUFFING, &[0.0, -1.0, 0.0]);
    let problem = Problem { model, q: vec![1.5], p: vec![1.0], end: 10.0 };
    for name in ["adaptive-dop853", "adaptive-verner98"] {
        let mut legs = Legs::new(&problem, find(name).expect("a method")).expect("a start");
        let (mut rows, steps) = (Vec::new(), Steps { h: 1.0, every: 1, tolerance: Some(1e-6) });
        let mut keep = |row: TrajectoryRow| {
            rows.push(row);
            ControlFlow::Continue(())
        };
        let row = find(name).expect("a method");
        legs.advance(&problem, row, steps, &mut keep, &Silent).expect("a leg");
        assert!(legs.ending.failure.is_some(), "{name}: {:?}", legs.ending);
        let [first, .., last] = &rows[..] else { panic!("{name}: {} rows", rows.len()) };
        assert!(last.t > last.step as f64, "{name}: {last:?}");
        let drift = rows.iter().map(|row| (row.total - first.total).abs()).fold(0.0, f64::max);
        assert!(drift > 0.0 && legs.balance.drift == drift, "{name}: {drift:e}");
    }
}

/// A drive that jumps 3e8 times until the next state that is kept.
#[test]
fn a_run_that_chooses_its_steps_ends_between_two_states() {
    let forces = vec!["sign(sin(1e9*t))".to_owned()];
    let description = DriveDescription { forces, ..DriveDescription::default() };
    let (drive, _) = CustomDrive::new(&description, 1).expect("a drive");
    let model = Model::of(&DUFFING, &[0.0; 3]);
    let model = Model::Driven(Box::new(model), drive);
    let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 2.0 };
    let row = find("adaptive-dop853").expect("a method");
    let mut legs = Legs::new(&problem, row).expect("a start");
    let steps = Steps { h: 1.0, every: 1, tolerance: Some(1e-6) };
    let mut rows = 0;
    let mut keep = |_| {
        rows += 1;
        ControlFlow::Continue(())
    };
    let after = AfterAsked(AtomicU64::new(100));
    legs.advance(&problem, row, steps, &mut keep, &after).expect("a leg");
    assert!(legs.has_ended());
    assert_eq!((legs.ending.outcome, legs.done(), rows), (INTERRUPTED, 0, 1));
}

#[test]
fn no_state_is_kept_after_the_last_that_was_wanted() {
    let model = Model::of(&DUFFING, &[1.0, 0.0, 0.0]);
    let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 1.0 };
    let row = find("moddg").expect("a method");
    let mut legs = Legs::new(&problem, row).expect("a start");
    let steps = Steps { h: 0.5, every: 1, tolerance: None };
    let mut times = Vec::new();
    let mut keep = |row: TrajectoryRow| {
        times.push(row.t);
        if times.len() == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    legs.sample(&problem, row, steps, 0.125, &mut keep, &Silent).expect("a leg");
    assert_eq!(times, [0.0, 0.125, 0.25]);
}

#[test]
fn a_problem_without_degrees_of_freedom_is_refused() {
    let model = Model::of(&FPUT_CHAIN, &[0.0, 1.0, 0.1]);
    let problem = Problem { model, q: vec![], p: vec![], end: 1.0 };
    let refused = run(&problem, &[find("rk4").expect("a method")], 0.1, 1, &Silent);
    let error = refused.map(drop).expect_err("no degree of freedom").to_string();
    assert_eq!(error, "parameter n = 0.0 must be a whole number from 1 to 1e6");
}

#[test]
fn a_method_that_chooses_its_steps_has_to_have_a_tolerance() {
    let model = Model::of(&DUFFING, &[1.0, 0.0, 0.0]);
    let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 1.0 };
    let row = find("adaptive-dop853").expect("a method");
    let steps = Steps { h: 0.5, every: 1, tolerance: None };
    let found = [
        run(&problem, &[row], 0.5, 1, &Silent).map(drop),
        dense(&problem, row, steps, 0.25, &Silent).map(drop),
    ];
    for found in found {
        let error = found.expect_err("no tolerance").to_string();
        assert_eq!(error, "adaptive-dop853 does not apply: it takes a tolerance, not a step");
    }
}

/// The terms of H overflow with opposite signs while q and p are finite.
#[test]
fn an_energy_that_overflows_is_an_empty_cell_and_no_fault_of_the_system() {
    let description = Description {
        potential: "-q1^4".into(),
        dissipation: DissipationText::Forces(vec!["0.1*v1".into()]),
        ..Description::default()
    };
    let model = Model::Custom(Described::Separable(Custom::new(&description).expect("a system")));
    let problem = Problem { model: model.clone(), q: vec![1.0], p: vec![1.0], end: 4.0 };
    let found = run(&problem, &[find("rk4").expect("a method")], 0.1, 1, &Silent).expect("a run");
    let Ending { outcome, failure } = &found[0].ending;
    let failure = failure.as_ref().expect("a failure");
    assert!(*outcome == "not-finite" && !failure.contains("check the parameters"), "{failure}");
    let last = found[0].rows.last().expect("a row");
    assert!(last.q[0].is_finite() && last.energy.is_nan(), "{last:?}");
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.serialize(last).expect("a line");
    let line = String::from_utf8(writer.into_inner().expect("bytes")).expect("UTF-8");
    assert!(line.ends_with(",,\n"), "{line}");
    let read = TrajectoryRow::read("rk4", &line, &model).expect("a row");
    assert!(read.energy.is_nan() && read.total.is_nan() && read.q == last.q, "{read:?}");
}
