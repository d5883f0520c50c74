//! Maps of stability: verdicts that can be known beforehand, and lanes and threads that change none
//! of them.

use afterbay_analysis::Model;
use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, MapError, StabilityRow, Verdict, atlas};
use afterbay_core::Grid;
use afterbay_methods::registry::{Row, find};
use afterbay_systems::{
    Custom, DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, Description, DissipationText,
    FPUT_CHAIN, VAN_DER_POL,
};
use std::sync::atomic::{AtomicUsize, Ordering};

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| find(name).expect("a registered method")).collect()
}

fn spread(count: usize, from: f64, to: f64) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
}

fn custom(potential: &str, dissipation: &[&str], parameters: &[(&str, f64)]) -> Model {
    let description = Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(dissipation.iter().map(|&d| d.into()).collect()),
        parameters: parameters.iter().map(|&(name, value)| (name.into(), value)).collect(),
        ..Default::default()
    };
    Model::Custom(Custom::new(&description).expect("a good description"))
}

/// One run, as a map of one cell.
fn cell(model: Model, start: [f64; 2], method: &str, h: f64, end: f64) -> StabilityRow {
    let (name, value) = match (model.name(), &model) {
        ("damped-oscillator", Model::Listed(_, values)) => ("b", values[1]),
        ("duffing", Model::Listed(_, values)) => ("c", values[2]),
        ("van-der-pol", Model::Listed(_, values)) => ("mu", values[0]),
        _ => ("c", 0.0),
    };
    let problem = Problem { model, q: vec![start[0]], p: vec![start[1]], end };
    let map = Map { problem, parameter: name, values: &[value], steps: &[h], end, least_steps: 1 };
    let mut cells = map.run(&rows(&[method]), &Silent).expect("a map");
    assert_eq!(cells.len(), 1);
    cells.remove(0)
}

fn well(c: f64) -> Model {
    Model::of(&DUFFING, &[-1.0, 1.0, c])
}

#[test]
fn side_by_side_each_has_the_verdict_it_has_alone() {
    let duffing = |alpha| Model::of(&DUFFING, &[alpha, 1.0, 0.1]);
    let polynomial =
        custom("k*q1^2/2 + q1^4/4 - q1^3/3", &["c*(1 + q1^2)*p1"], &[("k", 1.0), ("c", 0.1)]);
    let one = (vec![2.3], vec![-3.1]);
    let three = (vec![1.0, -0.3, 0.8], vec![0.0, 1.5, -0.2]);
    let maps = [
        (Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]), "b", spread(13, -0.4, 6.0), &one),
        (duffing(1.0), "c", spread(11, 0.0, 3.0), &one),
        (duffing(-1.0), "c", spread(16, -0.1, 0.5), &one),
        (duffing(1.0), "alpha", spread(9, -5.0, 5.0), &one),
        (Model::of(&VAN_DER_POL, &[1.0]), "mu", spread(12, -0.2, 8.0), &one),
        (polynomial, "c", spread(10, 0.0, 2.0), &one),
        (Model::of(&FPUT_CHAIN, &[3.0, 1.0, 0.1]), "c", spread(10, 0.0, 2.0), &three),
    ];
    let steps = [0.05, 0.3, 0.7, 1.1, 1.6, 2.2, 3.0, 4.5];
    let (mut cells, mut ends) = (0, std::collections::BTreeMap::<&str, usize>::new());
    for (model, parameter, values, (q, p)) in maps {
        let name = model.name();
        let methods: &[&str] = if model.dof() == 1 {
            &["leapfrog", "rk4", "moddg", "increment-2", "increment-4"]
        } else {
            &["leapfrog", "rk4", "increment-2", "increment-1"]
        };
        let problem = Problem { model, q: q.clone(), p: p.clone(), end: 60.0 };
        let map =
            Map { problem, parameter, values: &values, steps: &steps, end: 60.0, least_steps: 60 };
        let methods = rows(methods);
        let references = map.references(&Silent).expect("references");
        let together = map.judge(&methods, &references, &Silent).expect("cells");
        let alone = map.judge_alone(&methods, &references, &Silent).expect("cells");
        assert_eq!(together.len(), methods.len() * values.len() * steps.len());
        for (together, alone) in together.iter().zip(&alone) {
            assert_eq!(together, alone, "{name}");
            *ends.entry(together.verdict.describe()).or_default() += 1;
            cells += 1;
        }
    }
    println!("{cells} cells: {ends:?}");
    assert!(ends.len() >= 6, "{ends:?}");
}

