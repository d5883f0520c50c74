//! Verdicts on runs whose behaviour is known.

use super::{cell, custom, rows, spread, well};
use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, StabilityRow, Verdict};
use afterbay_core::Grid;
use afterbay_methods::registry::find;
use afterbay_systems::{DAMPED_OSCILLATOR, DUFFING, VAN_DER_POL};

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
    // Some sweeps go backwards in time, so that friction returns energy.
    let robbed: Vec<Verdict> =
        spread(25, 0.5, 12.5).into_iter().map(|h| of(2.0, "increment-4", h)).collect();
    assert!(robbed.contains(&Verdict::PassivityViolated), "{robbed:?}");
    assert_eq!(of(0.5, "increment-4", 0.1), Verdict::Right);
    // The exact solution ceases to be finite before the end, and the run does not yet.
    let soft = Model::of(&DUFFING, &[-1.0, -1.0, 0.1]);
    let found = cell(soft, [1.0, 1.0], "moddg", 0.01, 1.2);
    assert!(
        matches!(found.verdict, Verdict::Wrong | Verdict::Growing | Verdict::SeveralSolutions),
        "{found:?}"
    );
    // The Hénon-Heiles system is chaotic: RK4 cannot follow it over this time.
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
fn a_double_well_is_judged_by_size_and_place() {
    // H is negative in the right well, so its logarithm cannot be used.
    for method in ["leapfrog", "rk4", "moddg"] {
        for c in [0.0, 0.05, 0.3, 5.0] {
            assert_eq!(
                cell(well(c), [1.2, 0.3], method, 0.05, 60.0).verdict,
                Verdict::Right,
                "{method} {c}"
            );
        }
    }
    // The start lies between the two basins of attraction, so that coarse steps end in the other
    // well.
    let ends = |method: &str, h: f64| cell(well(0.2), [2.3, -3.1], method, h, 80.0);
    assert_eq!(ends("rk4", 0.02).verdict, Verdict::Right);
    let coarse: Vec<Verdict> =
        spread(40, 0.2, 0.9).into_iter().map(|h| ends("leapfrog", h).verdict).collect();
    assert!(coarse.contains(&Verdict::Wrong) && coarse.contains(&Verdict::Late), "{coarse:?}");
    // With too strong friction the place is right and the size is wrong.
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

/// The verdict on a run with the friction c v, from (0.4, 0.1).
fn damped(potential: &str, [c, h, end]: [f64; 3], method: &str) -> Verdict {
    let model = custom(potential, &["c*v1"], &[("c", c)]);
    let problem = Problem { model, q: vec![0.4], p: vec![0.1], end };
    let (values, steps) = (&[c], &[h]);
    let map = Map { problem, parameter: "c", values, steps, end, least_steps: 1 };
    map.run(&rows(&[method]), &Silent).expect("a map")[0].verdict
}

/// The force is a difference of larger terms. A motion smaller than their roundings does not decay
/// any more, and each method leaves it at another place.
#[test]
fn a_motion_below_the_roundings_of_the_force_is_right() {
    let morse = "(1 - exp(-q1))^2";
    for (potential, c, end) in [
        (morse, 0.4, 400.0),
        (morse, 0.5, 400.0),
        (morse, 2.5, 100.0),
        (morse, 2.5, 600.0),
        ("exp(q1) - q1 - 1", 0.3, 600.0),
        ("1/(1 + q1) + q1 - 1", 2.5, 600.0),
    ] {
        for method in ["leapfrog", "rk4", "moddg", "collocation-4"] {
            let found = damped(potential, [c, 0.05, end], method);
            assert_eq!(found, Verdict::Right, "{potential} {c} {end} {method}");
        }
    }
    // A method that decays too slowly is still wrong.
    assert_eq!(damped(morse, [8.0, 2.0, 60.0], "moddg"), Verdict::Wrong);
}

/// Short steps round q more often than long ones. A value whose reference needs shorter steps does
/// not spoil the references of the other steps, which were resolved before.
#[test]
fn roundings_at_a_place_of_rest_leave_no_run_unjudged() {
    let model = custom("(q1 - 1)^2/2 + (q1 - 1)^4/4", &["c*v1"], &[("c", 2.5)]);
    let problem = Problem { model, q: vec![0.4], p: vec![0.1], end: 100.0 };
    let map = Map {
        problem,
        parameter: "c",
        values: &[2.0, 2.5, 3.0],
        steps: &[0.05, 0.2, 0.8, 1.5],
        end: 100.0,
        least_steps: 1,
    };
    let cells = map.run(&rows(&["leapfrog", "rk4", "moddg"]), &Silent).expect("a map");
    let unjudged = cells.iter().find(|cell| cell.verdict == Verdict::Unjudged);
    assert_eq!(unjudged, None);
    let short = |cell: &&StabilityRow| cell.h == 0.05;
    assert!(cells.iter().filter(short).all(|cell| cell.verdict == Verdict::Right), "{cells:?}");
}

#[test]
fn limit_cycles_are_told_from_each_other() {
    for mu in [0.2, 1.0, 3.0] {
        let of =
            |method, h| cell(Model::of(&VAN_DER_POL, &[mu]), [0.1, 0.0], method, h, 100.0).verdict;
        assert_eq!(of("rk4", 0.02), Verdict::Right, "{mu}");
        // At μ = 3 the jumps of the cycle come late.
        let expected = if mu == 3.0 { Verdict::Late } else { Verdict::Right };
        assert_eq!(of("moddg", 0.02), expected, "{mu}");
    }
    // As h grows, the cycle changes its size first and then disappears.
    let of = |h| cell(Model::of(&VAN_DER_POL, &[3.0]), [2.0, 0.0], "leapfrog", h, 100.0).verdict;
    let coarse: Vec<Verdict> = spread(20, 0.05, 1.0).into_iter().map(of).collect();
    let first = |verdict| coarse.iter().position(|&found| found == verdict).unwrap_or(coarse.len());
    assert!(first(Verdict::Wrong) < first(Verdict::Growing), "{coarse:?}");
    assert!(first(Verdict::Growing) < coarse.len(), "{coarse:?}");
    assert_eq!(first(Verdict::Right), coarse.len(), "{coarse:?}");
}

/// The largest errors of q, p and w over the steps of a run, against the exact solution.
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
        // At the end the reservoir holds 7.45.
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

/// A pendulum that rotates, with g = 9.81 and the energy 200.
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
    // The frequency of leap-frog has the relative error h²/24: 0.1 rad after t = 60 with h = 0.2.
    let of = |model: Model, method: &str, h: f64, end: f64| {
        cell(model, [1.0, 0.0], method, h, end).verdict
    };
    let oscillator = Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.0]);
    for (h, expected) in [(0.1, Verdict::Right), (0.3, Verdict::Late), (0.4, Verdict::Late)] {
        assert_eq!(of(oscillator.clone(), "leapfrog", h, 60.0), expected, "{h}");
    }
    // Near the stability limit the amplitude is wrong as well.
    assert_eq!(of(oscillator.clone(), "leapfrog", 1.7, 60.0), Verdict::Wrong);
    // A limit cycle, with a reservoir that fills and empties.
    let cycle = Model::of(&VAN_DER_POL, &[1.0]);
    assert_eq!(of(cycle.clone(), "moddg", 0.02, 100.0), Verdict::Right);
    assert_eq!(of(cycle, "moddg", 0.2, 100.0), Verdict::Late);
    // A run that loses energy at the wrong rate is not late.
    let damped = |b| Model::of(&DAMPED_OSCILLATOR, &[1.0, b]);
    assert_eq!(of(damped(6.0), "moddg", 2.0, 60.0), Verdict::Wrong);
    assert_eq!(of(damped(0.02), "moddg", 0.3, 60.0), Verdict::Late);
}

