//! Maps: their cells in lanes and on threads, their atlas, any parameter, and an early stop.

use super::{custom, rows, spread, well};
use crate::after::After;
use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, MapError, Verdict, atlas};
use afterbay_systems::{
    DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, FPUT_CHAIN, VAN_DER_POL,
};
use std::sync::atomic::AtomicUsize;

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

/// Friction with a skew part takes other steps than symmetric friction, which b = 0 gives.
#[test]
fn symmetric_friction_beside_skew_friction_changes_no_verdict() {
    let friction = ["c*v1 - b*v2", "b*v1 + c*v2"];
    let model = custom("-(q1^2 + q2^2)/2", &friction, &[("b", 3.0), ("c", 0.02)]);
    let problem = Problem { model, q: vec![0.1, 0.0], p: vec![0.0; 2], end: 50.0 };
    let (values, steps) = (spread(5, 0.0, 4.0), [0.05, 0.5]);
    let (end, least_steps) = (50.0, 100);
    let map = Map { problem, parameter: "b", values: &values, steps: &steps, end, least_steps };
    let methods = rows(&["increment-1", "increment-2", "rk4"]);
    let references = map.references(&Silent).expect("references");
    let together = map.judge(&methods, &references, &Silent).expect("cells");
    let alone = map.judge_alone(&methods, &references, &Silent).expect("cells");
    assert_eq!(together, alone);
    assert!(together.iter().all(|cell| cell.verdict != Verdict::PassivityViolated));
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
