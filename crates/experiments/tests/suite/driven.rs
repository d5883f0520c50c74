//! Driven scenes: the three energies against closed forms, tables, and parameters of the drive.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::trajectory::Steps;
use afterbay_analysis::study::work_precision::Runs;
use afterbay_analysis::study::{energy, events, global_order, trajectory, work_precision};
use afterbay_core::accounts;
use afterbay_experiments::artifact::Artifact;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::{ADAPTIVE, METHODS, Row, find};
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

/// The error of w is that of the energy dissipated in every table, not that of the energy supplied.
#[test]
fn the_error_of_w_is_the_same_in_every_table() {
    let (problem, methods) = (resonance(1.3, 3.0).problem, rows(&["moddg", "rk4"]));
    let h = problem.end / (3.0 * STEPS);
    let energies = energy::run(&problem, &methods, h, 1, &Silent).unwrap();
    let runs = Runs { methods: &methods, steps: &[h], ..Runs::default() };
    let costs = work_precision::run(&problem, runs, &Silent).unwrap();
    let orders = global_order::run(&problem, &methods, &[h], &Silent).unwrap();
    let of_w = |method| {
        let mut rows = orders.iter().filter(|row| row.method == method && row.variable == "w");
        rows.next().and_then(|row| row.error)
    };
    for (energy, cost) in energies.iter().zip(&costs) {
        let last = energy.rows.last().unwrap();
        let at_end = cost.error_w.unwrap();
        assert!((at_end - last.w_error.abs()).abs() < 1e-12, "{}: {at_end:e}", energy.method);
        let largest = of_w(energy.method).unwrap();
        assert!((largest - energy.w.error).abs() < 1e-12, "{}: {largest:e}", energy.method);
    }
}

