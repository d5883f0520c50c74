//! Studies with several degrees of freedom: tables, references, passivity and refusals.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::local_order::{LocalErrors, LocalOrder, Statistic, order};
use afterbay_analysis::study::long_run::Setup;
use afterbay_analysis::study::work_precision::Runs;
use afterbay_analysis::study::{
    MOST_DEGREES_IN_QUAD, Problem, energy, global_order, long_run, trajectory, work_precision,
};
use afterbay_core::{InputError, IntegrateError, Quad, Quantity};
use afterbay_experiments::artifact::Artifact;
use afterbay_methods::registry::{Row, find};
use afterbay_systems::{
    DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, FPUT_CHAIN, MODIFIED_VAN_DER_POL,
    VAN_DER_POL, VAN_DER_POL_RING,
};

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| find(name).unwrap()).collect()
}

fn chain(n: usize, c: f64, end: f64) -> Problem {
    let wave = |speed: f64| (1..=n).map(|j| (speed * j as f64).sin()).collect();
    Problem { model: Model::of(&FPUT_CHAIN, &[n as f64, 1.0, c]), q: wave(0.9), p: wave(2.1), end }
}

fn pendulum(end: f64) -> Problem {
    let model = Model::of(&DAMPED_DOUBLE_PENDULUM, &[1.0, 0.5, 1.0, 0.75, 2.0, 0.1, 0.2]);
    Problem { model, q: vec![1.0, -0.5], p: vec![0.25, 0.5], end }
}

/// The rows by column name, each as long as the header.
fn read(table: &Artifact) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_reader(table.text.as_bytes());
    reader.deserialize().map(Result::unwrap).collect()
}

#[test]
fn books_show_every_reservoir() {
    let problem = chain(3, 0.3, 2.0);
    let runs = energy::run(&problem, &rows(&["increment-2"]), 0.1, 2, &Silent).unwrap();
    let table =
        Artifact::wide_table("energy", &energy::columns(&problem.model), &runs[0].rows).unwrap();
    let records = read(&table);
    assert_eq!(records.len(), 11);
    let number = |i: usize, column: &str| records[i][column].parse::<f64>().unwrap();
    let exact = problem.solution(2.0, 1, &Silent).unwrap();
    let w = [1, 2, 3].map(|j| number(10, &format!("w{j}")));
    let off = (0..3).map(|j| (w[j] - exact.at(1).w[j]).abs()).fold(0.0, f64::max);
    assert_eq!(number(10, "w_error").abs(), off);
    assert!(w.iter().all(|&w| w > 0.05) && off > 1e-6 && off < 1e-1, "{w:?} {off}");
    let lost = number(0, "H") - number(10, "H");
    assert!((lost - w.iter().sum::<f64>()).abs() < 1e-13 && runs[0].drift < 1e-13, "{lost} {w:?}");
}

#[test]
fn trajectories_hold_the_states_asked_for() {
    let runs =
        trajectory::run(&pendulum(1.0), &rows(&["gonzalez", "rk4"]), 0.1, 4, &Silent).unwrap();
    for run in &runs {
        assert!(run.ending.is_completed());
        let table = Artifact::wide_table(
            "trajectory",
            &trajectory::columns(&pendulum(1.0).model),
            &run.rows,
        )
        .unwrap();
        let records = read(&table);
        let column = |name: &str| -> Vec<f64> {
            records.iter().map(|row| row[name].parse().unwrap()).collect()
        };
        // Every fourth state and the last one.
        assert_eq!(column("step"), [0.0, 4.0, 8.0, 10.0]);
        assert_eq!(
            (column("q1")[0], column("q2")[0], column("p1")[0], column("p2")[0]),
            (1.0, -0.5, 0.25, 0.5)
        );
        for i in 0..4 {
            let total = column("H")[i] + (column("w1")[i] + column("w2")[i]);
            assert!((total - column("K")[i]).abs() < 1e-15);
        }
        assert!(column("w2")[2] > column("w2")[1] && column("w2")[1] > 0.0);
    }
}

