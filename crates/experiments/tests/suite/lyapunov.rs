//! Lyapunov exponents: closed forms on linear systems, the sum against the divergence, and
//! published values.

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::lyapunov::{Lyapunov, Spectrum, columns};
use afterbay_experiments::experiment;
use afterbay_experiments::scene::Scene;
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

fn oscillator(k: f64, b: f64) -> Problem {
    let system = format!("name = \"damped-oscillator\"\nparameters = {{ k = {k:?}, b = {b:?} }}");
    problem(&system, "", [1.0, 0.5])
}

/// x'' + c x' + α x + β x³ = f cos t
fn duffing([alpha, beta, c, f]: [f64; 4], start: [f64; 2]) -> Problem {
    let system = format!(
        "name = \"duffing\"\nparameters = {{ alpha = {alpha:?}, beta = {beta:?}, c = {c:?} }}"
    );
    let drive = format!("[drive]\nforce = [\"f*cos(t)\"]\nparameters = {{ f = {f:?} }}");
    problem(&system, &drive, start)
}

fn ueda() -> Problem {
    duffing([0.0, 1.0, 0.05, 7.5], [2.5, 0.0])
}

fn row(name: &str) -> &'static Row {
    find(name).unwrap()
}

pub(crate) fn last(found: &Spectrum) -> (Vec<f64>, f64, f64, f64) {
    let row = found.rows.last().unwrap();
    let sum = row.sum.unwrap();
    (found.exponents().unwrap(), sum, row.mean_log_det.unwrap(), row.mean_divergence.unwrap())
}

/// With k = 1 and b = 3 the two exponents differ. Those of modDG are ln|μ|/h, with μ the
/// eigenvalues of its matrix, and those of the reference are those of the equations.
#[test]
fn an_overdamped_oscillator_has_two_exponents() {
    let (k, b, h) = (1.0, 3.0_f64, 0.1);
    let root = (b * b / 4.0 - k).sqrt();
    let (s, d) = (h * h * k / 4.0, h * b / 2.0);
    // Trace and determinant of the matrix of modDG.
    let (half, det) = ((1.0 - s) / (1.0 + s + d), (1.0 + s - d) / (1.0 + s + d));
    let apart = (half * half - det).sqrt();
    let of_moddg = [half + apart, half - apart].map(|x| x.ln() / h);
    let of_equations = [-b / 2.0 + root, -b / 2.0 - root];
    let study = Lyapunov { problem: oscillator(k, b), transient: 20.0, time: 60.0, rows: 3 };
    for (row, exact) in [(row("moddg"), of_moddg), (&REFERENCE, of_equations)] {
        let found =
            study.run(row, h / if row.name == "moddg" { 1.0 } else { 4.0 }, &Silent).unwrap();
        assert_eq!(found.rows.len(), 3);
        let (exponents, sum, log_det, divergence) = last(&found);
        for (found, exact) in exponents.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-11, "{}: {found:?}, not {exact:?}", row.name);
        }
        assert!((sum - log_det).abs() < 1e-13 && (divergence + b).abs() < 1e-13, "{}", row.name);
        assert!(found.rows[2].standard_errors[0].unwrap() < 1e-11);
        assert_eq!(found.rows[0].standard_errors, [None, None]);
    }
}

pub(crate) fn custom(potential: &str, dissipation: &str, q: &[f64], p: &[f64]) -> String {
    let friction = match dissipation {
        "" => String::new(),
        force => format!("dissipation = \"{force}\"\n"),
    };
    format!(
        "[system]\nname = \"custom\"\npotential = \"{potential}\"\n{friction}[initial]\nq = {q:?}\n\
         p = {p:?}\n[time]\nend = 1.0\nstep = 0.1\n"
    )
}

pub(crate) fn settled(
    potential: &str,
    dissipation: &str,
    q: f64,
    [transient, time]: [f64; 2],
) -> Lyapunov {
    let scene = Scene::read(&custom(potential, dissipation, &[q], &[0.0]));
    let problem = scene.unwrap_or_else(|error| panic!("{error}")).problem;
    Lyapunov { problem, transient, time, rows: 4 }
}

