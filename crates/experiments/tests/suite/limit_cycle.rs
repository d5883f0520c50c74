//! Limit cycles: published figures of Van der Pol's, closed forms, and the bifurcations of
//! branches.

mod branches;

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::limit_cycle::{Branch, Cycle, Cycles, Event, LimitCycle, columns};
use afterbay_experiments::artifact::Artifact;
use afterbay_experiments::report::Verdict;
use afterbay_experiments::scene::Scene;
use afterbay_experiments::{Finding, experiment};
use afterbay_methods::registry::{REFERENCE, Row, find};
use std::f64::consts::TAU;

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

fn branch(of: LimitCycle, parameter: &str, [from, to]: [f64; 2], doublings: usize) -> LimitCycle {
    LimitCycle { branch: Some(Branch { parameter: parameter.into(), from, to, doublings }), ..of }
}

fn close(what: &str, found: f64, exact: f64, most: f64) {
    assert!((found - exact).abs() < most, "{what}: {found:?}, not {exact:?}");
}

/// Period, amplitude and nontrivial multiplier as printed by `data/van_der_pol.py`.
const VAN_DER_POL: [(f64, [f64; 3]); 3] = [
    (0.05, [6.284_166_990_920_168, 2.000_026_029_991_155_6, 0.730_330_987_613_458_9]),
    (1.0, [6.663_286_859_323_13, 2.008_619_860_874_843, 8.596_950_636_038_052e-4]),
    (2.0, [7.629_874_479_674_842, 2.019_891_384_667_136_6, 1.273_849_304_439_408_3e-8]),
];

#[test]
fn van_der_pols_cycle_has_its_published_figures() {
    for (mu, [period, amplitude, multiplier]) in VAN_DER_POL {
        let found =
            only(&study(van_der_pol(mu), 30.0 / mu).run(&REFERENCE, 0.02, &Silent).unwrap());
        close("period", found.period, period, 1e-12);
        close("amplitude", found.amplitude[0], amplitude, 1e-12);
        let [[own, 0.0]] = found.nontrivial()[..] else { panic!("{found:?}") };
        close("multiplier", own, multiplier, 1e-13);
        assert!(found.is_stable());
        let trivial = found.multipliers.iter().map(|[re, im]| (re - 1.0).hypot(*im));
        assert!(trivial.fold(f64::INFINITY, f64::min) < 1e-11, "{:?}", found.multipliers);
        let steps = found.period / found.h;
        close("steps", steps, steps.round(), 1e-9);
    }
}

/// T = 2π (1 + μ²/16 - 5 μ⁴/3072 + ...): C. M. Andersen and J. F. Geer, SIAM J. Appl. Math. 42
/// (1982) 678-693.
#[test]
fn a_weakly_nonlinear_cycle_has_the_period_of_its_expansion() {
    for mu in [0.1, 0.2] {
        let found = only(&study(van_der_pol(mu), 20.0 / mu).run(&REFERENCE, 0.1, &Silent).unwrap());
        let second = mu * mu / 16.0;
        close("period", found.period, TAU * (1.0 + second), 0.02 * mu.powi(4));
        let fourth = 5.0 * mu.powi(4) / 3072.0;
        close("period", found.period, TAU * (1.0 + second - fourth), 0.01 * mu.powi(6));
    }
}

#[test]
fn the_period_of_a_second_order_method_is_off_by_h_squared() {
    let exact = VAN_DER_POL[1].1[0];
    for method in ["moddg", "leapfrog", "gonzalez"] {
        let off = |h: f64| {
            let found = only(&study(van_der_pol(1.0), 30.0).run(row(method), h, &Silent).unwrap());
            ((found.period - exact).abs().ln(), found.h.ln())
        };
        let [(coarse, h), (fine, h_fine)] = [off(0.1), off(0.025)];
        close(method, (coarse - fine) / (h - h_fine), 2.0, 0.1);
    }
}

/// The steady state of q'' + b q' + q = f cos ωt has the amplitude f/|1 - ω² + iωb|, and the
/// multipliers are exp of T times the eigenvalues of the free oscillator.
#[test]
fn a_driven_linear_oscillator_has_its_closed_form() {
    let (b, f, omega): (f64, f64, f64) = (0.3, 0.8, 1.7);
    let drive = format!(
        "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = {{ f = {f:?}, omega = {omega:?} }}"
    );
    let study = study(oscillator(b, &drive), 200.0);
    let found = only(&study.run(&REFERENCE, 0.05, &Silent).unwrap());
    assert_eq!((found.multiple, found.period), (Some(1), TAU / omega));
    close("amplitude", found.amplitude[0], f / (1.0 - omega * omega).hypot(omega * b), 1e-12);
    let turn = (1.0 - b * b / 4.0).sqrt() * found.period;
    let size = (-b / 2.0 * found.period).exp();
    let exact = [
        [size * turn.cos(), size * turn.sin().abs()],
        [size * turn.cos(), -size * turn.sin().abs()],
    ];
    for (found, exact) in found.multipliers.iter().flatten().zip(exact.iter().flatten()) {
        close("multiplier", *found, *exact, 1e-12);
    }
    // Three periods in a cycle of one are one.
    let thrice = LimitCycle { multiple: Some(3), ..study };
    assert_eq!(only(&thrice.run(&REFERENCE, 0.05, &Silent).unwrap()).multiple, Some(1));
}