#[test]
fn a_long_chain_is_followed_in_f64() {
    let problem = chain(MOST_DEGREES_IN_QUAD + 1, 0.1, 2.0);
    let found = problem.solution(0.5, 4, &Silent).unwrap();
    let exact = problem
        .model
        .solution(&problem.start().unwrap(), Quad::from(0.5), 4, &Silent)
        .unwrap()
        .rounded();
    let (off, doubt) = (found.distance(&exact), found.doubt());
    assert!(doubt.most() > 0.0 && doubt.most() < 1e-12 * found.size(), "{doubt:?}");
    assert!(off.q < doubt.q && off.p < doubt.p && off.w < doubt.w, "{off:?} {doubt:?}");
}

#[test]
fn steps_that_are_no_doublings_have_a_solution_of_their_own() {
    let errors = |steps: &[f64]| {
        let rows = global_order::run(&chain(2, 0.1, 1.2), &rows(&["rk4"]), steps, &Silent).unwrap();
        let of = |h: f64| {
            rows.iter().filter(|row| row.h == h).map(|row| row.error.unwrap()).collect::<Vec<_>>()
        };
        [0.1, 0.2, 0.3].map(of)
    };
    let (alone, shared) = (errors(&[0.3]), errors(&[0.3, 0.2, 0.1]));
    assert_eq!(alone[2], shared[2]);
    assert_eq!(errors(&[0.2])[1], shared[1]);
    assert!(shared[1].iter().all(|&error| error > 1e-8 && error < 1e-2), "{shared:?}");
}

#[test]
fn what_is_owed_in_each_is_counted_in_each() {
    let count = |problem: &Problem, name: &str, h: f64| {
        let runs = Runs { methods: &rows(&[name]), steps: &[h], ..Runs::default() };
        work_precision::run(problem, runs, &Silent).unwrap()[0].passivity_violations
    };
    let passive = chain(4, 0.5, 2.0);
    for name in ["increment-1", "increment-2", "gonzalez", "leapfrog", "rk4"] {
        assert_eq!(count(&passive, name, 0.1), Some(0), "{name}");
    }
    // A sweep of this composition runs backwards: with strong friction and long steps it takes
    // energy back. Violations are counted per step, of which there are two, however many masses
    // violate passivity.
    assert!(
        count(&chain(4, 10.0, 2.0), "increment-6", 1.0)
            .is_some_and(|count| (1..=2).contains(&count))
    );
    let ring = Model::of(&VAN_DER_POL_RING, &[4.0, 1.0, 0.5]);
    assert_eq!(count(&Problem { model: ring, ..passive.clone() }, "increment-2", 0.1), None);
}

#[test]
fn local_orders_are_those_of_the_registry() {
    let study = LocalOrder { base_step: 0.01, steps: vec![0.01, 0.02, 0.03] };
    let cases = [
        (chain(3, 0.2, 0.5), &["increment-2", "gonzalez", "rk4"][..]),
        (pendulum(0.5), &["gonzalez"]),
    ];
    for (problem, names) in cases {
        for row in rows(names) {
            let errors = study.run::<Quad>(&problem, &[row], &Silent).unwrap();
            let errors: Vec<&LocalErrors> = errors.iter().collect();
            for variable in 0..3 {
                let found = order(&errors, variable, Statistic::Median).unwrap().slope;
                let claimed = f64::from(row.order().number().expect("not exact"));
                assert!((found - claimed).abs() < 0.1, "{} {variable}: {found}", row.name);
            }
        }
    }
}

/// A chain without friction that starts from rest, slightly higher for each i.
fn at_rest(i: u32) -> Problem {
    let amplitude = 1.0 + f64::from(i) / 256.0;
    let sine = (1..=4).map(|j| amplitude * (0.2 * std::f64::consts::PI * f64::from(j)).sin());
    Problem { q: sine.collect(), p: vec![0.0; 4], ..chain(4, 0.0, 1.0) }
}