/// The states at q and at q plus its period are the same for the forces of the drive, too.
#[test]
fn a_coordinate_has_a_period_only_if_the_drive_has_it() {
    let turn = Some(2.0 * PI);
    for (potential, force, periods) in [
        ("-cos(q1)", &["cos(t)"][..], &[turn][..]),
        ("-cos(q1)", &["cos(t - q1) + sin(2*q1)"], &[turn]),
        ("-cos(2*q1)", &["cos(t)"], &[Some(PI)]),
        ("-cos(2*q1)", &["cos(t + q1)"], &[turn]),
        ("-cos(3*q1)", &["cos(t + q1) + cos(q1/2)"], &[Some(4.0 * PI)]),
        ("-cos(q1)", &["cos(t) + 0.01*q1"], &[None]),
        ("-cos(q1)", &["cos(t) + 1e-9*q1"], &[None]),
        // Small forces, as in SI units.
        ("-cos(q1)", &["1e-12*(cos(t) + 0.01*q1)"], &[None]),
        ("-cos(q1)", &["1e-12*cos(t - q1)"], &[turn]),
        ("-cos(q1)", &["cos(t + q1*sqrt(2))"], &[None]),
        ("-cos(q1)", &["t*exp(-q1^2)"], &[None]),
        ("-cos(q1) - cos(q2)", &["cos(t)", "0"], &[turn, turn]),
        ("-cos(q1) - cos(q2)", &["q2*cos(t)", "cos(q1/3)"], &[Some(6.0 * PI), None]),
    ] {
        let zeros = vec![0.0; periods.len()];
        let scene = Scene::read(&format!(
            "[system]\nname = \"custom\"\npotential = \"{potential}\"\n[drive]\n\
             force = {force:?}\n[initial]\nq = {zeros:?}\np = {zeros:?}\n[time]\nend = 1.0\n\
             step = 0.1\n"
        ));
        let found =
            scene.unwrap_or_else(|error| panic!("{force:?}: {error}")).problem.model.periods();
        for (found, exact) in found.iter().zip(periods) {
            let off = found.unwrap_or(0.0) - exact.unwrap_or(0.0);
            assert!(off.abs() < 1e-14, "{potential}, {force:?}: {found:?}, not {exact:?}");
        }
        assert_eq!(found.len(), periods.len());
    }
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
            let found = accounts(state, &scene.problem.model.motors()).unwrap();
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

/// q, p and s of q'' + B q' + q = f sign(cos t) from (0.3, -0.2) at a time of at most 40, from the
/// flow of each half period.
fn under_a_square_wave(force: f64, end: f64) -> [f64; 3] {
    let (a, nu) = (B / 2.0, (1.0 - B * B / 4.0).sqrt());
    let ([mut q, mut p, mut s], mut t, mut side) = ([0.3, -0.2, 0.0], 0.0, 1.0);
    for k in 0..13 {
        let jump = (f64::from(k) + 0.5) * PI;
        let h = jump.min(end) - t;
        let (sin, cos) = (nu * h).sin_cos();
        let (x, decay) = (q - side * force, (-a * h).exp());
        let next = side * force + decay * (x * cos + (p + a * x) / nu * sin);
        p = decay * (p * cos - (a * p + x) / nu * sin);
        s += side * force * (next - q);
        (q, t, side) = (next, t + h, -side);
        if t >= end {
            break;
        }
    }
    [q, p, s]
}

/// Parameters that are computed from a varied one follow it, those of the drive and those of the
/// system.
#[test]
fn computed_parameters_follow_a_varied_one_under_a_drive() {
    let scene = |w0: f64| {
        let text = format!(
            "[system]\nname = \"custom\"\npotential = \"k*q1^2/2\"\ndissipation = [\"c*v1\"]\n\
             parameters = {{ k = \"w0^2\", c = \"2*z*w0\", w0 = {w0:?}, z = 0.05 }}\n\
             [drive]\nforce = [\"c*sin(k*t) + f\"]\nparameters = {{ f = \"w0/2\" }}\n\
             [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 10\nstep = 0.05\n\
             [study.bifurcation]\nmethods = [\"rk4\"]\npoints = 4\ntransient = 3\n\
             parameter = {{ name = \"w0\", from = 0.8, to = 1.2, count = 2 }}\n"
        );
        Scene::read(&text).unwrap_or_else(|error| panic!("{error}"))
    };
    let slopes = |model: &Model| {
        let (system, (q, p)) = (model.system::<f64>().unwrap(), ([0.3, 1.7], [0.2, 0.1]));
        let [mut hq, mut v, mut d] = [[0.0; 2]; 3];
        system.gradient(&q, &p, &mut hq, &mut v);
        system.dissipation(&q, &p, &v, &mut d);
        [hq, v, d]
    };
    let varied = scene(1.2).problem.model.with("w0", 0.8).unwrap();
    assert_eq!(slopes(&varied), slopes(&scene(0.8).problem.model));
    assert_ne!(slopes(&varied), slopes(&scene(1.2).problem.model));
}

#[test]
fn a_force_that_jumps_is_followed_to_rounding() {
    for force in [F, 1e6] {
        a_jump_is_followed(force);
    }
}

fn a_jump_is_followed(force: f64) {
    let end = 20.3;
    let mut scene = resonance(1.0, 1.0);
    scene.problem = Scene::read(&format!(
        "[system]\nname = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = {B} }}\n\
         [drive]\nforce = \"{force:?}*sign(cos(t))\"\n[initial]\nq = [0.3]\np = [-0.2]\n\
         [time]\nend = {end:?}\nstep = 0.01\n"
    ))
    .unwrap()
    .problem;
    let problem = &scene.problem;
    let size = (force / F).max(1.0);
    let exact = under_a_square_wave(force, end);
    let reference = problem.solution(end, 1, &Silent).unwrap();
    let state = reference.at(1);
    let found = [state.q[0], state.p[0], accounts(state, &problem.model.motors()).unwrap().s[0]];
    for ((found, exact), size) in found.iter().zip(exact).zip([size, size, size * size]) {
        assert!((found - exact).abs() < 2e-14 * size, "the reference: {found}, not {exact}");
    }
    let adaptive: Vec<_> = ADAPTIVE.iter().collect();
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let runs = Runs { adaptive: &adaptive, tolerances: &[tolerance], ..Runs::default() };
        for row in work_precision::run(problem, runs, &Silent).unwrap() {
            let name = format!("{} at {tolerance:e}, force {force:e}", row.method);
            let (qp, w) = (row.error_qp.expect(&name), row.error_w.expect(&name));
            assert!(qp < 10.0 * tolerance * size, "{name}: {qp:e}");
            assert!(w < 10.0 * tolerance * size * size, "{name}: w {w:e}");
            // A projection leaves up to 2 roundings of the energy supplied, and there are 250
            // steps.
            let k = row.k_drift / exact[2].abs();
            assert!(k < 1.5e-14, "{name}: K is off by {k:e} of its largest term");
        }
    }
}

