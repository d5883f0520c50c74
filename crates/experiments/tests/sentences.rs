//! Sentences say what was measured, and no number where nothing was.

#![cfg(test)]

use afterbay_analysis::progress::Silent;
use afterbay_experiments::experiment;
use afterbay_experiments::scene::Scene;

fn scene(system: &str, start: [f64; 2], [end, step]: [f64; 2], task: &str) -> Scene {
    let [q, p] = start;
    let text = format!(
        "[system]\n{system}\n[initial]\nq = [{q:?}]\np = [{p:?}]\n[time]\nend = {end:?}\n\
         step = {step:?}\n{task}\n"
    );
    Scene::read(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn studied(scene: &Scene) -> String {
    let (_, findings) = experiment::study(scene, &Silent).expect("it runs");
    findings[0].statement.clone()
}

/// A positive exponent is chaos of a bounded motion only.
#[test]
fn a_positive_exponent_of_a_motion_that_grows_is_no_chaos() {
    let oscillator = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = -0.3 }";
    let hill = "name = \"custom\"\npotential = \"-q1^2/2\"\ndissipation = [\"0.1*p1\"]";
    let ueda = "name = \"duffing\"\nparameters = { alpha = 0.0, beta = 1.0, c = 0.05 }\n[drive]\n\
                force = [\"7.5*cos(t)\"]";
    for (system, start, end, kind) in [
        (oscillator, [1.0, 0.0], 40.0, "unstable, the motion grows"),
        (hill, [0.5, 0.0], 20.0, "unstable, the motion grows"),
        // A state at rest on the hill.
        (hill, [0.0, 0.0], 20.0, "unstable, at rest"),
        (ueda, [2.5, 0.0], 100.0, "chaos"),
    ] {
        let time = if kind == "chaos" { 4.0 * end } else { end };
        let task =
            format!("[study.lyapunov]\nmethods = [\"rk4\"]\nreference = false\ntime = {time:?}");
        let said = studied(&scene(system, start, [end, 0.1], &task));
        assert!(said.contains(&format!(" ({kind}), sum ")), "{start:?}: {said}");
    }
}

/// A linear oscillator under a drive has one attractor, of period 1, however long it takes.
#[test]
fn a_motion_that_is_still_settling_is_not_said_to_have_no_period() {
    let said = |b: f64, study: &str| {
        let system = format!(
            "name = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = {b:?} }}\n[drive]\n\
             force = [\"0.3*cos(1.3*t)\"]"
        );
        let task = format!(
            "[study.{study}]\nmethods = [\"moddg\"]\nsteps = [0.1]\ntransient = 20\npoints = 60\n"
        );
        let values = if study == "bifurcation" {
            "parameter = { name = \"k\", from = 1.0, to = 1.1, count = 2 }"
        } else {
            ""
        };
        studied(&scene(&system, [1.0, 0.0], [100.0, 0.1], &(task + values)))
    };
    let slow = said(0.02, "poincare");
    assert!(slow.contains("reference: still settling; moddg"), "{slow}");
    assert!(
        slow.contains("still settling, as the reference") && slow.contains("A longer transient")
    );
    let settled = said(0.4, "poincare");
    assert!(settled.contains("period 1, as the reference"), "{settled}");
    assert!(!settled.contains("transient"), "{settled}");
    let diagram = said(0.02, "bifurcation");
    assert!(diagram.contains("reference: period none yet throughout"), "{diagram}");
}

#[test]
fn a_resonance_without_a_steady_motion_has_no_numbers() {
    let ueda = "name = \"duffing\"\nparameters = { alpha = 0.0, beta = 1.0, c = 0.05 }\n[drive]\n\
                force = [\"7.5*cos(omega*t)\"]\nparameters = { omega = 1.0 }";
    let task = "[study.resonance]\nmethods = [\"rk4\"]\ntransient = 20\n\
                parameter = { name = \"omega\", from = 1.0, to = 1.02, count = 2 }";
    let said = studied(&scene(ueda, [2.5, 0.0], [1.0, 0.1], task));
    let each = "none of 4 motions is steady";
    assert_eq!(said, format!("reference: {each}; rk4, h = 0.1000: {each}."));
}

/// A run that fails in its first step has no state but the first, and K of that is no result.
#[test]
fn a_run_without_a_step_has_no_deviation() {
    let barrier = "name = \"custom\"\npotential = \"1/q1\"\ndissipation = [\"0.1*p1\"]";
    for (methods, words, off) in [
        ("\"moddg\", \"leapfrog\"", "1 of 2 runs", " K is off by leapfrog "),
        ("\"moddg\"", "0 of 1 runs", ""),
    ] {
        let task = format!("[run]\nmethods = [{methods}]");
        let scene = scene(barrier, [0.01, -100.0], [1.0, 1.0], &task);
        let (_, findings) = experiment::run(&scene, &Silent).expect("it runs");
        let said = &findings[0].statement;
        assert!(said.contains(&format!("{words} reached the end.{off}")), "{said}");
        assert!(!said.contains("moddg"), "{said}");
        assert_eq!(said.contains("K is off"), !off.is_empty(), "{said}");
    }
}