fn plain(name: &str, h: f64) -> Setup {
    Setup { row: find(name).unwrap(), h, compensated: false }
}

#[test]
fn a_drift_of_k_is_told_from_its_roundings() {
    let starts: Vec<_> = (0..8).map(at_rest).collect();
    let runs: Vec<_> =
        [("rk4", 0.05), ("increment-2", 0.05)].map(|(name, h)| plain(name, h)).into();
    let runs: Vec<_> = runs
        .into_iter()
        .chain([Setup { compensated: true, ..plain("increment-2", 0.2) }])
        .collect();
    let found = long_run::run(&starts, &runs, 30_000, &Silent).unwrap();
    // rk4 loses energy at a constant rate: its deviation grows like t, and with the same sign from
    // all starts.
    let [drift, roundings, none] = &found[..] else { panic!("{found:?}") };
    let (of_drift, of_roundings) = (drift.growth().unwrap(), roundings.growth().unwrap());
    assert!((of_drift.slope - 1.0).abs() < 0.05, "{of_drift:?}");
    assert!(of_roundings.slope < 0.75, "{of_roundings:?}");
    let (last, alone) = (drift.rows.last().unwrap(), roundings.rows.last().unwrap());
    assert!(-last.mean > 0.95 * last.rms && last.rms > 1e-8, "{last:?}");
    assert!(alone.rms > 1e-16 && alone.rms < 1e-13, "{alone:?}");
    assert_eq!((last.steps, last.t), (30_000, 1500.0));
    // A compensated run deviates by the rounding of the state at which it is sampled.
    assert!(none.growth().unwrap().slope.abs() < 0.25, "{:?}", none.growth());
    assert!(none.rows.iter().all(|row| row.rms > 1e-18 && row.rms < 2e-16), "{:?}", none.rows);
    // A single start, checked step by step, agrees with the windows.
    let [one] = &long_run::run(&starts[..1], &runs[..1], 100, &Silent).unwrap()[..] else {
        panic!()
    };
    let runs =
        &energy::run(&Problem { end: 5.0, ..starts[0].clone() }, &rows(&["rk4"]), 0.05, 1, &Silent);
    let steps = &runs.as_ref().unwrap()[0].rows;
    let mean = steps[1..].iter().map(|row| row.drift).sum::<f64>() / 100.0 / steps[0].energy;
    assert!((one.rows[0].mean - mean).abs() < 1e-14, "{} {mean}", one.rows[0].mean);
}

/// Starts that run side by side give the same results as each alone.
#[test]
fn starts_side_by_side_are_those_alone() {
    let starts = [at_rest(0), at_rest(1), at_rest(2)];
    let rows = rows(&["increment-2", "rk4", "gonzalez"]);
    let setup = |row, compensated| Setup { row, h: 0.1, compensated };
    let setups =
        [setup(rows[0], false), setup(rows[0], true), setup(rows[1], false), setup(rows[2], false)];
    let together = long_run::run(&starts, &setups, 3000, &Silent).unwrap();
    let alone: Vec<_> = starts
        .iter()
        .map(|start| long_run::run(std::slice::from_ref(start), &setups, 3000, &Silent).unwrap())
        .collect();
    for (i, run) in together.iter().enumerate() {
        assert!(run.ending.is_completed());
        for (k, row) in run.rows.iter().enumerate() {
            let means: f64 = alone.iter().map(|runs| runs[i].rows[k].mean).sum();
            let squares: f64 = alone.iter().map(|runs| runs[i].rows[k].rms.powi(2)).sum();
            let (mean, rms) = (means / 3.0, (squares / 3.0).sqrt());
            assert!(
                (row.mean - mean).abs() <= 1e-12 * rms,
                "{} {k}: {} {mean}",
                run.setup.label(),
                row.mean
            );
            assert!(
                (row.rms - rms).abs() <= 1e-12 * rms,
                "{} {k}: {} {rms}",
                run.setup.label(),
                row.rms
            );
        }
    }
}