/// The jumps of these forces are at the roundings of an argument, of which those at t = 0 are far
/// above the roundings of t, or the force has a value of its own at t = 0.
#[test]
fn a_jump_at_a_rounding_of_its_argument_is_passed() {
    type Force = fn(f64) -> f64;
    let whole = |from: i32| (from..5).map(f64::from).collect::<Vec<_>>();
    let half_turns = |omega: f64| (1..3).map(|k| f64::from(k) * PI / omega).collect::<Vec<_>>();
    let forces: [(&str, Force, Vec<f64>); 7] = [
        ("floor(cos(t))", |t| t.cos().floor(), vec![PI / 2.0, 1.5 * PI]),
        ("floor(1 + t)", |t| (1.0 + t).floor(), whole(1)),
        ("floor(2 - t)", |t| (2.0 - t).floor(), whole(1)),
        ("floor(1e6 + t) - 1e6", f64::floor, whole(1)),
        ("sign(ln(1 + t))", f64::signum, vec![]),
        (
            "sign(sin(1.3*t))*floor(1 + t)",
            |t| (1.3 * t).sin().signum() * (1.0 + t).floor(),
            [whole(1), half_turns(1.3)].concat(),
        ),
        (
            "sign(sin(1.3*t)) + floor(1 + t)",
            |t| (1.3 * t).sin().signum() + (1.0 + t).floor(),
            [whole(1), half_turns(1.3)].concat(),
        ),
    ];
    let end = 5.0;
    for (text, force, mut times) in forces {
        times.extend([0.0, end]);
        times.sort_by(f64::total_cmp);
        let (mut q, mut p) = (1.0, 0.0);
        for part in times.windows(2) {
            // A rotation about the place of rest under the force.
            let (rest, (sin, cos)) =
                (force(part[0].midpoint(part[1])), (part[1] - part[0]).sin_cos());
            (q, p) = (rest + (q - rest) * cos + p * sin, p * cos - (q - rest) * sin);
        }
        let problem = Scene::read(&format!(
            "[system]\nname = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = 0.0 }}\n\
             [drive]\nforce = \"{text}\"\n[initial]\nq = [1.0]\np = [0.0]\n\
             [time]\nend = {end:?}\nstep = 0.01\n"
        ))
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .problem;
        for row in ADAPTIVE {
            for tolerance in [1e-4, 1e-8, 1e-11] {
                let steps = Steps { h: end, every: 1, tolerance: Some(tolerance) };
                let (found, _) = events::run(&problem, row, steps, &[], &Silent).unwrap();
                let name = format!("{text}, {} at {tolerance:e}", row.name);
                assert!(found.ending.is_completed(), "{name}: {:?}", found.ending);
                let last = found.rows.last().unwrap();
                let off = (last.q[0] - q).hypot(last.p[0] - p);
                // cos(t) is 1 up to t = 1.1e-8, and 1e6 + t is rounded to 1.2e-10.
                let rounding = match text {
                    "floor(cos(t))" => 1.1e-8,
                    "floor(1e6 + t) - 1e6" => 1e-9,
                    _ => 0.0,
                };
                assert!(off < 10.0 * tolerance + rounding, "{name}: off by {off:e}");
            }
        }
    }
}