/// At the top of its circle a pendulum stands on the roundings of π, and falls when those of its
/// steps let it. H falls too, however small T is in a solution that still stands. After a time no
/// solution is known, with which a run could be compared.
#[test]
fn a_fall_from_an_unstable_equilibrium_is_no_growth() {
    let fall = |potential: &str, method: &str, h: f64, end: f64| {
        let model = custom(potential, &["c*v1"], &[("c", 0.1)]);
        cell(model, [std::f64::consts::PI, 0.0], method, h, end).verdict
    };
    for potential in ["1 - cos(q1)", "-cos(q1)"] {
        for method in ["moddg", "rk4", "leapfrog", "gonzalez"] {
            for h in [0.1, 0.3, 0.5, 1.0] {
                assert_eq!(fall(potential, method, h, 4.0), Verdict::Right, "{method} {h}");
                for end in [10.0, 40.0, 100.0] {
                    assert_eq!(fall(potential, method, h, end), Verdict::Unjudged, "{method} {h}");
                }
            }
        }
    }
    // At the bottom, too, the force is a rounding.
    assert_eq!(fall("1 + cos(q1)", "rk4", 0.1, 100.0), Verdict::Right);
    // A run of leap-frog that leaves the bottom with ever larger steps does grow.
    assert_eq!(fall("q1^2", "leapfrog", 1.5, 100.0), Verdict::Growing);
}