#[test]
fn only_moddg_and_increments_of_separable_systems_are_compensated() {
    let bind = |problem: Problem, name| {
        problem.model.bind_compensated::<f64>(find(name).unwrap()).map(drop)
    };
    for model in [
        Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]),
        Model::of(&DUFFING, &[1.0, 1.0, 0.1]),
        Model::of(&VAN_DER_POL, &[1.0]),
        Model::of(&MODIFIED_VAN_DER_POL, &[1.0, 1.0, 1.0]),
        Model::of(&FPUT_CHAIN, &[4.0, 1.0, 0.1]),
        Model::of(&VAN_DER_POL_RING, &[6.0, 1.0, 0.5]),
    ] {
        let (q, p) = (vec![0.5; model.dof()], vec![0.1; model.dof()]);
        let problem = Problem { model: model.clone(), q, p, end: 1.0 };
        for name in ["increment-4", "moddg"].into_iter().take(if model.dof() == 1 { 2 } else { 1 })
        {
            let method = model.bind_compensated::<f64>(find(name).unwrap()).unwrap();
            let [mut state, mut plain] = [0; 2].map(|_| problem.start::<f64>().unwrap());
            method.step(0.1, &mut state).unwrap();
            model.bind(find(name).unwrap()).unwrap().step(0.1, &mut plain).unwrap();
            let off = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let off =
                off(&state.q, &plain.q).max(off(&state.p, &plain.p)).max(off(&state.w, &plain.w));
            assert!(off < 1e-14, "{name} on {}: {off:e}", model.name());
        }
        assert!(matches!(bind(problem, "rk4"), Err(InputError::Unsupported { method: "rk4", .. })));
    }
    let refused = bind(pendulum(1.0), "increment-2");
    assert!(matches!(refused, Err(InputError::Unsupported { .. })), "{refused:?}");
}

#[test]
fn a_long_run_that_fails_says_so_and_keeps_what_it_had() {
    let runs = [plain("rk4", 1.6)];
    let found = long_run::run(&[at_rest(0)], &runs, 100_000, &Silent).unwrap();
    assert_eq!(found[0].ending.outcome, "not-finite");
    assert!(found[0].ending.failure.is_some() && found[0].rows.len() < 13, "{:?}", found[0].rows);
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |problem: &Problem, name: &str| {
        let error = energy::run(problem, &rows(&[name]), 0.1, 1, &Silent).unwrap_err();
        let IntegrateError::Input(error) = error else { panic!("{error}") };
        error
    };
    let unsupported = |error| matches!(error, InputError::Unsupported { .. });
    for name in ["leapfrog", "moddg"] {
        assert!(unsupported(refused(&pendulum(1.0), name)), "{name}");
    }
    for name in ["moddg", "moddg-q3-shared", "moddg-p4-single-printed"] {
        assert!(unsupported(refused(&chain(3, 0.1, 1.0), name)), "{name}");
    }
    let short = Problem { q: vec![1.0], p: vec![1.0], ..pendulum(1.0) };
    let long = Problem { q: vec![1.0; 40], p: vec![1.0; 40], ..chain(30, 0.1, 1.0) };
    for (problem, expected, found) in [(short, 2, 1), (long, 30, 40)] {
        let length = InputError::Length { quantity: Quantity::Coordinate, expected, found };
        assert_eq!(refused(&problem, "gonzalez"), length);
        assert_eq!(
            trajectory::run(&problem, &rows(&["rk4"]), 0.1, 1, &Silent).unwrap_err(),
            IntegrateError::Input(length)
        );
    }
    let none =
        Problem { q: vec![], p: vec![], model: Model::of(&FPUT_CHAIN, &[0.0, 1.0, 0.1]), end: 1.0 };
    assert!(matches!(refused(&none, "rk4"), InputError::Parameter { name: "n", .. }));
}