/// The reference of the studies of attractors steps from jump to jump, wherever its steps end.
#[test]
fn the_reference_of_a_section_steps_from_jump_to_jump() {
    for steps in [64, 71] {
        let h = 2.0 * PI / f64::from(steps);
        let scene = Scene::read(&format!(
            "[system]\nname = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = {B} }}\n\
             [drive]\nforce = \"{F}*sign(cos(t))\"\n[initial]\nq = [0.3]\np = [-0.2]\n\
             [time]\nend = {h:?}\nstep = {h:?}\n\
             [study.poincare]\nmethods = [\"rk4\"]\ntransient = 0\npoints = 5\n"
        ))
        .unwrap();
        let plan = scene.studies.poincare.as_ref().unwrap();
        for (row, h) in plan.settings() {
            let points = plan.study.run(row, h, &Silent).unwrap();
            for (k, point) in points.rows.iter().enumerate() {
                let [q, p, _] = under_a_square_wave(F, 2.0 * PI * (k as f64 + 1.0));
                let off = (point.q[0] - q).hypot(point.p[0] - p);
                let is_reference = row.name == "reference";
                assert_eq!(off < 1e-11, is_reference, "{} {k}: off by {off:e}", row.name);
            }
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
    let runs = energy::run(problem, &rows(&["moddg"]), scene.step, 8, &Silent).unwrap();
    let table = Artifact::wide_table("energy", &energy::columns(&problem.model), &runs[0].rows);
    let table = table.unwrap();
    assert!(table.text.lines().next().unwrap().ends_with("doubt_d_R,w1,s1,supplied"));
    assert_eq!(runs[0].violations, Some(0));
}

/// On a linear system under a sine, `linear-exact` steps over whole periods without an error.
#[test]
fn a_linear_driven_scene_has_an_exact_method() {
    let scene = resonance(1.3, 4.0);
    let (problem, period) = (&scene.problem, scene.problem.end / 4.0);
    let found = trajectory::run(problem, &rows(&["linear-exact"]), period, 1, &Silent).unwrap();
    let exact = problem.solution(period, 4, &Silent).unwrap();
    for (i, row) in found[0].rows.iter().enumerate() {
        let state = exact.at(i);
        let sums = accounts(state, &problem.model.motors()).unwrap();
        for (what, found, exact) in [
            ("q", row.q[0], state.q[0]),
            ("p", row.p[0], state.p[0]),
            ("w", row.w[0], sums.w[0]),
            ("s", row.s[0], sums.s[0]),
            ("K", row.total, found[0].rows[0].total),
        ] {
            assert!((found - exact).abs() < 1e-14, "{what} at {i}: {found:e}, not {exact:e}");
        }
    }
}

/// Every method that applies, by the three studies that know a drive.
#[test]
fn every_method_is_studied() {
    let text = include_str!("../../../../scenes/ueda.toml");
    let mut scene = Scene::read(text).unwrap();
    scene.problem.end = 1.0;
    let applies = |row: &&'static Row| scene.problem.model.bind(row).is_ok();
    let (adaptive, fixed): (Vec<_>, Vec<_>) =
        METHODS.iter().filter(applies).partition(|row| row.is_adaptive());
    assert!(fixed.len() >= 21 && adaptive.len() >= 2, "{} {}", fixed.len(), adaptive.len());
    let runs =
        Runs { methods: &fixed, steps: &[0.02, 0.01], adaptive: &adaptive, tolerances: &[1e-6] };
    let table = work_precision::run(&scene.problem, runs, &Silent).unwrap();
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
        accounts(solution.at(1), &problem.model.motors()).unwrap().s[0]
    };
    assert_eq!(supplied(still), 0.0);
    assert!(supplied(problem.model.clone()).abs() > 0.1);
    assert!(problem.model.with("g", 1.0).is_err());
}
