//! The studies: what they find where it is known.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::stability::{Map, MapError, Verdict};
use afterbay_analysis::study::work_precision::Runs;
use afterbay_analysis::study::{Problem, energy, global_order, work_precision};
use afterbay_core::{InputError, IntegrateError, StateRef};
use afterbay_experiments::paper::oscillator;
use afterbay_methods::registry::{FIXED, Row, find};
use afterbay_systems::{
    Custom, DAMPED_OSCILLATOR, DUFFING, Described, Description, DissipationText, VAN_DER_POL,
};

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| find(name).expect("a registered method")).collect()
}

#[test]
fn books_tell_the_methods_that_keep_k() {
    let runs = energy::run(&oscillator(), &FIXED.iter().collect::<Vec<_>>(), 0.05, 1, &Silent)
        .expect("runs");
    for (row, run) in FIXED.iter().zip(&runs) {
        assert!(run.ending.is_completed(), "{}: {}", row.name, run.ending.describe());
        // H is quadratic, and implicit-midpoint keeps a quadratic K without claiming to keep
        // others.
        let keeps_k = row.keeps_k || row.name == "implicit-midpoint";
        assert_eq!(run.drift < 1e-12, keeps_k, "{}: {:e}", row.name, run.drift);
        if row.passive {
            assert_eq!(run.violations, Some(0), "{}", row.name);
        }
    }
    let active = Problem { model: Model::of(&VAN_DER_POL, &[1.0]), ..oscillator() };
    let runs = energy::run(&active, &rows(&["moddg"]), 0.05, 1, &Silent).expect("runs");
    assert_eq!(runs[0].violations, None, "an active system owes nothing");
}

#[test]
fn the_overdamped_oscillator_has_perfect_books_and_a_wrong_decay() {
    let model = Model::of(&DAMPED_OSCILLATOR, &[1.0, 200.0]);
    let problem = Problem { model, q: vec![1.0], p: vec![1.0], end: 1.0 };
    let runs = energy::run(&problem, &rows(&["moddg"]), 0.1, 1, &Silent).expect("runs");
    let row = &runs[0].rows[2];
    let (found, off) = (row.ratio.expect("a ratio"), row.ratio_error.expect("a ratio"));
    assert!((found - 0.8504).abs() < 5e-5 && (found - off - 0.9990).abs() < 5e-5, "{found} {off}");
    assert!(runs[0].drift < 1e-15 && runs[0].violations == Some(0));
}

#[test]
fn global_errors_fall_with_the_order_of_the_method() {
    let steps = [0.05, 0.025, 0.0125];
    for model in
        [oscillator().model, Model::of(&DUFFING, &[1.0, 0.5, 0.1]), Model::of(&VAN_DER_POL, &[1.0])]
    {
        let problem = Problem { model: model.clone(), end: 5.0, ..oscillator() };
        for row in
            global_order::run(&problem, &rows(&["leapfrog", "moddg", "rk4"]), &steps, &Silent)
                .expect("runs")
        {
            let order = find(row.method).expect("registered").order();
            let claimed = f64::from(order.number().expect("not exact"));
            if row.h == 0.0125 {
                let order = row.order.expect("an order");
                assert!(
                    (order - claimed).abs() < 0.1,
                    "{model:?} {} {}: {order}",
                    row.method,
                    row.variable
                );
            }
        }
    }
}

/// Amplitudes of 1e-8, 1 and 1e6 are one motion in three units.
#[test]
fn orders_are_taken_from_errors_above_rounding_in_every_unit() {
    let steps = [0.8, 0.4, 0.2, 0.1, 0.05, 0.025];
    for (size, potential) in
        [(1e-8, "q1^2/2 + q1^4/4e-16"), (1.0, "q1^2/2 + q1^4/4"), (1e6, "q1^2/2 + q1^4/4e12")]
    {
        let model = custom(potential, "0.05*p1");
        let problem = Problem { model, q: vec![size], p: vec![0.0], end: 8.0 };
        let found = global_order::run(&problem, &rows(&["rk4", "collocation-8"]), &steps, &Silent);
        let found = found.expect("runs");
        let orders = |method: &str| {
            let of = found.iter().filter(move |row| row.method == method);
            of.map(|row| row.order.map(f64::round)).collect::<Vec<_>>()
        };
        let settled = [None, Some(3.0), Some(4.0), Some(4.0), Some(4.0), Some(4.0)];
        assert_eq!(orders("rk4"), settled.repeat(3), "{size}");
        // The errors at the finest steps are roundings, and those at h = 0.1 are not far above.
        let high = orders("collocation-8");
        let of_variable = [None, Some(8.0), Some(8.0), None, None, None];
        assert_eq!(high, of_variable.repeat(3), "{size}: {found:?}");
    }
}

