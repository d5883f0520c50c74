//! Driven scenes: the three energies against closed forms, tables, and parameters of the drive.

#![cfg(test)]

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::record::Artifact;
use afterbay_analysis::scene::Scene;
use afterbay_analysis::study::{energy, global_order, trajectory, work_precision};
use afterbay_core::accounts;
use afterbay_methods::registry::{METHODS, Row, find};
use std::f64::consts::PI;

const B: f64 = 0.5;
const F: f64 = 0.8;
/// The steps in a period.
const STEPS: f64 = 64.0;

/// A driven, damped oscillator over a number of periods.
fn resonance(omega: f64, periods: f64) -> Scene {
    let period = 2.0 * PI / omega;
    let (end, step) = (periods * period, period / STEPS);
    Scene::read(&format!(
        "[system]\nname = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = {B} }}\n\
         [drive]\nforce = \"f*cos(omega*t)\"\nparameters = {{ f = {F}, omega = {omega:?} }}\n\
         [initial]\nq = [0.3]\np = [-0.2]\n[time]\nend = {end:?}\nstep = {step:?}\n"
    ))
    .unwrap()
}

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| find(name).unwrap()).collect()
}

/// When the start is forgotten, the amplitude is f/|k - ω² + iωb|, and a period dissipates what it
/// supplies, π b ω A².
#[test]
fn a_resonance_has_its_closed_form() {
    for omega in [0.6, 1.0, 1.7] {
        // exp(-b t/2) < 1e-16
        let periods = (40.0 / B * 2.0 * omega / (2.0 * PI)).ceil();
        let scene = resonance(omega, periods);
        let solution =
            scene.problem.solution(scene.problem.end / periods, periods as usize, &Silent);
        let solution = solution.unwrap();
        let [before, after] = [solution.len() - 2, solution.len() - 1].map(|i| {
            let state = solution.at(i);
            let found = accounts(state, &scene.problem.model.motors());
            (state.q[0].hypot(state.p[0] / omega), found.w[0], found.s[0])
        });
        let amplitude = F / (1.0 - omega * omega).hypot(omega * B);
        let lost = PI * B * omega * amplitude * amplitude;
        for (what, found, exact) in [
            ("amplitude", after.0, amplitude),
            ("dissipated", after.1 - before.1, lost),
            ("supplied", after.2 - before.2, lost),
        ] {
            assert!((found - exact).abs() < 1e-12, "ω = {omega}: {what} {found:e}, not {exact:e}");
        }
    }
}

#[test]
fn tables_have_the_energy_supplied_behind_the_reservoir() {
    let scene = resonance(1.3, 2.0);
    let problem = &scene.problem;
    let columns = trajectory::columns(&problem.model);
    assert_eq!(columns, ["method", "step", "t", "q1", "p1", "w1", "s1", "H", "K"]);
    let found = trajectory::run(problem, &rows(&["moddg", "gonzalez"]), scene.step, 1, &Silent);
    for run in found.unwrap() {
        for row in &run.rows {
            let energy = 0.5 * (row.q[0] * row.q[0] + row.p[0] * row.p[0]);
            assert!((row.energy - energy).abs() < 1e-14, "{}", run.method);
            assert!((energy + row.w[0] - row.s[0] - row.total).abs() < 1e-14, "{}", run.method);
            assert!((row.total - run.rows[0].total).abs() < 1e-13, "{}", run.method);
        }
        // w can only fill, though w - s falls.
        let pairs = || run.rows.windows(2);
        assert!(pairs().all(|pair| pair[1].w[0] >= pair[0].w[0] - 1e-15), "{}", run.method);
        assert!(pairs().any(|pair| pair[1].w[0] - pair[1].s[0] < pair[0].w[0] - pair[0].s[0]));
        Artifact::wide_table("trajectory", &columns, &run.rows).unwrap();
    }
    let books = energy::run(problem, &rows(&["moddg"]), scene.step, 8, &Silent).unwrap();
    let table = Artifact::wide_table("energy", &energy::columns(&problem.model), &books[0].rows);
    let table = table.unwrap();
    assert!(table.text.lines().next().unwrap().ends_with("doubt_d_R,w1,s1,supplied"));
    assert_eq!(books[0].violations, Some(0));
}

/// Every method that applies, by the three studies that know a drive.
#[test]
fn every_method_is_studied() {
    let text = include_str!("../../../scenes/ueda.toml");
    let mut scene = Scene::read(text).unwrap();
    scene.problem.end = 1.0;
    let applies = |row: &&'static Row| scene.problem.model.bind(row).is_ok();
    let (adaptive, fixed): (Vec<_>, Vec<_>) =
        METHODS.iter().filter(applies).partition(|row| row.is_adaptive());
    assert!(fixed.len() >= 21 && adaptive.len() >= 2, "{} {}", fixed.len(), adaptive.len());
    let table =
        work_precision::run(&scene.problem, (&fixed, &[0.02, 0.01]), (&adaptive, &[1e-6]), &Silent)
            .unwrap();
    for row in &table {
        assert_eq!(row.outcome, "completed", "{}", row.method);
        let keeps = find(row.method).unwrap().keeps_k;
        assert!(!keeps || row.k_drift < 1e-12, "{}: K is off by {:e}", row.method, row.k_drift);
        let [qp, w] = [row.error_qp, row.error_w].map(Option::unwrap);
        assert!(qp < 0.2 && w < 2.0, "{}: {qp:e} {w:e}", row.method);
    }
    let orders =
        global_order::run(&scene.problem, &rows(&["moddg"]), &[0.02, 0.01, 0.005], &Silent);
    drop(orders.unwrap());
}

#[test]
fn parameters_of_the_drive_are_parameters() {
    let problem = resonance(1.1, 1.0).problem;
    assert_eq!(problem.model.parameters(), ["k", "b", "f", "omega"]);
    let still = problem.model.with("f", 0.0).unwrap();
    let supplied = |model: Model| {
        let problem = afterbay_analysis::study::Problem { model, ..problem.clone() };
        let solution = problem.solution(problem.end, 1, &Silent).unwrap();
        accounts(solution.at(1), &problem.model.motors()).s[0]
    };
    assert_eq!(supplied(still), 0.0);
    assert!(supplied(problem.model.clone()).abs() > 0.1);
    assert!(problem.model.with("g", 1.0).is_err());
}