#[test]
fn a_map_is_the_same_for_any_number_of_threads() {
    let problem = Problem { model: well(0.1), q: vec![1.3], p: vec![0.4], end: 20.0 };
    let (values, steps) = (spread(20, 0.0, 1.0), spread(6, 0.1, 3.0));
    let map =
        Map { problem, parameter: "c", values: &values, steps: &steps, end: 20.0, least_steps: 50 };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| map.run(&rows(&["leapfrog", "moddg", "gonzalez"]), &Silent)).expect("a map")
    };
    let one = with(1);
    assert_eq!(one.len(), 3 * 20 * 6);
    for (i, row) in one.iter().enumerate() {
        assert_eq!((row.value, row.h), (values[i / 6 % 20], steps[i % 6]));
    }
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

fn bounded(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Right | Verdict::Late | Verdict::Wrong | Verdict::Unjudged)
}

#[test]
fn explicit_methods_end_where_theory_says_and_moddg_nowhere() {
    // k = 4: ω = 2. Leap-frog ends at h ω = 2, RK4 at 2√2.
    let problem = Problem {
        model: Model::of(&DAMPED_OSCILLATOR, &[4.0, 0.0]),
        q: vec![1.0],
        p: vec![0.5],
        end: 1.0,
    };
    let limits = [1.0, 2_f64.sqrt()];
    let steps: Vec<f64> =
        limits.iter().flat_map(|limit| [limit * 0.999, limit * 1.001]).chain([30.0]).collect();
    let map = Map {
        problem,
        parameter: "b",
        values: &[0.0, 0.1, 3.0],
        steps: &steps,
        end: 1.0,
        least_steps: 2000,
    };
    let cells = map.run(&rows(&["leapfrog", "rk4", "moddg"]), &Silent).expect("a map");
    let cell = |method: &str, b: f64, h: f64| {
        cells
            .iter()
            .find(|row| row.method == method && row.value == b && row.h == h)
            .expect("a cell")
    };
    let radius =
        |method: &str, h: f64| cell(method, 0.0, h).spectral_radius.expect("a linear step");
    for (method, [below, above]) in
        [("leapfrog", [steps[0], steps[1]]), ("rk4", [steps[2], steps[3]])]
    {
        assert!(radius(method, below) < 1.0 + 1e-12 && radius(method, above) > 1.001, "{method}");
        assert!(bounded(cell(method, 0.0, below).verdict), "{method}");
        assert!(
            matches!(cell(method, 0.0, above).verdict, Verdict::Growing | Verdict::NotFinite),
            "{method}"
        );
    }
    for cell in cells.iter().filter(|cell| cell.method == "moddg") {
        assert!(cell.spectral_radius.expect("a linear step") < 1.0 + 1e-12, "{cell:?}");
        // Over a time of 60000 no reference is found without friction; bounded it is.
        assert!(bounded(cell.verdict) && cell.steps_done == 2000, "{cell:?}");
    }
}

#[test]
fn a_chain_ends_with_its_fastest_mode() {
    // Without cubic springs: ω = 2 sin(nπ/(2(n + 1))), and leap-frog ends at h ω = 2.
    let n = 5;
    let fastest = 2.0 * (std::f64::consts::PI * 5.0 / 12.0).sin();
    let model = Model::of(&FPUT_CHAIN, &[n as f64, 0.0, 0.0]);
    let problem = Problem { model, q: vec![1.0, 0.0, -1.0, 0.3, 0.2], p: vec![0.0; n], end: 1.0 };
    let steps = [0.999, 1.001].map(|share| share * 2.0 / fastest);
    let map = Map {
        problem,
        parameter: "c",
        values: &[0.0, 0.2],
        steps: &steps,
        end: 1.0,
        least_steps: 1000,
    };
    let cells = map.run(&rows(&["leapfrog", "increment-2"]), &Silent).expect("a map");
    let radii: Vec<f64> =
        cells.iter().map(|row| row.spectral_radius.expect("a linear step")).collect();
    assert!((radii[0] - 1.0).abs() < 1e-9 && radii[1] > 1.03, "{radii:?}");
    assert!(radii[4..].iter().all(|&radius| radius < 1.0 + 1e-9), "{radii:?}");
    assert!(matches!(cells[1].verdict, Verdict::Growing | Verdict::NotFinite), "{:?}", cells[1]);
}