#[test]
fn a_run_that_fails_keeps_its_row_and_the_sweep_goes_on() {
    // Simple iteration does not contract at h = 2.5, but it does at the next step size.
    let methods = rows(&["moddg-fixed-point"]);
    let runs = Runs { methods: &methods, steps: &[2.5, 0.1], ..Runs::default() };
    let found = work_precision::run(&oscillator(), runs, &Silent).expect("runs");
    assert_eq!(found[0].outcome, "not-contracting");
    assert!(
        found[0]
            .failure
            .as_ref()
            .is_some_and(|text| text.contains("step 1 ") && text.contains("degree of freedom 1"))
    );
    assert_eq!((found[0].error_qp, found[0].seconds), (None, None));
    assert_eq!(found[1].outcome, "completed");
    assert!(found[1].seconds.is_some_and(|seconds| seconds > 0.0));
}

#[test]
fn verdicts_and_spectral_radii_are_those_of_theory() {
    let map = Map {
        problem: oscillator(),
        parameter: "b",
        values: &[0.0, 0.1, 10.0],
        steps: &[0.1, 1.9, 2.1, 3.0],
        end: 20.0,
        least_steps: 200,
    };
    let cells =
        map.run(&rows(&["leapfrog", "rk4", "moddg", "moddg-fixed-point"]), &Silent).expect("runs");
    let cell = |method: &str, b: f64, h: f64| {
        cells
            .iter()
            .find(|row| row.method == method && row.value == b && row.h == h)
            .expect("a cell")
    };
    // Without friction leap-frog is stable up to h = 2, RK4 up to 2√2, and the discrete gradient
    // always, with radius 1 up to rounding.
    let radius = |method, b, h| cell(method, b, h).spectral_radius.expect("a linear step");
    assert!((radius("leapfrog", 0.0, 1.9) - 1.0).abs() < 1e-12);
    assert!(radius("leapfrog", 0.0, 2.1) > 1.5);
    assert!(radius("rk4", 0.0, 2.1) < 1.0 && radius("rk4", 0.0, 3.0) > 1.3);
    for h in [0.1, 1.9, 2.1, 3.0] {
        assert!((radius("moddg", 0.0, h) - 1.0).abs() < 1e-12);
    }
    assert_eq!(cell("leapfrog", 0.0, 0.1).verdict, Verdict::Right);
    assert!(matches!(cell("leapfrog", 0.0, 2.1).verdict, Verdict::Growing | Verdict::NotFinite));
    assert!(matches!(cell("rk4", 0.1, 3.0).verdict, Verdict::Growing | Verdict::NotFinite));
    assert_eq!(cell("moddg", 0.1, 0.1).verdict, Verdict::Right);
    // The method is A-stable but not L-stable: bounded at any step, with the wrong decay.
    assert_eq!(cell("moddg", 10.0, 3.0).verdict, Verdict::Wrong);
    assert_eq!(cell("moddg-fixed-point", 0.1, 2.1).verdict, Verdict::NoConvergence);
}

#[test]
fn van_der_pol_is_judged_by_its_limit_cycle() {
    let problem =
        Problem { model: Model::of(&VAN_DER_POL, &[1.0]), q: vec![2.0], p: vec![0.5], end: 20.0 };
    let map = Map {
        problem,
        parameter: "mu",
        values: &[0.5, 5.0],
        steps: &[0.01, 0.5],
        end: 20.0,
        least_steps: 50,
    };
    let cells = map.run(&rows(&["leapfrog", "rk4", "moddg"]), &Silent).expect("runs");
    for cell in &cells {
        // At μ = 5 a step of 0.5 is too long for each of them; at μ = 0.5 only for w.
        if cell.h == 0.01 || cell.value == 5.0 {
            assert_eq!(cell.verdict == Verdict::Right, cell.h == 0.01, "{cell:?}");
        }
        assert_eq!(cell.spectral_radius, None);
    }
}

