//! Scenes of systems that depend on the time: tables, periods, studies and sections.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::limit_cycle::{Cycle, LimitCycle};
use afterbay_analysis::study::work_precision::Runs;
use afterbay_analysis::study::{energy, events, global_order, trajectory, work_precision};
use afterbay_core::accounts;
use afterbay_experiments::artifact::Artifact;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::{METHODS, Order, REFERENCE, Row, find};
use std::f64::consts::{PI, TAU};

const MATHIEU: &str = include_str!("../../../../scenes/mathieu.toml");

/// Mathieu's equation with friction, under a force too if `drive` is not empty.
fn mathieu(drive: &str, end: f64) -> Scene {
    Scene::read(&format!(
        "[system]\nname = \"custom\"\npotential = \"(a - 2*b*cos(2*t))*q1^2/2\"\n\
         dissipation = [\"c*p1\"]\nparameters = {{ a = 1.0, b = 0.3, c = 0.1 }}\n{drive}\
         [initial]\nq = [1.0]\np = [0.5]\n[time]\nend = {end:?}\nstep = 0.02\n"
    ))
    .unwrap()
}

const FORCE: &str = "[drive]\nforce = \"0.3*cos(t)\"\n";

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| find(name).unwrap()).collect()
}

#[test]
fn tables_have_the_energy_pumped_behind_the_energy_supplied() {
    for drive in ["", FORCE] {
        let scene = mathieu(drive, 4.0);
        let (problem, is_driven) = (&scene.problem, !drive.is_empty());
        assert_eq!((problem.model.degrees(), problem.model.has_clock()), (1, true));
        assert_eq!(problem.model.dof(), 2 + usize::from(is_driven));
        let columns = trajectory::columns(&problem.model);
        let own = if is_driven { "w1,s1,st,H,K" } else { "w1,st,H,K" };
        assert_eq!(columns.join(","), format!("method,step,t,q1,p1,{own}"));
        assert_eq!(
            events::columns(&problem.model).join(","),
            format!("method,event,t,q1,p1,{own}")
        );
        let found = trajectory::run(problem, &rows(&["moddg", "increment-4"]), 0.02, 1, &Silent);
        for run in found.unwrap() {
            for row in &run.rows {
                let stiffness = 1.0 - 0.6 * (2.0 * row.t).cos();
                let h = 0.5 * (row.p[0] * row.p[0] + stiffness * row.q[0] * row.q[0]);
                // The clock adds up the roundings of its substeps.
                let off = (row.energy - h).abs();
                assert!(off < 1e-12, "{}: H is off by {off:e} at t = {}", run.method, row.t);
                let s: f64 = row.s.iter().sum();
                let k = h + row.w[0] - s - row.pumped[0];
                assert!((k - row.total).abs() < 1e-12, "{}: {k:e}", run.method);
                assert!((row.total - run.rows[0].total).abs() < 1e-13, "{}: K", run.method);
            }
            let most = run.rows.iter().map(|row| row.pumped[0].abs()).fold(0.0, f64::max);
            assert!(most > 0.1, "{}: {most}", run.method);
            let table = Artifact::wide_table("trajectory", &columns, &run.rows).unwrap();
            let width = |line: &str| line.split(',').count();
            let mut widths = table.text.lines().map(width);
            assert!(widths.all(|width| width == columns.len()), "{}", run.method);
        }
        let runs = energy::run(problem, &rows(&["moddg"]), 0.02, 8, &Silent).unwrap();
        let columns = energy::columns(&problem.model);
        let last = if is_driven { ",w1,s1,supplied,st" } else { ",w1,st" };
        assert!(columns.join(",").ends_with(last), "{columns:?}");
        drop(Artifact::wide_table("energy", &columns, &runs[0].rows).unwrap());
        assert_eq!(runs[0].violations, Some(0));
        assert!(runs[0].drift < 1e-13, "{:e}", runs[0].drift);
    }
}

/// s_t of the reference, against the trapezoidal rule for ∂V/∂t along it.
#[test]
fn the_energy_pumped_is_the_integral_of_the_change_of_v() {
    const COUNT: usize = 4000;
    let problem = mathieu("", 4.0).problem;
    let h = problem.end / COUNT as f64;
    let solution = problem.solution(h, COUNT, &Silent).unwrap();
    let power = |i: usize| {
        let state = solution.at(i);
        0.6 * (2.0 * state.t).sin() * state.q[0] * state.q[0]
    };
    let integral: f64 = (0..COUNT).map(|i| 0.5 * h * (power(i) + power(i + 1))).sum();
    let pumped = accounts(solution.at(COUNT), &problem.model.motors()).unwrap().pumped.unwrap();
    // The error of the rule is about h² / 12 times the change of the slope of the power.
    assert!((pumped - integral).abs() < h * h, "{pumped}, not {integral}");
    assert!(pumped.abs() > 0.1);
}

