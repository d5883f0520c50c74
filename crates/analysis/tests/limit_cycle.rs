//! Limit cycles: published figures of Van der Pol's, closed forms, and the bifurcations of branches.

#![cfg(test)]

use afterbay_analysis::progress::Silent;
use afterbay_analysis::record::Artifact;
use afterbay_analysis::scene::Scene;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::limit_cycle::{Branch, Cycle, Cycles, Event, LimitCycle, columns};
use afterbay_methods::registry::{REFERENCE, Row, find};
use std::f64::consts::{PI, TAU};
use std::time::Instant;

fn problem(system: &str, drive: &str, start: [f64; 2]) -> Problem {
    let [q, p] = start;
    let text = format!(
        "[system]\n{system}\n{drive}\n[initial]\nq = [{q:?}]\np = [{p:?}]\n[time]\nend = 1.0\n\
         step = 0.1\n"
    );
    Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem
}

fn van_der_pol(mu: f64) -> Problem {
    problem(&format!("name = \"van-der-pol\"\nparameters = {{ mu = {mu:?} }}"), "", [2.0, 0.0])
}

fn oscillator(b: f64, drive: &str) -> Problem {
    let system = format!("name = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = {b:?} }}");
    problem(&system, drive, [1.0, 0.5])
}

/// x'' + c x' + α x + β x³ = f cos ωt
fn duffing([alpha, beta, c, f, omega]: [f64; 5], start: [f64; 2]) -> Problem {
    let system = format!(
        "name = \"duffing\"\nparameters = {{ alpha = {alpha:?}, beta = {beta:?}, c = {c:?} }}"
    );
    let drive = format!(
        "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = {{ f = {f:?}, omega = {omega:?} }}"
    );
    problem(&system, &drive, start)
}

fn row(name: &str) -> &'static Row {
    find(name).unwrap()
}

fn study(problem: Problem, transient: f64) -> LimitCycle {
    LimitCycle { problem, transient, multiple: None, branch: None }
}

fn only(found: &Cycles) -> Cycle {
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    assert_eq!(found.points.len(), 1);
    found.points[0].cycle.clone()
}

#[test]
fn explore() {
    let begin = Instant::now();
    for (what, problem, from, to, doublings) in [
        ("holmes", duffing([-1.0, 1.0, 0.25, 0.25, 1.0], [1.0, 0.0]), 0.1, 0.4, 5),
        ("ueda", duffing([0.0, 1.0, 0.2, 5.0, 1.0], [1.0, 0.0]), 1.0, 8.0, 1),
    ] {
    let study = LimitCycle { branch: Some(Branch { parameter: "f".into(), from, to, doublings }), ..study(problem, 400.0) };
    let found = study.run(row("moddg"), 0.2, &Silent).unwrap();
    println!("{what} {:?} {:?} {} points", begin.elapsed(), found.ending, found.points.len());
    for point in found.points.iter().filter(|p| p.event.is_some()).take(40) {
        let Cycle { value, period, amplitude, multipliers, multiple, .. } = &point.cycle;
        println!("{value:?} T {period} k {multiple:?} a {amplitude:?} {multipliers:?} {:?}", point.event);
    }
    }
}
