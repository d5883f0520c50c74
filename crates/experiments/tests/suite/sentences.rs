//! Sentences say what was measured, and no number where nothing was.

use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::pick::{self, Wanted};
use afterbay_experiments::scene::Scene;
use afterbay_experiments::{Finding, experiment};
use std::sync::atomic::{AtomicUsize, Ordering};

fn scene(system: &str, start: [f64; 2], [end, step]: [f64; 2], task: &str) -> Scene {
    let [q, p] = start;
    let text = format!(
        "[system]\n{system}\n[initial]\nq = [{q:?}]\np = [{p:?}]\n[time]\nend = {end:?}\n\
         step = {step:?}\n{task}\n"
    );
    Scene::read(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn studied(scene: &Scene) -> String {
    all_studied(scene)[0].clone()
}

fn all_studied(scene: &Scene) -> Vec<String> {
    let (_, findings) = experiment::study(scene, &Silent).expect("it runs");
    findings.into_iter().map(|finding| finding.statement).collect()
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

/// One point shows no period, and its run did not fail.
#[test]
fn one_point_of_a_motion_is_no_failure() {
    let system = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.4 }\n[drive]\n\
                  force = [\"0.3*cos(1.3*t)\"]";
    let said = |study: &str| {
        let task = format!("[study.{study}\nmethods = [\"rk4\"]\ntransient = 9\npoints = 1\n");
        studied(&scene(system, [1.0, 0.0], [100.0, 0.1], &task))
    };
    let portrait = said("poincare]");
    assert!(portrait.contains("reference: no period within 1 point; rk4"), "{portrait}");
    let diagram =
        said("bifurcation]\nparameter = { name = \"k\", from = 1.0, to = 1.1, count = 2 }");
    assert!(diagram.contains("reference: period none within 1 point throughout; rk4"), "{diagram}");
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

/// K is 0 at the start of a fall, all energies are 0 at rest, and they grow by twelve orders of
/// magnitude from a start near an equilibrium that repels.
#[test]
fn k_is_judged_beside_the_largest_energy_of_a_run() {
    let fall = "name = \"custom\"\npotential = \"9.81*q1\"\ndissipation = [\"0.05*p1*abs(p1)\"]";
    let duffing = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 1.0, c = 0.1 }";
    let cycle = "name = \"van-der-pol\"\nparameters = { mu = 1.0 }";
    for (system, q, lost) in [(fall, 0.0, true), (duffing, 0.0, false), (cycle, 1e-6, true)] {
        let task = "[study.work-precision]\nmethods = [\"moddg\", \"rk4\"]\nsteps = [0.2, 0.1]\n\
                    [study.long-run]\nmethods = [\"moddg\", \"rk4\"]\ncount = 400\n";
        let said = all_studied(&scene(system, [q, 0.0], [40.0, 0.1], task));
        let kept = said.iter().find(|said| said.starts_with("K is kept")).expect("a sentence");
        let (keeps, loses) = kept.split_once(" and not by ").unwrap_or((kept, ""));
        assert!(keeps.contains("moddg (") && !loses.contains("moddg ("), "{kept}");
        assert_eq!([keeps, loses].map(|part| part.contains("rk4 (")), [!lost, lost], "{kept}");
        assert_eq!(loses.is_empty(), !lost, "{kept}");
        let long =
            said.iter().find(|said| said.starts_with("after 400 steps")).expect("a sentence");
        let moddg = long.split("moddg, h = 0.1: ").nth(1).expect("its part");
        let off: f64 = moddg.split(' ').next().and_then(|off| off.parse().ok()).expect("a number");
        assert!(off < 1e-13 && (q != 0.0 || lost || off == 0.0), "{long}");
        for said in &said {
            // Three windows do not show how K grows.
            let said = said.replace("growth not known", "");
            let none = ["inf", "NaN", "not known", "No run"].map(|word| said.contains(word));
            assert_eq!(none, [false; 4], "{said}");
        }
    }
}

/// The states kept are a period apart, so that K and H are nearly the same in all of them.
#[test]
fn k_and_the_rise_of_h_are_those_of_every_step() {
    let oscillator = "name = \"custom\"\npotential = \"k*q1^2/2\"\ndissipation = [\"b*v1\"]\n\
                      parameters = { k = \"(2*pi)^2\", b = 1e-6 }";
    let event = "every = 20\n[run.events.top]\nof = \"p1\"";
    for kept in ["every = 1", "every = 20", "sample = 1.0", event] {
        let study = "[study.energy]\nmethods = [\"gonzalez\"]\nevery = 20";
        let task = format!("[run]\nmethods = [\"leapfrog\"]\n{kept}\n{study}");
        let scene = scene(oscillator, [1.0, 0.0], [4.0, 0.05], &task);
        let (_, findings) = experiment::run(&scene, &Silent).expect("it runs");
        let said = &findings.last().expect("a finding").statement;
        assert!(said.contains("it rises with leapfrog 5e-1. 1 of 1 runs"), "{kept}: {said}");
        assert!(said.contains("K is off by leapfrog 5e-1;"), "{kept}: {said}");
        let balance = studied(&scene);
        assert!(balance.ends_with(", w by 2.4e-6."), "{kept}: {balance}");
    }
}

/// At h = 0.5 the cycle of mu = 0.5 is right but late, those of larger mu are wrong.
#[test]
fn the_first_failure_is_the_worst_of_its_step() {
    let task = |steps: &str, parameter: &str| {
        format!(
            "[study.stability]\nmethods = [\"rk4\"]\nsteps = {steps}\n\
             parameter = {{ {parameter}, count = 3 }}"
        )
    };
    let cycle = "name = \"van-der-pol\"\nparameters = { mu = 1.0 }";
    let steps = task("[0.05, 0.5]", "name = \"mu\", from = 0.5, to = 1.5");
    let said = studied(&scene(cycle, [1.0, 0.0], [60.0, 0.05], &steps));
    assert_eq!(said, "rk4: bounded, wrong at h = 0.500 (2 of 3 values of mu).");
    let stiff = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 1e4 }";
    let steps = task("[0.0004]", "name = \"b\", from = 1.0, to = 1e4");
    let said = studied(&scene(stiff, [1.0, 0.0], [0.1, 0.0004], &steps));
    assert!(said.ends_with(" at h = 4.0e-4 (1 of 3 values of b)."), "{said}");
}

/// Asks to stop once it was asked this number of times.
struct Patient(AtomicUsize);

impl Progress for Patient {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
    fn stopped(&self) -> bool {
        let ask = |left: usize| Some(left.saturating_sub(1));
        self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, ask).is_ok_and(|left| left == 0)
    }
}

/// A study that was interrupted says nothing of the runs that it did not begin.
#[test]
fn runs_that_were_not_begun_neither_fail_nor_differ() {
    let system = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.4 }\n[drive]\n\
                  force = [\"0.3*cos(1.3*t)\"]";
    let diagram = |follow: bool| {
        format!(
            "[study.bifurcation]\nmethods = [\"moddg\"]\nsteps = [0.1]\ntransient = 40\n\
             points = 40\nfollow = {follow}\n\
             parameter = {{ name = \"k\", from = 1.0, to = 1.2, count = 30 }}"
        )
    };
    let basins = "[study.basins]\nmethods = [\"moddg\"]\nsteps = [0.1]\n\
                  grid = { q1 = { from = -1, to = 1, count = 8 }, \
                  p1 = { from = -1, to = 1, count = 8 } }";
    let mut interrupted = 0;
    for task in [diagram(false), diagram(true), basins.to_owned()] {
        let scene = scene(system, [1.0, 0.0], [100.0, 0.1], &task);
        for asked in [0, 3, 30, 60, 100, 300, 1000, 3000] {
            let patient = Patient(AtomicUsize::new(asked));
            let Ok((_, findings)) = experiment::study(&scene, &patient) else { continue };
            let Some(Finding { statement: said, .. }) = findings.first() else { continue };
            interrupted += usize::from(said.contains("interrupted"));
            let whole = ["at 0 of", "another, or none", "failed", "one at", "one in"];
            assert!(whole.iter().all(|words| !said.contains(words)), "{asked}: {said}");
            assert!(!said.contains("that of the reference in 0.0 %"), "{asked}: {said}");
        }
    }
    assert!(interrupted >= 3, "{interrupted}");
}

/// A tolerance is an absolute error where the motion is small: K is kept, but q is not known.
#[test]
fn a_tolerance_above_the_size_of_a_motion_is_named() {
    let said = |size: f64, method: &str| {
        let task = format!("[run]\nmethods = [\"{method}\"]\ntolerance = 1e-6");
        let scene = scene(
            "name = \"custom\"\npotential = \"1 - cos(q1)\"",
            [size, 0.0],
            [10.0, 0.1],
            &task,
        );
        let (_, findings) = experiment::run(&scene, &Silent).expect("it runs");
        findings[0].statement.clone()
    };
    let small = said(1e-7, "adaptive-dop853");
    let named = "The tolerance 1.0e-6 is an absolute error below 1, but |q| is 1.0e-7 at most and \
                 |p| is 1.0e-7 at most.";
    assert!(small.contains(named), "{small}");
    // `adaptive-collocation` runs too if no other method takes the tolerance.
    assert!(said(1e-7, "rk4").contains(named));
    for size in [1.0, 0.01, 0.0] {
        assert!(!said(size, "adaptive-dop853").contains("absolute"), "{size}");
    }
}

#[test]
fn a_wanted_error_above_the_size_of_a_motion_is_named() {
    let wanted = Wanted { error: 1e-6, at_end: true, keep_k: false, passive: false };
    let said = |size: f64| {
        let system = "name = \"custom\"\npotential = \"1 - cos(q1)\"";
        let scene = scene(system, [size, 0.0], [1.0, 0.5], "");
        let found = pick::run(&scene.problem, wanted, &Silent).expect("a search");
        experiment::coarse_error(&found).map(|finding| finding.statement)
    };
    let small = said(1e-7).expect("a warning");
    assert!(
        small.starts_with("The wanted error 1.0e-6 is an absolute error, but |q| is 1.0e-7"),
        "{small}"
    );
    assert_eq!(said(0.01), None);
}

#[test]
fn a_step_that_may_miss_events_is_named() {
    let wanted = Wanted { error: 1e-2, at_end: true, keep_k: false, passive: false };
    let said = |system: &str, step: f64| {
        let task = "[run]\nmethods = [\"rk4\"]\n[run.events.top]\nof = \"p1\"\n";
        let scene = scene(system, [1.0, 0.0], [10.0, step], task);
        let found = pick::run(&scene.problem, wanted, &Silent).expect("a search");
        experiment::longer_step(&scene, &found).map(|finding| finding.statement)
    };
    // `linear-exact` takes one step.
    let oscillator = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.1 }";
    let missed = said(oscillator, 0.1).expect("a warning");
    assert!(
        missed.contains("The step found, 10, is longer than that of the scene, 0.1"),
        "{missed}"
    );
    assert_eq!(said(oscillator, 10.0), None);
}

/// A step that fails is none whose error is a rounding, and a run without a step keeps nothing.
#[test]
fn steps_that_failed_have_no_order_and_no_deviation() {
    let stiff = "name = \"custom\"\npotential = \"q1^4\"\ndissipation = [\"0.1*v1\"]";
    let orders = "[study.local-order]\nmethods = [\"moddg-fixed-point\", \"rk4\"]\n\
                  base_step = 1.0\nsteps = [4.0, 2.0, 1.0]\n";
    let said = studied(&scene(stiff, [3.0, 0.0], [8.0, 1.0], orders));
    let none = "none: failed or below rounding";
    assert!(said.starts_with(&format!("moddg-fixed-point {none} / {none} / {none}; ")), "{said}");
    assert!(said.contains(" Steps that failed: moddg-fixed-point "), "{said}");
    let energy = "[study.energy]\nmethods = [\"moddg-fixed-point\"]\n";
    let said = studied(&scene(stiff, [3.0, 0.0], [8.0, 1.0], energy));
    assert!(said.starts_with("moddg-fixed-point: no step ("), "{said}");
}