#[test]
fn a_motion_without_a_limit_cycle_is_named() {
    let outcome = |problem: Problem, method: &str, transient: f64| {
        let found = study(problem, transient).run(row(method), 0.1, &Silent).unwrap();
        assert!(found.points.is_empty());
        let failed = found.rows(None, 1);
        assert_eq!((failed.len(), failed[0].period), (1, None));
        assert_eq!(failed[0].outcome, found.ending.outcome);
        found.ending
    };
    let conservative = outcome(oscillator(0.0, ""), "moddg", 50.0);
    assert_eq!(conservative.outcome, "not-isolated");
    assert!(conservative.failure.unwrap().contains("closed orbits of a conservative system"));
    // Each of two oscillators has its limit cycle, and any phase between them is one of both.
    let text = "[system]\nname = 'custom'\npotential = 'q1^2/2 + q2^2/2'\n\
                dissipation = ['(q1^2 - 1)*v1', '(q2^2 - 1)*v2']\n[initial]\nq = [2, 1]\n\
                p = [0, 1]\n[time]\nend = 1.0\nstep = 0.1\n";
    let apart = outcome(Scene::read(text).unwrap().problem, "increment-2", 50.0);
    assert_eq!(apart.outcome, "not-isolated");
    assert!(apart.failure.unwrap().contains("parts that do not act on each other"));
    let system = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 1.0, c = 0.0 }";
    assert_eq!(outcome(problem(system, "", [1.0, 0.0]), "moddg", 50.0).outcome, "not-isolated");
    let overdamped = outcome(oscillator(3.0, ""), "rk4", 100.0);
    assert_eq!(overdamped.outcome, "at-rest");
    assert!(overdamped.failure.unwrap().contains("rest is not a cycle"));
    assert_eq!(outcome(oscillator(0.1, ""), "moddg", 50.0).outcome, "no-return");
    // A slow spiral comes close to where it was, but no cycle is there.
    assert_eq!(outcome(oscillator(1e-3, ""), "moddg", 50.0).outcome, "not-converged");
    let ueda = duffing([0.0, 1.0, 0.05, 7.5, 1.0], [2.5, 0.0]);
    let chaotic = outcome(ueda, "moddg", 100.0);
    assert_eq!(chaotic.outcome, "no-return");
    assert!(chaotic.failure.unwrap().contains("within 64 periods of the system in time"));
    let wild = outcome(duffing([0.0, 1.0, 0.05, 1e6, 1.0], [2.5, 0.0]), "rk4", 100.0);
    assert_eq!(wild.outcome, "not-finite");
}

/// The amplitude is max |q|: of an oscillator about q = 3 in closed form. Of a pendulum that turns
/// at the rate Ω, q - Ω t is nearly sin(Ω t)/Ω², wherever the transient ends.
#[test]
fn the_amplitude_is_without_turns() {
    let custom = |system: &str| format!("name = \"custom\"\n{system}");
    let away = custom("potential = \"(q1 - 3)^2/2\"\ndissipation = [\"0.3*p1\"]");
    let away = problem(&away, "[drive]\nforce = [\"cos(1.7*t)\"]", [3.0, 0.0]);
    let found = only(&study(away, 150.0).run(&REFERENCE, 0.1, &Silent).unwrap());
    let exact = f64::hypot(1.0 - 1.7 * 1.7, 0.3 * 1.7).recip();
    close("amplitude", found.amplitude[0], 3.0 + exact, 1e-12);
    let turning = custom("potential = \"-cos(q1)\"\ndissipation = [\"0.1*v1 - 0.5\"]");
    let turning = problem(&turning, "", [0.0, 5.0]);
    let [short, long] = [100.0, 150.0].map(|transient| {
        only(&study(turning.clone(), transient).run(row("rk4"), 0.02, &Silent).unwrap())
    });
    close("period", short.period, TAU / 5.0, 0.01);
    close("amplitude", short.amplitude[0], (short.period / TAU).powi(2), 1e-3);
    close("amplitude", short.amplitude[0], long.amplitude[0], 1e-7);
    // The torque in V.
    let tilted = custom("potential = \"-cos(q1) - 0.5*q1\"\ndissipation = [\"0.1*v1\"]");
    let tilted = study(problem(&tilted, "", [0.0, 5.0]), 100.0);
    let same = only(&tilted.run(row("rk4"), 0.02, &Silent).unwrap());
    close("period", same.period, short.period, 1e-12);
    close("amplitude", same.amplitude[0], short.amplitude[0], 1e-12);
}

