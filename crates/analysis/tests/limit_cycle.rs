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
fn explore_van_der_pol() {
    let begin = Instant::now();
    let found = study(van_der_pol(1.0), 40.0).run(&REFERENCE, 0.02, &Silent).unwrap();
    println!("{:?} {:?}", begin.elapsed(), found);
    let found = study(van_der_pol(1.0), 40.0).run(row("moddg"), 0.05, &Silent).unwrap();
    println!("{:?} {:?}", begin.elapsed(), found);
    for b in [0.0, 1e-3, 0.1, 3.0] {
        let found = study(oscillator(b, ""), 100.0).run(row("moddg"), 0.1, &Silent).unwrap();
        println!("b = {b}: {:?}", found.ending);
        let found = study(oscillator(b, ""), 100.0).run(row("rk4"), 0.1, &Silent).unwrap();
        println!("b = {b}: {:?}", found.ending);
    }
    let holmes = duffing([-1.0, 1.0, 0.25, 0.25, 1.0], [1.0, 0.0]);
    let mut holmes = study(holmes, 400.0);
    let found = holmes.run(row("moddg"), 0.1, &Silent).unwrap();
    println!("{:?} {:?}", begin.elapsed(), found);
    holmes.branch = Some(Branch { parameter: "f".into(), from: 0.25, to: 0.4, doublings: 3 });
    let found = holmes.run(row("moddg"), 0.2, &Silent).unwrap();
    println!("{:?} {:?}", begin.elapsed(), found.ending);
    for point in found.points.iter() {
        let Cycle { value, period, amplitude, multipliers, multiple, .. } = &point.cycle;
        println!("{value:?} T {period} k {multiple:?} a {amplitude:?} {multipliers:?} {:?}", point.event);
    }
}