/// A motion that has settled at q = 1 has no momentum left. Its exponents are those of the matrices
/// all the same: λ of the equations for the reference and the exact flow, and ln|R(hλ)|/h with R
/// the Taylor polynomial of degree 4 for rk4.
#[test]
fn an_oscillator_that_has_settled_elsewhere_than_at_0_has_its_exponents() {
    let root = 5.0_f64.sqrt();
    let of_equations = [(-3.0 + root) / 2.0, (-3.0 - root) / 2.0];
    let of_rk4 = of_equations.map(|x| {
        let x = 0.1 * x;
        (1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0)))).ln() / 0.1
    });
    for (well, start) in [(1.0, 0.0), (1.0, 1.0 + 1e-10), (1000.0, 999.0)] {
        let potential = format!("(q1 - {well:?})^2/2");
        let study = settled(&potential, "3*v1", start, [200.0, 100.0]);
        for (row, exact) in
            [(&REFERENCE, of_equations), (row("linear-exact"), of_equations), (row("rk4"), of_rk4)]
        {
            let found = study.run(row, 0.1, &Silent).unwrap();
            let (exponents, sum, log_det, _) = last(&found);
            for (found, exact) in exponents.iter().zip(exact) {
                assert!((found - exact).abs() < 1e-9, "{}: {found:?}, not {exact:?}", row.name);
            }
            let whole = exact[0] + exact[1];
            assert!((sum - whole).abs() < 1e-9, "{}: {sum:?}, not {whole:?}", row.name);
            assert!((log_det - whole).abs() < 1e-9, "{}: {log_det:?}", row.name);
        }
    }
}

/// A pendulum that has turned once before it settles at 2π, a stiff well whose momenta are far
/// larger than its coordinates, and a slow one far away.
#[test]
fn a_settled_motion_has_the_exponents_of_its_rest() {
    for (potential, force, start, times, h, exact, most) in [
        // The vectors turn round: the rate over part of a turn differs by a bounded amount over t.
        ("9.81*(1 - cos(q1))", "0.5*v1", 7.0, [200.0, 400.0], 0.05, [-0.25, -0.5], 3e-3),
        ("(q1 - 1000)^2/2", "0.05*v1", 999.0, [2000.0, 1000.0], 0.1, [-0.025, -0.05], 1e-4),
        // A Jordan block: the largest exponent is -1000 + ln(c t)/t.
        ("1e6*(q1 - 1)^2/2", "2000*v1", 0.0, [0.2, 1.0], 1e-4, [-1000.0, -2000.0], 5.0),
    ] {
        let study = settled(potential, force, start, times);
        let (exponents, sum, ..) = last(&study.run(&REFERENCE, h, &Silent).unwrap());
        let off = (exponents[0] - exact[0]).abs();
        assert!(off < most, "{potential}: {exponents:?}");
        assert!((sum / exact[1] - 1.0).abs() < 1e-8, "{potential}: {sum:?}");
    }
}

/// Neighbours on Kepler's orbits, and near the bottom of Hénon and Heiles's potential, separate
/// like t, so that their exponent over a finite time is above 0 by more than its standard error. At
/// the energy 1/6, and for a driven pendulum, they separate exponentially.
#[test]
fn growth_like_a_power_of_t_is_no_chaos() {
    let kepler = "-1/sqrt(q1^2 + q2^2)";
    let henon = "(q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3";
    let drive = "[drive]\nforce = [\"1.15*cos(2*t/3)\"]\n";
    for (potential, force, start, drive, time, chaos) in [
        (kepler, "", ([1.0, 0.0], [0.0, 1.0]), "", 100.0, false),
        (kepler, "", ([1.0, 0.0], [0.0, 1.0]), "", 1000.0, false),
        (kepler, "", ([1.0, 0.0], [0.0, 0.8]), "", 1000.0, false),
        (henon, "", ([0.05, 0.0], [0.0, 0.1]), "", 2000.0, false),
        (henon, "", ([0.0, -0.15], [0.5356, 0.1]), "", 1000.0, true),
        ("-cos(q1)", "0.5*v1", ([0.5, f64::NAN], [0.0, f64::NAN]), drive, 1000.0, true),
    ] {
        let (q, p) = start;
        let n = if q[1].is_nan() { 1 } else { 2 };
        let text = format!(
            "{}{drive}[study.lyapunov]\nmethods = [\"rk4\"]\ntransient = 100.0\ntime = {time:?}\n\
             reference = false\n",
            custom(potential, force, &q[..n], &p[..n])
        );
        let scene = Scene::read(&text).unwrap_or_else(|error| panic!("{error}"));
        let (_, findings) = experiment::study(&scene, &Silent).unwrap();
        let said = &findings[0].statement;
        assert_eq!(said.contains("(chaos)"), chaos, "{potential}, t = {time}: {said}");
        let honest = said.contains("(0 within the error)")
            || said.contains("(undecided: displacements grow like t^");
        assert_eq!(honest, !chaos, "{potential}, t = {time}: {said}");
    }
}