/// A run with coarse steps comes near its own start on a chord only after some turns.
#[test]
fn coarse_steps_have_the_cycle_of_one_turn() {
    let period = VAN_DER_POL[1].1[0];
    let found =
        only(&study(van_der_pol(1.0), 60.0).run(row("collocation-8"), 0.8, &Silent).unwrap());
    close("period", found.period, period, 1e-4);
    let turning = "name = \"custom\"\npotential = \"-cos(q1) - 1.4*q1\"\n\
                   dissipation = [\"0.1*p1\"]";
    let turning = problem(turning, "", [0.0, 8.0]);
    for h in [0.12, 0.08] {
        let found = only(&study(turning.clone(), 100.0).run(row("gonzalez"), h, &Silent).unwrap());
        close("period", found.period, TAU / 14.0, 0.005);
    }
}

/// As printed by `data/van_der_pol.py` for other values of mu.
#[test]
fn a_multiplier_below_the_roundings_is_computed_or_left_out() {
    let found = only(&study(van_der_pol(4.0), 40.0).run(&REFERENCE, 0.05, &Silent).unwrap());
    let [[own, 0.0]] = found.nontrivial()[..] else { panic!("{found:?}") };
    close("multiplier", own / 1.275_474_052_782_661_3e-25, 1.0, 1e-8);
    // All but the first of four, by a second oscillator with multipliers exp(-3 T) and exp(-5 T).
    let text = "[system]\nname = \"custom\"\npotential = \"q1^2/2 + 7.5*q2^2\"\n\
                dissipation = [\"-4*(1 - q1^2)*p1\", \"8*p2\"]\n[initial]\nq = [2.0, 0.1]\n\
                p = [0.0, 0.0]\n[time]\nend = 40.0\nstep = 0.1\n[study.limit-cycle]\n\
                methods = [\"rk4\"]\nsteps = [0.05]\nreference = false\n";
    let (said, files) = studied(text);
    assert!(said.statement.contains("stable (largest multiplier below "), "{}", said.statement);
    let table = files.iter().find(|file| file.name == "data/limit_cycle.csv").unwrap();
    let row = table.text.lines().nth(1).unwrap();
    assert!(row.ends_with(",,,,,,,completed,"), "{row}");
}

#[test]
fn the_table_has_its_columns() {
    let problem = van_der_pol(1.0);
    let names = "method,h,parameter,value,period,amplitude_1,multiplier_1_re,multiplier_1_im,\
                 multiplier_2_re,multiplier_2_im,outcome,event";
    let header = columns(&problem.model);
    assert_eq!(header.join(","), names);
    let study = branch(study(problem, 30.0), "mu", [1.0, 1.1], 0);
    let found = study.run(row("moddg"), 0.1, &Silent).unwrap();
    let rows = found.rows(Some("mu"), 1);
    let table = Artifact::wide_table("limit_cycle", &header, &rows).unwrap();
    assert_eq!(table.text.lines().count(), found.points.len() + 1);
    assert!(table.text.lines().nth(1).unwrap().starts_with("moddg,0."), "{}", table.text);
}

/// The study of a scene: its finding and its files.
fn studied(text: &str) -> (Finding, Vec<Artifact>) {
    let scene = Scene::read(text).unwrap_or_else(|error| panic!("{error}"));
    let (output, mut findings) = experiment::study(&scene, &Silent).unwrap();
    (findings.remove(0), output.artifacts)
}

#[test]
fn a_scene_declares_the_study() {
    let scene = "[system]\nname = \"van-der-pol\"\nparameters = { mu = 1.0 }\n\
                 [initial]\nq = [2.0]\np = [0.0]\n[time]\nend = 40.0\nstep = 0.1\n\
                 [study.limit-cycle]\nmethods = [\"moddg\"]\n";
    let (found, files) = studied(scene);
    assert_eq!(found.verdict, Verdict::Note);
    let begin = "reference: period 6.663287, amplitude 2.008620, stable (largest multiplier \
                 8.6e-4); moddg, h = 0.1000: period 6.6";
    assert!(found.statement.starts_with(begin), "{}", found.statement);
    let table = files.iter().find(|file| file.name == "data/limit_cycle.csv").unwrap();
    assert_eq!(table.text.lines().count(), 3);
    let along = format!("{scene}parameter = {{ name = \"mu\", from = 1.0, to = 1.2 }}\n");
    let (found, files) = studied(&along);
    assert!(found.statement.contains("bifurcations: none"), "{}", found.statement);
    assert!(files.iter().any(|file| file.name == "figures/limit-cycle.svg"), "no chart");
    let (found, _) = studied(&scene.replace("mu = 1.0", "mu = -1.0").replace("[2.0]", "[0.5]"));
    assert_eq!(found.verdict, Verdict::Fails);
    assert!(found.statement.contains("no cycle (at-rest)"), "{}", found.statement);
}