#[test]
fn a_double_well_is_judged_by_size_and_place() {
    // Within the right well H is negative: logarithms of its mean tell nothing.
    for method in ["leapfrog", "rk4", "moddg"] {
        for c in [0.0, 0.05, 0.3, 5.0] {
            assert_eq!(
                cell(well(c), [1.2, 0.3], method, 0.05, 60.0).verdict,
                Verdict::Right,
                "{method} {c}"
            );
        }
    }
    // The start is on a slope between the two basins of rest: coarse steps end in the other well.
    let ends = |method: &str, h: f64| cell(well(0.2), [2.3, -3.1], method, h, 80.0);
    assert_eq!(ends("rk4", 0.02).verdict, Verdict::Right);
    let coarse: Vec<Verdict> =
        spread(40, 0.2, 0.9).into_iter().map(|h| ends("leapfrog", h).verdict).collect();
    assert!(coarse.contains(&Verdict::Wrong) && coarse.contains(&Verdict::Late), "{coarse:?}");
    // On the same orbit with friction of another strength the place is right and the size is not.
    let slow = cell(well(8.0), [1.5, 2.0], "moddg", 2.0, 60.0);
    assert_eq!(slow.verdict, Verdict::Wrong, "{slow:?}");
}

#[test]
fn rest_and_what_decays_below_any_number_is_right() {
    for method in ["leapfrog", "rk4", "moddg"] {
        for (model, start) in [
            (well(0.1), [0.0, 0.0]),
            (well(0.1), [1.0, 0.0]),
            (well(0.1), [-1.0, 0.0]),
            (Model::of(&DUFFING, &[1.0, 1.0, 1.0]), [0.0, 0.0]),
            (Model::of(&DUFFING, &[1.0, 1.0, 2.0]), [1.0, 0.0]),
            (Model::of(&DAMPED_OSCILLATOR, &[1.0, 2.0]), [1.0, 0.0]),
        ] {
            let found = cell(model.clone(), start, method, 0.05, 1500.0);
            assert_eq!(found.verdict, Verdict::Right, "{model:?} {start:?} {found:?}");
        }
    }
}

#[test]
fn limit_cycles_are_told_from_each_other() {
    for mu in [0.2, 1.0, 3.0] {
        let of =
            |method, h| cell(Model::of(&VAN_DER_POL, &[mu]), [0.1, 0.0], method, h, 100.0).verdict;
        assert_eq!(of("rk4", 0.02), Verdict::Right, "{mu}");
        // The jumps of the cycle at μ = 3 come late.
        let expected = if mu == 3.0 { Verdict::Late } else { Verdict::Right };
        assert_eq!(of("moddg", 0.02), expected, "{mu}");
    }
    // Cycles of another size, before there are none.
    let of = |h| cell(Model::of(&VAN_DER_POL, &[3.0]), [2.0, 0.0], "leapfrog", h, 100.0).verdict;
    let coarse: Vec<Verdict> = spread(20, 0.05, 1.0).into_iter().map(of).collect();
    let first = |verdict| coarse.iter().position(|&found| found == verdict).unwrap_or(coarse.len());
    assert!(first(Verdict::Wrong) < first(Verdict::Growing), "{coarse:?}");
    assert!(first(Verdict::Growing) < coarse.len(), "{coarse:?}");
    assert_eq!(first(Verdict::Right), coarse.len(), "{coarse:?}");
}

/// x/h + h/8 x (x + 2)², of which x = q1 - q0 is the root p0 of modDG's step from (1, p0) in the
/// double well V = q⁴/4 - q²/2.
fn step_equation(h: f64, x: f64) -> f64 {
    x / h + h / 8.0 * x * (x + 2.0).powi(2)
}

/// Where it turns, if it does: f' = 1/h + h/8 (3 x² + 8 x + 4).
fn turns(h: f64) -> Option<[f64; 2]> {
    let root = (64.0 - 12.0 * (4.0 + 8.0 / (h * h))).sqrt();
    (root > 0.0).then(|| [(-8.0 - root) / 6.0, (-8.0 + root) / 6.0])
}