#[test]
fn the_period_is_that_of_v_and_the_forces_together() {
    let period = |drive: &str| mathieu(drive, 4.0).problem.model.drive_period();
    let force = |text: &str| format!("[drive]\nforce = \"{text}\"\n");
    let close = |found: Option<f64>, exact: f64| (found.unwrap() - exact).abs() < 1e-14 * exact;
    assert!(close(period(""), PI));
    assert!(close(period(&force("cos(t)")), TAU));
    assert!(close(period(&force("cos(8*t)")), PI));
    assert!(close(period(&force("cos(3*t)")), TAU));
    assert_eq!(period(&force("cos(sqrt(3)*t)")), None);
    assert_eq!(period(&force("exp(-t)")), None);
    let given = format!("{}period = \"2*pi\"\n", force("cos(t)^3"));
    assert!(close(period(&given), TAU));
}

/// Every method that applies, by studies that take systems that depend on the time.
#[test]
fn every_method_is_studied() {
    let mut scene = Scene::read(MATHIEU).unwrap();
    scene.problem.end = 1.0;
    let applies = |row: &&'static Row| scene.problem.model.bind(row).is_ok();
    let (adaptive, fixed): (Vec<_>, Vec<_>) =
        METHODS.iter().filter(applies).partition(|row| row.is_adaptive());
    assert_eq!((fixed.len(), adaptive.len()), (25, 5));
    let runs =
        Runs { methods: &fixed, steps: &[0.02, 0.01], adaptive: &adaptive, tolerances: &[1e-6] };
    let table = work_precision::run(&scene.problem, runs, &Silent).unwrap();
    for row in &table {
        assert_eq!(row.outcome, "completed", "{}", row.method);
        let keeps = find(row.method).unwrap().keeps_k;
        assert!(!keeps || row.k_drift < 1e-12, "{}: K is off by {:e}", row.method, row.k_drift);
        let [qp, w] = [row.error_qp, row.error_w].map(Option::unwrap);
        // A method of order 1 has the error of its step.
        let most = if find(row.method).unwrap().order() == Order::Of(1) { 2e-2 } else { 1e-3 };
        assert!(qp < most && w < most, "{}: {qp:e} {w:e}", row.method);
    }
    let steps = [0.1, 0.05, 0.025];
    drop(global_order::run(&scene.problem, &rows(&["moddg"]), &steps, &Silent).unwrap());
}

/// Methods without a form for these systems say why.
#[test]
fn methods_that_do_not_apply_refuse() {
    let model = mathieu("", 1.0).problem.model;
    for row in METHODS {
        if let Err(error) = model.bind(row) {
            // The variants of modDG for one coordinate speak of modDG.
            let name = row.name.split('-').next().unwrap();
            assert!(error.to_string().contains(name), "{}: {error}", row.name);
        }
    }
    for name in ["linear-exact", "moddg-fixed-point"] {
        assert!(model.bind(find(name).unwrap()).is_err(), "{name}");
    }
    assert!(model.bind_compensated::<f64>(find("increment-2").unwrap()).is_err());
}

#[test]
fn some_studies_refuse_the_time_by_name() {
    let table = "[study.local-order]\nsteps = [0.04, 0.02]\nbase_step = 0.02\n";
    let error = Scene::read(&format!("{MATHIEU}{table}")).unwrap_err().to_string();
    assert!(error.contains("local-order"), "{error}");
    let resonance =
        "[study.resonance]\nparameter = { name = \"a\", from = 1, to = 2, count = 2 }\n";
    let error = Scene::read(&format!("{MATHIEU}{resonance}")).unwrap_err().to_string();
    assert!(error.contains("the system has no drive"), "{error}");
    let drive = "[drive]\nforce = [\"0*cos(t)\"]\n";
    let scene = "[system]\nname = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.1 }\n\
                 [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 2.0\nstep = 0.1\n";
    let resonance = resonance.replace("\"a\"", "\"b\"");
    let error = Scene::read(&format!("{scene}{drive}{resonance}")).unwrap_err().to_string();
    assert!(error.contains("every force in [drive] is 0"), "{error}");
}