/// The vectors of an oscillation turn round, so that their rates have the mean -b/2 over half turns
/// and differ from it by a bounded amount divided by t otherwise.
#[test]
fn an_oscillation_has_one_exponent_twice() {
    let b = 0.2;
    let study = Lyapunov { problem: oscillator(1.0, b), transient: 10.0, time: 400.0, rows: 4 };
    let found = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    for row in &found.rows {
        for exponent in &row.exponents {
            assert!((exponent.unwrap() + b / 2.0).abs() < 0.3 / row.t, "{row:?}");
        }
        assert!((row.sum.unwrap() + b).abs() < 1e-12, "{row:?}");
    }
}

/// On a linear oscillator the matrix of modDG has the determinant (1 + s - d)/(1 + s + d) with s =
/// k h²/4 and d = b h/2, so that its sum of exponents is -(2/h) artanh(d/(1 + s)) = -b + b k h²/4
/// - b³ h²/12 + O(h⁴).
#[test]
fn the_sum_of_moddg_is_off_by_its_own_second_order() {
    for (k, b) in [(1.0, 0.8), (1e-9, 0.8), (2.0, 0.1)] {
        let off = |h: f64| {
            let study =
                Lyapunov { problem: oscillator(k, b), transient: 0.0, time: 50.0 * h, rows: 5 };
            let (_, sum, log_det, _) = last(&study.run(row("moddg"), h, &Silent).unwrap());
            let exact = -2.0 / h * (b * h / 2.0 / (1.0 + k * h * h / 4.0)).atanh();
            assert!((sum - exact).abs() < 1e-13 && (sum - log_det).abs() < 1e-13, "{sum} {exact}");
            sum + b
        };
        let second = b * k / 4.0 - b.powi(3) / 12.0;
        for h in [0.1, 0.05] {
            assert!((off(h) / (h * h) - second).abs() < 0.6 * h * h, "k = {k}, b = {b}, h = {h}");
        }
    }
}

/// Σ λ = -c for Duffing's equations, whatever the motion; the sum of a method is that of its own
/// determinants.
#[test]
fn the_sum_of_the_reference_is_minus_c() {
    let study = Lyapunov { problem: ueda(), transient: 10.0, time: 60.0, rows: 6 };
    let (_, sum, log_det, divergence) = last(&study.run(&REFERENCE, TAU / 256.0, &Silent).unwrap());
    assert!((sum + 0.05).abs() < 1e-10, "{sum:?}");
    assert!((sum - log_det).abs() < 1e-13 && (divergence + 0.05).abs() < 1e-15);
    for method in ["moddg", "rk4", "leapfrog", "gonzalez", "increment-2"] {
        let (_, sum, log_det, divergence) =
            last(&study.run(row(method), TAU / 32.0, &Silent).unwrap());
        assert!((sum - log_det).abs() < 1e-12, "{method}: {sum:?} {log_det:?}");
        assert!((divergence + 0.05).abs() < 1e-15, "{method}");
        assert!((1e-9..0.05).contains(&(sum + 0.05).abs()), "{method}: {sum:?}");
    }
}

#[test]
fn the_table_has_its_columns() {
    let problem = ueda();
    let names = "method,h,t,exponent_1,exponent_2,standard_error_1,standard_error_2,sum,\
                 mean_log_det,mean_divergence,outcome";
    assert_eq!(columns(&problem.model).join(","), names);
    let study = Lyapunov { problem, transient: 1.0, time: 4.0, rows: 4 };
    let found = study.run(row("moddg"), 0.1, &Silent).unwrap();
    let table = afterbay_experiments::artifact::Artifact::wide_table(
        "lyapunov",
        &columns(&study.problem.model),
        &found.rows,
    );
    assert_eq!(table.unwrap().text.lines().count(), 5);
    assert!((TAU / found.h - (TAU / found.h).round()).abs() < 1e-9, "the step divides the period");
}