#[test]
fn several_solutions_are_those_of_the_cubic() {
    let (h, p) = (4.0, -0.715);
    // Three real roots: p lies between the values where the cubic turns.
    let [high, low] = turns(h).expect("it turns").map(|x| step_equation(h, x));
    assert!(low < p && p < high, "{low} {high}");
    // The root that continues from h = 0 is right of both turns, up to the h at which the right one
    // rises to p.
    let end = (0..4000)
        .map(|i| 2.5 + 2e-4 * f64::from(i))
        .find(|&h| turns(h).is_some_and(|[_, x]| step_equation(h, x) > p));
    let end = end.expect("the branch ends");
    for method in ["moddg", "increment-1"] {
        let of = |h: f64| cell(well(0.0), [1.0, p], method, h, h);
        for h in [end + 1e-3, h] {
            let found = of(h);
            assert_eq!(
                (found.verdict, found.steps_done, found.outcome),
                (Verdict::SeveralSolutions, 0, "several-solutions"),
                "{h}"
            );
        }
        assert_eq!(of(end - 1e-3).steps_done, 1);
    }
    // From p = -0.6 there are three as well at h = 4, and the branch goes on.
    assert!(low < -0.6 && -0.6 < high);
    assert_eq!(cell(well(0.0), [1.0, -0.6], "moddg", h, h).steps_done, 1);
    // On the top of the barrier the solution forks at h = 2.
    assert_eq!(cell(well(0.0), [0.0, 0.0], "moddg", 1.99, 4.0).outcome, "completed");
    assert_eq!(cell(well(0.0), [0.0, 0.0], "moddg", 2.01, 4.0).verdict, Verdict::SeveralSolutions);
}

#[test]
fn every_verdict_is_given() {
    let oscillator = |b| Model::of(&DAMPED_OSCILLATOR, &[1.0, b]);
    let of = |b, method, h| cell(oscillator(b), [2.3, -3.1], method, h, 40.0).verdict;
    assert_eq!(of(0.1, "leapfrog", 0.1), Verdict::Right);
    assert_eq!(of(10.0, "moddg", 3.0), Verdict::Wrong);
    assert_eq!(of(0.0, "leapfrog", 2.2), Verdict::Growing);
    assert_eq!(
        cell(Model::of(&VAN_DER_POL, &[5.0]), [2.0, 0.5], "rk4", 1.0, 40.0).verdict,
        Verdict::NotFinite
    );
    assert_eq!(of(0.1, "moddg-fixed-point", 2.1), Verdict::NoConvergence);
    assert_eq!(of(-2.5, "moddg", 1.0), Verdict::Pole);
    assert_eq!(
        cell(oscillator(0.1), [1.0, 0.0], "moddg-q3-shared", 0.1, 40.0).verdict,
        Verdict::Pole
    );
    // Some sweeps go backwards in time, and friction then gives back.
    let robbed: Vec<Verdict> =
        spread(25, 0.5, 12.5).into_iter().map(|h| of(2.0, "increment-4", h)).collect();
    assert!(robbed.contains(&Verdict::PassivityViolated), "{robbed:?}");
    assert_eq!(of(0.5, "increment-4", 0.1), Verdict::Right);
    // The exact solution leaves the numbers, the run does not yet.
    let soft = Model::of(&DUFFING, &[-1.0, -1.0, 0.1]);
    let found = cell(soft, [1.0, 1.0], "moddg", 0.01, 1.2);
    assert!(
        matches!(found.verdict, Verdict::Wrong | Verdict::Growing | Verdict::SeveralSolutions),
        "{found:?}"
    );
    // Hénon and Heiles: no step of RK4 follows chaos over such a time.
    let heiles = custom("q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3", &["c*p1", "c*p2"], &[("c", 0.0)]);
    let problem = Problem { model: heiles, q: vec![0.0, -0.15], p: vec![0.55, 0.0], end: 3000.0 };
    let map =
        Map { problem, parameter: "c", values: &[0.0], steps: &[0.1], end: 3000.0, least_steps: 1 };
    assert_eq!(
        map.run(&rows(&["leapfrog"]), &Silent).expect("a map")[0].verdict,
        Verdict::Unjudged
    );
}