/// In the linear equation with a = 1 a state and its double return to states in the same ratio.
#[test]
fn a_stroboscopic_section_has_the_period_of_v() {
    let text =
        "[study.poincare]\nmethods = [\"moddg\"]\nsteps = [0.05]\ntransient = 0\npoints = 3\n";
    let scene = Scene::read(&format!("{MATHIEU}{text}")).unwrap();
    let plan = scene.studies.poincare.as_ref().unwrap();
    let interval = plan.study.section.interval(&scene.problem.model).unwrap();
    assert!((interval - PI).abs() < 1e-14);
}

#[test]
fn parameters_may_change_the_time() {
    let model = mathieu("", 1.0).problem.model;
    assert_eq!(model.parameters(), ["a", "b", "c"]);
    let still: Model = model.with("b", 0.0).unwrap();
    assert!(still.has_clock() && still.dof() == 2);
}

/// The cycle that a run from a state leads to.
fn cycle(system: &str, [q, p]: [f64; 2], method: &'static Row) -> Cycle {
    let scene = Scene::read(&format!(
        "[system]\nname = \"custom\"\n{system}\n[initial]\nq = [{q:?}]\np = [{p:?}]\n\
         [time]\nend = 50.0\nstep = 0.05\n[run]\nmethods = [\"rk4\"]\n"
    ))
    .unwrap();
    let transient = 400.0;
    let study = LimitCycle { problem: scene.problem, transient, multiple: None, branch: None };
    let found = study.run(method, 0.05, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    found.points[0].cycle.clone()
}

/// A swing whose length changes at twice its frequency, and the same torque as a drive.
#[test]
fn a_limit_cycle_under_a_time_in_v_is_that_under_the_same_force() {
    let of_v = "potential = \"(1 + 0.5*cos(2*t))*(1 - cos(q1))\"\ndissipation = [\"0.1*v1\"]";
    let of_drive = "potential = \"1 - cos(q1)\"\ndissipation = [\"0.1*v1\"]\n\
                    [drive]\nforce = [\"-0.5*cos(2*t)*sin(q1)\"]";
    let [a, b] = [of_v, of_drive].map(|system| cycle(system, [0.3, 0.0], &REFERENCE));
    // Twice the period of V.
    assert!((a.period - TAU).abs() < 1e-12 && a.period == b.period, "{} {}", a.period, b.period);
    assert!((a.amplitude[0] - b.amplitude[0]).abs() < 1e-10, "{a:?} {b:?}");
    for (a, b) in a.multipliers.iter().zip(&b.multipliers) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9, "{a:?} {b:?}");
    }
}

/// x'' + c x' + x = f cos t - g cos 2t, of which one force is a drive and the other is -∂V/∂q.
#[test]
fn a_limit_cycle_may_have_a_drive_and_a_time_in_v() {
    let (c, f, g) = (0.1_f64, 0.8, 0.2);
    let system = format!(
        "potential = \"q1^2/2 + {g}*cos(2*t)*q1\"\ndissipation = [\"{c}*v1\"]\n\
         [drive]\nforce = \"{f}*cos(t)\""
    );
    let found = cycle(&system, [0.3, 0.0], &REFERENCE);
    assert!((found.period - TAU).abs() < 1e-12);
    // The steady motion f/c sin t + g ((3 cos 2t - 2 c sin 2t)/(9 + 4 c²)).
    let size = 9.0 + 4.0 * c * c;
    let q =
        |t: f64| f / c * t.sin() + g * (3.0 * (2.0 * t).cos() - 2.0 * c * (2.0 * t).sin()) / size;
    let times = (0..100_000).map(|i| f64::from(i) * TAU / 1e5);
    let amplitude = times.map(|t| q(t).abs()).fold(0.0, f64::max);
    assert!((found.amplitude[0] - amplitude).abs() < 1e-8, "{} {amplitude}", found.amplitude[0]);
    let radius = found.multipliers.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
    assert!((radius - (-c * PI).exp()).abs() < 1e-10, "{radius}");
}

/// Below the threshold of parametric resonance, b = c, the motion decays.
#[test]
fn a_system_at_rest_under_its_time_has_no_cycle() {
    let mut problem = mathieu("", 50.0).problem;
    problem.model = problem.model.with("b", 0.05).unwrap();
    let study = LimitCycle { problem, transient: 1200.0, multiple: None, branch: None };
    let ending = study.run(find("rk4").unwrap(), 0.05, &Silent).unwrap().ending;
    assert_eq!(ending.outcome, "at-rest", "{ending:?}");
}