#[test]
fn a_scene_that_is_not_valid_is_refused() {
    let scene = |table: &str| {
        format!(
            "[system]\nname = \"van-der-pol\"\nparameters = {{ mu = 1.0 }}\n[initial]\nq = [2.0]\n\
             p = [0.0]\n[time]\nend = 40.0\nstep = 0.1\n[study.limit-cycle]\n\
             methods = [\"moddg\"]\n{table}\n"
        )
    };
    for (table, problem) in [
        ("periods = 2", "the system does not depend on the time"),
        ("transient = 0.0", "positive"),
        ("parameter = { name = \"mu\", from = 1.0, to = 1.0 }", "another value than `from`"),
        ("parameter = { name = \"nu\", from = 1.0, to = 2.0 }", "nu"),
        ("points = 3", "points"),
    ] {
        let error = Scene::read(&scene(table)).unwrap_err().to_string();
        assert!(error.contains(problem), "{table}: {error}");
    }
}

/// Oscillators in step move as one of them does, and each has its multipliers among those of the
/// ring.
#[test]
fn a_ring_in_step_has_the_cycle_of_one_oscillator() {
    let text = "[system]\nname = \"van-der-pol-ring\"\nparameters = { n = 3, mu = 1.0, coupling = \
                0.3 }\n[initial]\nq = [2.0, 2.0, 2.0]\np = [0.0, 0.0, 0.0]\n[time]\nend = 1.0\n\
                step = 0.1\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let found = only(&study(problem, 30.0).run(&REFERENCE, 0.05, &Silent).unwrap());
    let [period, amplitude, multiplier] = VAN_DER_POL[1].1;
    close("period", found.period, period, 1e-11);
    assert_eq!((found.amplitude.len(), found.multipliers.len()), (3, 6));
    found.amplitude.iter().for_each(|found| close("amplitude", *found, amplitude, 1e-11));
    for exact in [1.0, multiplier] {
        let off = found.multipliers.iter().map(|[re, im]| (re - exact).hypot(*im));
        assert!(off.fold(f64::INFINITY, f64::min) < 1e-10, "{exact}: {:?}", found.multipliers);
    }
}

/// Periods and multipliers of -0.01 v + 0.01 v³ in 12 digits, from series between the kinks.
#[test]
fn cycles_across_kinks_have_their_multipliers() {
    for (potential, [period, multiplier], most) in [
        ("q1^2/2 + 10*max(q1 - 1, 0)^2", [5.776_933_100_982_8, 0.936_666_223_674_3], 1e-11),
        ("q1^2/2 + 0.5*abs(q1)", [4.734_478_369_791_2, 0.960_403_235_795_7], 1e-11),
        // The second derivative of V has no bound beside this kink.
        ("q1^2/2 + 10*max(q1 - 1, 0)^1.5", [5.572_631_689_361, 0.936_132_649_9], 1e-6),
    ] {
        let system = format!(
            "name = \"custom\"\npotential = \"{potential}\"\n\
             dissipation = [\"-0.01*v1 + 0.01*v1^3\"]"
        );
        let near = study(problem(&system, "", [1.0, 0.57]), 50.0);
        let found = only(&near.run(&REFERENCE, 0.02, &Silent).unwrap());
        close(potential, found.period, period, most);
        close(potential, found.multipliers[0][0], 1.0, most);
        close(potential, found.multipliers[1][0], multiplier, most);
    }
}

/// Newton's method converges although one coordinate still decays when the search begins.
#[test]
fn a_cycle_is_found_beside_a_decaying_coordinate() {
    let text = "[system]\nname = \"custom\"\npotential = \"q1^2/2 + 2*q2^2\"\n\
                dissipation = [\"-(1 - q1^2)*v1\", \"0.3*v2\"]\n[initial]\n\
                q = [2.0, 0.5]\np = [0.0, 0.1]\n[time]\nend = 1.0\nstep = 0.1\n";
    let [period, amplitude, multiplier] = VAN_DER_POL[1].1;
    for transient in [90.0, 100.0, 110.0, 130.0] {
        let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
        let found = only(&study(problem, transient).run(&REFERENCE, 0.05, &Silent).unwrap());
        close("period", found.period, period, 1e-10);
        close("amplitude", found.amplitude[0], amplitude, 1e-10);
        let off = found.multipliers.iter().map(|[re, im]| (re - multiplier).hypot(*im));
        assert!(off.fold(f64::INFINITY, f64::min) < 1e-9, "{:?}", found.multipliers);
    }
}