#[test]
fn references_know_rest_decay_and_their_end() {
    let duffing = |alpha, beta, c| Model::of(&DUFFING, &[alpha, beta, c]);
    let at_rest = Problem { model: duffing(1.0, 1.0, 0.1), q: vec![0.0], p: vec![0.0], end: 5.0 };
    let rest = at_rest.solution(0.5, 10, &Silent).expect("rest lasts");
    assert_eq!(rest.at(10), StateRef { q: &[0.0], p: &[0.0], w: &[0.0], t: 5.0 });
    let decay = Problem { model: duffing(1.0, 1.0, 2.0), q: vec![1.0], p: vec![0.0], end: 1000.0 };
    let decayed = decay.solution(100.0, 10, &Silent).expect("a decay lasts");
    let StateRef { q: &[q], p: &[p], w: &[w], t: 1000.0 } = decayed.at(10) else {
        panic!("{decayed:?}")
    };
    assert!(q.abs() < 1e-280 && p.abs() < 1e-280 && (w - 0.75).abs() < 1e-15, "{q} {p} {w}");
    // The solution of q'' = q + 5 q³ diverges in finite time.
    let escape = Problem { model: duffing(-1.0, -5.0, 0.1), q: vec![2.0], p: vec![1.0], end: 10.0 };
    let error = escape.solution(1.0, 10, &Silent).expect_err("the solution ends");
    let IntegrateError::Input(InputError::SolutionEnds { t }) = error else { panic!("{error}") };
    assert!(t > 0.1 && t < 1.0, "{t}");
}

fn custom(potential: &str, dissipation: &str) -> Model {
    let friction = match dissipation {
        "" => DissipationText::None,
        text => DissipationText::Forces(vec![text.to_owned()]),
    };
    let description = Description {
        potential: potential.to_owned(),
        dissipation: friction,
        masses: Vec::new(),
        parameters: Vec::new(),
        ..Description::default()
    };
    Model::Custom(Described::Separable(Custom::new(&description).expect("a system")))
}

/// B(2/3, 1/2)
const BETA: f64 = 2.587_109_559_229_791;

/// The periods from (1, 0): 4 for V = 2 |q|, and 4 ∫_0^1 dq/√(2 - 2 q^1.5) for V = |q|^1.5.
#[test]
fn a_reference_without_series_says_what_it_is_worth() {
    for (potential, period) in
        [("sqrt(4*q1^2)", 4.0), ("abs(q1)^1.5", 4.0 / 3.0 * 2.0_f64.sqrt() * BETA)]
    {
        let problem =
            Problem { model: custom(potential, ""), q: vec![1.0], p: vec![0.0], end: period };
        let found = problem.solution(period / 2.0, 2, &Silent).expect("runs stand in");
        let off = (1..=2).map(|i| {
            let StateRef { q, p, .. } = found.at(i);
            (q[0] - if i == 1 { -1.0 } else { 1.0 }).abs().max(p[0].abs())
        });
        let (off, doubt) = (off.fold(0.0, f64::max), found.doubt().most());
        println!("{potential}: off by {off:e}, doubt {:e}", doubt);
        assert!(doubt > 1e-14 && doubt < 1e-4, "{potential}: {:e}", doubt);
        assert!(off < 2.0 * doubt, "{potential}: {off:e} {:e}", doubt);
    }
}

#[test]
fn a_map_with_a_step_that_cannot_be_taken_is_refused() {
    for (h, steps) in
        [(0.0, None), (-1.0, None), (f64::NAN, None), (1e-300, Some(())), (1e-9, Some(()))]
    {
        let map = Map {
            problem: oscillator(),
            parameter: "b",
            values: &[0.1],
            steps: &[h],
            end: 20.0,
            least_steps: 50,
        };
        let error = map.run(&rows(&["moddg"]), &Silent).expect_err("no such step");
        match steps {
            None => {
                assert!(matches!(error, MapError::Input(InputError::Step { .. })), "{h}: {error}");
            }
            Some(_) => {
                assert!(
                    matches!(error, MapError::Input(InputError::Budget { .. })),
                    "{h}: {error}"
                );
            }
        }
    }
}