#[test]
fn an_atlas_says_where_methods_end() {
    let problem = Problem {
        model: Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.0]),
        q: vec![1.0],
        p: vec![0.5],
        end: 40.0,
    };
    let steps = [0.05, 0.1, 1.9, 2.5, 3.0];
    let map = Map {
        problem,
        parameter: "b",
        values: &[0.0, 0.2, 0.4],
        steps: &steps,
        end: 40.0,
        least_steps: 200,
    };
    let cells = map.run(&rows(&["leapfrog", "rk4", "linear-exact"]), &Silent).expect("a map");
    let found = atlas(&cells);
    assert_eq!(
        found.iter().map(|row| row.method).collect::<Vec<_>>(),
        ["leapfrog", "rk4", "linear-exact"]
    );
    assert!(
        found[0].h.is_some_and(|h| h == 1.9 || h == 2.5) && found[0].middle == 0.2,
        "{:?}",
        found[0]
    );
    assert!(found[1].h.is_some_and(|h| h > 0.1 && h <= 3.0), "{:?}", found[1]);
    assert_eq!((found[2].h, found[2].verdict, found[2].middle_h), (None, None, None));
}

#[test]
fn any_parameter_of_any_system_can_be_varied() {
    let model = custom("k*q1^4/4", &["c*p1"], &[("k", 1.0), ("c", 0.1)]);
    let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 20.0 };
    let map = Map {
        problem,
        parameter: "k",
        values: &[0.5, 1.0, 2.0],
        steps: &[0.05],
        end: 20.0,
        least_steps: 1,
    };
    let cells = map.run(&rows(&["moddg", "collocation-4", "relaxed-rk4"]), &Silent).expect("a map");
    assert!(
        cells.len() == 9
            && cells.iter().all(|cell| cell.verdict == Verdict::Right && cell.parameter == "k")
    );
    let unknown = Map { parameter: "kk", ..map.clone() };
    let error = unknown.run(&rows(&["moddg"]), &Silent).expect_err("no such parameter");
    assert!(matches!(error, MapError::Model(_)) && error.to_string().contains("kk"), "{error}");
    let pendulum = Model::of(&DAMPED_DOUBLE_PENDULUM, &[1.0, 1.0, 1.0, 1.0, 1.0, 0.2, 0.2]);
    let problem = Problem { model: pendulum, q: vec![0.5, -0.3], p: vec![0.0, 0.2], end: 10.0 };
    let map = Map {
        problem,
        parameter: "c2",
        values: &[0.1, 0.4],
        steps: &[0.05, 60.0],
        end: 10.0,
        least_steps: 1,
    };
    let cells = map.run(&rows(&["rk4", "gonzalez", "increment-2"]), &Silent).expect("a map");
    for cell in cells {
        assert_eq!(cell.verdict == Verdict::Right, cell.h == 0.05, "{cell:?}");
    }
}

/// Says stop after so many pieces.
struct After(AtomicUsize, usize);

impl Progress for After {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
    fn stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed) >= self.1
    }
}

#[test]
fn a_map_that_is_stopped_has_the_cells_that_were_begun() {
    let problem = Problem { model: well(0.1), q: vec![1.3], p: vec![0.4], end: 5.0 };
    let (values, steps) = (spread(16, 0.0, 1.0), spread(5, 0.1, 0.5));
    let map =
        Map { problem, parameter: "c", values: &values, steps: &steps, end: 5.0, least_steps: 1 };
    let methods = rows(&["leapfrog", "moddg"]);
    let all = map.run(&methods, &Silent).expect("a map");
    let whole = After(AtomicUsize::new(0), usize::MAX);
    map.run(&methods, &whole).expect("a map");
    assert_eq!(whole.0.into_inner(), map.pieces(2));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    for (pieces, cells) in [(0, 0), (1, 0), (2, 0), (5, 24), (22, 160)] {
        let stop = After(AtomicUsize::new(0), pieces);
        let found = pool.install(|| map.run(&methods, &stop)).expect("a map");
        assert_eq!(found.len(), cells, "{pieces}");
        assert!(found.iter().all(|row| all.contains(row)));
    }
}

/// The largest errors of q, p and w after each step of a run, beside the exact solution.
fn errors(problem: &Problem, method: &str, h: f64) -> [f64; 3] {
    let grid = Grid::new(h, problem.end).expect("a grid");
    let exact = problem.solution(h, grid.steps as usize, &Silent).expect("a solution");
    let mut most = [0.0_f64; 3];
    let run = problem.model.bind(find(method).expect("a method")).expect("it applies");
    let mut state = problem.start().expect("a state");
    run.run(grid, &mut state, 1, &mut |n, state| {
        let exact = exact.at(n as usize);
        for (most, (found, exact)) in
            most.iter_mut().zip([(state.q, exact.q), (state.p, exact.p), (state.w, exact.w)])
        {
            *most = found.iter().zip(exact).fold(*most, |most, (a, b)| most.max((a - b).abs()));
        }
        std::ops::ControlFlow::Continue(())
    })
    .expect("it runs");
    most
}