#[test]
fn a_run_that_fails_keeps_its_rows() {
    let mut problem = ueda();
    problem.q = vec![2.5];
    problem.model = problem.model.with("f", 7e3).unwrap();
    let study = Lyapunov { problem, transient: 0.0, time: 200.0, rows: 50 };
    let found = study.run(row("rk4"), 0.12, &Silent).unwrap();
    assert!(!found.ending.is_completed() && found.exponents().is_none(), "{:?}", found.ending);
    println!("{:?} {}", found.ending, found.rows.len());
    let last = found.rows.last().unwrap();
    assert_eq!(last.outcome, found.ending.outcome);
    assert!(last.exponents.iter().all(|x| x.is_none_or(f64::is_finite)));
    // A matrix without an inverse: modDG with 1 + k h²/4 = b h/2 sends one direction to 0.
    let study = Lyapunov { problem: oscillator(1.0, 2.0), transient: 0.0, time: 8.0, rows: 2 };
    let found = study.run(row("moddg"), 2.0, &Silent).unwrap();
    assert_eq!(found.ending.outcome, "singular-step");
    assert_eq!(found.rows.len(), 1);
    assert_eq!(found.rows[0].exponents, [None, None]);
}

/// x'' + 0.05 x' + x³ = 7.5 sin t has the exponents 0.1034 and -0.1534 in J. C. Sprott, Chaos and
/// Time-Series Analysis (Oxford 2003), appendix A. A time of 10⁵ gives three digits of them.
fn check_ueda(row: &'static Row, time: f64, most: f64) {
    let study = Lyapunov { problem: ueda(), transient: 500.0, time, rows: 50 };
    let found = study.run(row, TAU / 64.0, &Silent).unwrap();
    let (exponents, sum, ..) = last(&found);
    let errors: Vec<_> =
        found.rows[49].standard_errors.iter().map(|error| error.unwrap()).collect();
    println!("{} t = {time}: {exponents:?} ± {errors:?}, sum {sum:?}", row.name);
    for ((found, exact), error) in exponents.iter().zip([0.1034, -0.1534]).zip(&errors) {
        assert!((found - exact).abs() < 3.0 * error && *error < most, "{found} ± {error}");
    }
}

#[test]
fn uedas_attractor_has_its_published_exponents() {
    check_ueda(&REFERENCE, 4e3, 0.008);
    check_ueda(row("moddg"), 4e3, 0.008);
}

#[test]
#[ignore = "takes half a minute"]
fn uedas_attractor_has_its_published_exponents_to_three_digits() {
    check_ueda(&REFERENCE, 1e5, 0.0015);
}

/// Holmes's double well, x'' + 0.25 x' - x + x³ = 0.4 cos t: methods that are exact enough agree on
/// its largest exponent.
#[test]
#[ignore = "takes half a minute"]
fn holmess_attractor_has_one_largest_exponent() {
    let problem = duffing([-1.0, 1.0, 0.25, 0.4], [1.0, 0.0]);
    let study = Lyapunov { problem, transient: 500.0, time: 4e4, rows: 50 };
    let measured = [&REFERENCE, row("rk4"), row("increment-4")].map(|row| {
        let found = study.run(row, TAU / 64.0, &Silent).unwrap();
        let error = found.rows[49].standard_errors[0].unwrap();
        println!("{} {:?} ± {error}", row.name, found.exponents());
        (last(&found).0[0], error)
    });
    for (found, error) in &measured[1..] {
        let (exact, doubt) = measured[0];
        assert!((found - exact).abs() < 3.0 * error.hypot(doubt), "{found} ± {error}, {exact}");
        assert!(*error < 0.004);
    }
}