#[test]
fn a_reservoir_that_is_wrong_is_not_right() {
    let (mut wrong, mut right) = (0, 0);
    let steps = [0.05, 0.2, 0.4, 0.5, 0.8, 1.0, 1.25];
    for (b, h) in [2.0, 3.0].into_iter().flat_map(|b| steps.map(|h| (b, h))) {
        let model = Model::of(&DAMPED_OSCILLATOR, &[1.0, b]);
        let problem = Problem { model, q: vec![2.3], p: vec![-3.1], end: 20.0 };
        let [q, p, w] = errors(&problem, "leapfrog", h);
        let found = cell(problem.model.clone(), [2.3, -3.1], "leapfrog", h, 20.0);
        println!("{b} {h}: {q:.2e} {p:.2e} {w:.2e} {:?}", found.verdict);
        // The reservoir holds 7.45 at the end.
        if w > 1.0 {
            assert_ne!(found.verdict, Verdict::Right, "w off by {w}");
            wrong += 1;
        }
        if found.verdict == Verdict::Right {
            assert!(w < 0.75 && q < 0.3 && p < 0.4, "{q} {p} {w}");
            right += 1;
        }
    }
    assert!(wrong > 0 && right > 0, "{wrong} {right}");
}

/// A pendulum that goes round, g = 9.81, of energy 200.
fn rotor(c: f64) -> Model {
    custom("9.81*(1 - cos(q1))", &["c*p1"], &[("c", c)])
}

#[test]
fn a_rotor_is_judged_by_its_angle_and_not_by_its_turns() {
    let one = |model: Model, method: &str, h: f64, end: f64| {
        let problem = Problem { model, q: vec![0.0], p: vec![20.0], end };
        let off = errors(&problem, method, h);
        let values = [1e-9];
        let steps = [h];
        let map =
            Map { problem, parameter: "c", values: &values, steps: &steps, end, least_steps: 1 };
        (off, map.run(&rows(&[method]), &Silent).expect("a map").remove(0).verdict)
    };
    let mut turned = 0;
    for h in [0.005, 0.05, 0.1, 0.125] {
        let ([q, ..], verdict) = one(rotor(1e-9), "leapfrog", h, 30.0);
        println!("{h}: q off by {q:.3}: {verdict:?}");
        assert_eq!(verdict == Verdict::Right, q < 0.1, "h = {h}: off by {q}");
        turned += u64::from(q > 6.3);
    }
    assert!(turned > 0, "some are off by turns");
}

#[test]
fn a_phase_error_with_the_right_amplitude_is_late() {
    // Leap-frog's frequency is off by h²/24 of itself: 0.1 rad after t = 60 where h = 0.2.
    let of = |model: Model, method: &str, h: f64, end: f64| {
        cell(model, [1.0, 0.0], method, h, end).verdict
    };
    let oscillator = Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.0]);
    for (h, expected) in [(0.1, Verdict::Right), (0.3, Verdict::Late), (0.4, Verdict::Late)] {
        assert_eq!(of(oscillator.clone(), "leapfrog", h, 60.0), expected, "{h}");
    }
    // Near its limit the amplitude is wrong as well.
    assert_eq!(of(oscillator.clone(), "leapfrog", 1.7, 60.0), Verdict::Wrong);
    // A limit cycle, with a reservoir that fills and empties.
    let cycle = Model::of(&VAN_DER_POL, &[1.0]);
    assert_eq!(of(cycle.clone(), "moddg", 0.02, 100.0), Verdict::Right);
    assert_eq!(of(cycle, "moddg", 0.2, 100.0), Verdict::Late);
    // What loses energy at another rate is not late.
    let damped = |b| Model::of(&DAMPED_OSCILLATOR, &[1.0, b]);
    assert_eq!(of(damped(6.0), "moddg", 2.0, 60.0), Verdict::Wrong);
    assert_eq!(of(damped(0.02), "moddg", 0.3, 60.0), Verdict::Late);
}