#[test]
fn a_scene_declares_the_study() {
    let text = |rows: u64, step: f64| {
        format!(
            "[system]\nname = \"damped-oscillator\"\nparameters = {{ k = 1.0, b = 3.0 }}\n\
             [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 40.0\nstep = {step:?}\n\
             [study.lyapunov]\nmethods = [\"moddg\"]\nrows = {rows}\n"
        )
    };
    let scene = Scene::read(&text(4, 0.1)).unwrap_or_else(|error| panic!("{error}"));
    let (output, findings) = experiment::study(&scene, &Silent).unwrap();
    for part in [
        "reference: largest exponent -0.3820 ± ",
        "(no chaos), sum -3.00000 where the divergence is -3.00000; moddg, h = 0.1000: largest",
        // -b + b k h²/4 - b³ h²/12 = -3.015
        " away (no chaos), sum -3.01516 where the divergence is -3.00000.",
    ] {
        assert!(findings[0].statement.contains(part), "{}", findings[0].statement);
    }
    let long = Scene::read(&text(4, 1.0)).unwrap_or_else(|error| panic!("{error}"));
    let said = experiment::study(&long, &Silent).unwrap().1.remove(0).statement;
    assert!(said.contains("these differ: the step is too long"), "{said}");
    let table = output.artifacts.iter().find(|table| table.name == "data/lyapunov.csv").unwrap();
    assert_eq!(table.text.lines().count(), 9);
    for rows in [0, 500, 20_000] {
        let error = Scene::read(&text(rows, 0.1)).unwrap_err().to_string();
        assert!(error.contains("from 1 to 10000, with a step between two rows"), "{error}");
    }
}

/// Several degrees of freedom, and H that is not separable: the sum of the reference is the mean
/// divergence, and modDG's generalisations have that of their own determinants.
#[test]
fn the_sum_is_the_divergence_with_several_degrees_of_freedom() {
    for (system, start, most) in [
        ("name = \"fput-chain\"\nparameters = { n = 3.0, beta = 1.0, c = 0.2 }", 3, 1e-11),
        (
            "name = \"damped-double-pendulum\"\nparameters = { m1 = 1.0, m2 = 1.0, l1 = 1.0, l2 = \
             1.0, g = 9.81, c1 = 0.1, c2 = 0.1 }",
            2,
            1e-3,
        ),
    ] {
        let system = system.replace("3.0", "3");
        let [q, p] = [1.0, 0.5].map(|x| vec![x; start]);
        let text = format!(
            "[system]\n{system}\n[initial]\nq = {q:?}\np = {p:?}\n[time]\nend = 1.0\nstep = 0.1\n"
        );
        let problem = Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem;
        let study = Lyapunov { problem, transient: 1.0, time: 10.0, rows: 5 };
        let (exponents, sum, log_det, divergence) =
            last(&study.run(&REFERENCE, 0.01, &Silent).unwrap());
        assert_eq!(exponents.len(), 2 * start);
        assert!((sum - log_det).abs() < 1e-11, "{sum:?} {log_det:?}");
        assert!((sum - divergence).abs() < most && divergence < -0.1, "{sum:?} {divergence:?}");
        let (_, sum, log_det, _) = last(&study.run(row("gonzalez"), 0.05, &Silent).unwrap());
        assert!((sum - log_det).abs() < 1e-11, "{sum:?} {log_det:?}");
    }
}

/// Sizes of q and p that are 60 powers of 2 apart, as those of planets in SI units, have the same
/// exponents as sizes of 1.
#[test]
fn exponents_do_not_depend_on_units() {
    let found = |[q, p]: [f64; 2]| {
        let (mass, force) = (p / q, p);
        let system = format!(
            "name = \"custom\"\npotential = \"f*l*((q1/l)^4/4 - (q1/l)^2/2)\"\nmass = [{mass:e}]\n\
             dissipation = [\"c*v1\"]\nparameters = {{ f = {force:e}, l = {q:e}, c = {:e} }}",
            0.25 * mass
        );
        let drive = format!("[drive]\nforce = [\"{:e}*cos(t)\"]", 0.4 * force);
        let problem = problem(&system, &drive, [q, 0.0]);
        let study = Lyapunov { problem, transient: 10.0, time: 60.0, rows: 6 };
        study.run(row("rk4"), 0.1, &Silent).unwrap()
    };
    let natural = last(&found([1.0; 2]));
    let si = found([2.0_f64.powi(37), 2.0_f64.powi(97)]);
    assert!(si.ending.is_completed(), "{}", si.ending.describe());
    let si = last(&si);
    for (a, b) in natural.0.iter().zip(&si.0) {
        assert!((a - b).abs() < 1e-9, "{:?} {:?}", natural.0, si.0);
    }
    assert!((si.1 - natural.1).abs() < 1e-9 && (si.2 - natural.2).abs() < 1e-9, "{si:?}");
}
