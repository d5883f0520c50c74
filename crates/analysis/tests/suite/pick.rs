//! Recommendations of `pick` are within the bound all along. The check is independent of its code:
//! it compares runs with the reference at the times of their steps.

use crate::after::After;
use afterbay_analysis::Model;
use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::pick::{self, Candidate, Pick, TooSensitive, Wanted};
use afterbay_core::{Grid, Quad, Scalar, State, StateRef, Tolerance};
use afterbay_methods::registry::{Setting, find};
use afterbay_systems::{Custom, DUFFING, Described, Description, DissipationText, FPUT_CHAIN};
use std::ops::ControlFlow;
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, Instant};

fn custom(potential: &str, dissipation: &str) -> Model {
    let description = Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(vec![dissipation.to_owned()]),
        ..Default::default()
    };
    Model::Custom(Described::Separable(Custom::new(&description).expect("a system")))
}

fn wanted(error: f64) -> Wanted {
    Wanted { error, at_end: false, keep_k: false, passive: false }
}

/// The largest error of q, p and w over the steps of a run with a fixed step.
fn along(problem: &Problem, method: &str, steps: u64) -> f64 {
    let grid = Grid::of(problem.end / steps as f64, steps).expect("a grid");
    let exact = problem.solution(grid.h, steps as usize, &Silent).expect("a reference");
    let run = problem.model.bind(find(method).expect("a method")).expect("it applies");
    let mut worst = 0.0_f64;
    let mut state = problem.start().expect("a state");
    run.run(grid, &mut state, 1, &mut |n, state| {
        let errors = exact.errors(n as usize, state);
        worst = errors.iter().fold(worst, |worst, error| worst.max(error.error));
        ControlFlow::Continue(())
    })
    .expect("it runs");
    worst
}

/// The same at about `most` states of a run whose steps follow from a tolerance.
fn along_within(problem: &Problem, method: &str, tolerance: f64, most: usize) -> f64 {
    let run = problem.model.bind(find(method).expect("a method")).expect("it applies");
    let mut seen: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut state = problem.start().expect("a state");
    let look = &mut |_: u64, state: StateRef<'_, f64>| {
        seen.push((state.t, [state.q, state.p, state.w].concat()));
        ControlFlow::Continue(())
    };
    run.run(Setting::Tolerance(Tolerance::all(tolerance), problem.end), &mut state, 1, look)
        .expect("it runs");
    let every = seen.len().div_ceil(most);
    let mut some: Vec<_> = seen.iter().rev().step_by(every).filter(|(t, _)| *t > 0.0).collect();
    some.reverse();
    // The reference goes from each of these states to the next.
    let mut exact: State<Vec<Quad>> = problem.start().expect("a state");
    let mut off = |(t, z): &(f64, Vec<f64>)| {
        let h = Quad::from_f64(*t) - exact.t;
        let solution = problem.model.solution(&exact, h, 1, &Silent).expect("a reference");
        let StateRef { q, p, w, t } = solution.at(1);
        exact = State { q: q.to_vec(), p: p.to_vec(), w: w.to_vec(), t };
        let all = [q, p, w].concat();
        z.iter().zip(all).map(|(a, b)| (a - b.to_f64()).abs()).fold(0.0, f64::max)
    };
    some.into_iter().map(&mut off).fold(0.0, f64::max)
}

/// The largest error of a candidate, computed without `pick`.
fn checked(problem: &Problem, candidate: &Candidate) -> f64 {
    checked_at(problem, candidate, 20)
}

/// The same, at about `most` states if its steps follow from a tolerance.
fn checked_at(problem: &Problem, candidate: &Candidate, most: usize) -> f64 {
    let run = &candidate.run;
    match run.tolerance {
        None => along(problem, run.method, run.steps),
        Some(tolerance) => along_within(problem, run.method, tolerance, most),
    }
}

fn says(found: &Pick) -> String {
    let one = |c: &Candidate| {
        let qp = c.run.error_qp.unwrap_or(f64::NAN);
        format!("{} {} {qp:.1e} {:?}", c.run.method, c.run.setting(), c.why_not)
    };
    found.qualified.iter().chain(&found.others).map(one).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_double_well_is_followed_all_along_and_not_met_at_the_end() {
    // At the end every run is at rest in a well. Relaxed-dop853 with h = 1.3158 has an error of
    // 4e-13 there, but of 0.8 on the way, and with neighbouring h it ends in the other well.
    let model = Model::of(&DUFFING, &[-1.0, 1.0, 0.3]);
    let problem = Problem { model, q: vec![2.3], p: vec![-3.1], end: 200.0 };
    assert!(along(&problem, "relaxed-dop853", 152) > 0.1);
    let clock = Instant::now();
    let found = pick::run(&problem, wanted(1e-6), &Silent).expect("a pick");
    println!("{:?}\n{}", clock.elapsed(), says(&found));
    assert!(found.qualified.len() > 3, "{}", says(&found));
    for candidate in found.qualified.iter().take(3) {
        let off = checked(&problem, candidate);
        assert!(off <= 1e-6, "{} {}: {off:e}", candidate.run.method, candidate.run.setting());
        assert!(
            candidate.run.tolerance.is_none_or(|tolerance| tolerance < 1e-3),
            "{}",
            says(&found)
        );
    }
    let [qp, w] = found.check.expect("a finer run");
    assert!(qp <= 2e-6 && w <= 2e-6, "{qp:e} {w:e}");
    // At the end alone a longer step suffices, together with its neighbours.
    let at_end =
        pick::run(&problem, Wanted { at_end: true, ..wanted(1e-6) }, &Silent).expect("a pick");
    let of = |found: &Pick, name: &str| {
        found.qualified.iter().find(|one| one.run.method == name).map(|one| one.run.steps)
    };
    let (all, end) = (of(&found, "relaxed-dop853"), of(&at_end, "relaxed-dop853"));
    assert!(all.zip(end).is_some_and(|(all, end)| end < all), "{all:?} {end:?}");
    // Where errors count at the end only, finer runs are compared there only.
    let [qp, w] = at_end.check.expect("a finer run");
    assert!(qp <= 2e-6 && w <= 2e-6, "{qp:e} {w:e}");
    let contradicted = |one: &&Candidate| {
        one.why_not.as_ref().is_some_and(|why| why.contains("finer run differs"))
    };
    assert_eq!(at_end.others.iter().filter(contradicted).count(), 0, "{}", says(&at_end));
}

/// Pseudo-random numbers between 0 and 1: multiples of the golden ratio.
fn share(i: u64, k: u64) -> f64 {
    (0.618_033_988_749_894_9 * (7 * i + k + 1) as f64 + 0.137 * (k * k) as f64).fract()
}

#[test]
fn what_is_recommended_holds_all_along() {
    let mut checks = 0;
    for i in 0..20 {
        let [a, b, c, q, p] = [0, 1, 2, 3, 4].map(|k| share(i, k));
        let model = if i % 2 == 0 {
            Model::of(&DUFFING, &[-0.5 - a, 0.5 + b, 0.05 + 0.5 * c])
        } else {
            let (g, c) = (0.5 + 2.0 * a, 0.02 + 0.3 * c);
            custom(&format!("{g}*(1 - cos(q1))"), &format!("{c}*p1"))
        };
        let end = 2.0 + 3.0 * b;
        let problem = Problem { model, q: vec![4.0 * q - 2.0], p: vec![5.0 * p - 2.5], end };
        let error = [1e-3, 1e-4, 1e-6][i as usize % 3];
        let found = pick::run(&problem, wanted(error), &Silent).expect("a pick");
        assert!(found.qualified.len() > 1, "{i}: {}", says(&found));
        // The winner, the runner-up, and the slowest of those with few steps.
        let few = |one: &&Candidate| one.run.tolerance.is_none() && one.run.steps < 5000;
        let last = found.qualified.iter().rev().find(few);
        for candidate in found.qualified.iter().take(2).chain(last) {
            let run = &candidate.run;
            let off = checked(&problem, candidate);
            assert!(off <= error, "{i}: {} {} errs by {off:e}", run.method, run.setting());
            let said = run.error_qp.zip(run.error_w).map(|(qp, w)| qp.max(w)).expect("errors");
            assert!(off <= said + 0.02 * error || run.steps > 2048, "{i}: {off:e}, said {said:e}");
            checks += 1;
        }
        // Steps near the winner's that `pick` has not tried.
        let run = &found.qualified[0].run;
        let beside = [run.steps * 1000 / 1045, run.steps * 1000 / 985];
        for steps in beside.into_iter().filter(|_| run.tolerance.is_none() && run.steps < 5000) {
            if (0.953..1.05).contains(&(steps as f64 / run.steps as f64)) {
                let off = along(&problem, run.method, steps);
                assert!(off <= 1.1 * error, "{i}: {} with {steps} steps: {off:e}", run.method);
            }
        }
    }
    assert!(checks >= 50, "{checks}");
}

#[test]
fn a_short_end_is_printed_with_an_exponent() {
    let alone = Wanted { at_end: true, ..wanted(1e-8) };
    assert_eq!(wanted(1e-8).place(2e-12), "all along to t = 2e-12");
    assert_eq!([alone.place(2e-12), alone.place(20.0)], ["at t = 2e-12", "at t = 20"]);
}

/// An error of half the amplitude is no small error, in whatever units.
#[test]
fn small_units_are_no_small_errors() {
    let problem = Problem {
        model: custom("q1^2/2 + q1^4/4e-12", "0.02*p1"),
        q: vec![1e-6],
        p: vec![0.0],
        end: 20.0,
    };
    let found = pick::run(&problem, wanted(1e-9), &Silent).expect("it runs");
    let stays =
        |one: &&Candidate| one.why_not.as_ref().is_some_and(|why| why.contains("however small"));
    assert_eq!(found.others.iter().filter(stays).count(), 0, "{}", says(&found));
    assert!(found.qualified.len() > 10, "{}", says(&found));
}

#[test]
fn a_scene_that_is_too_sensitive_is_named() {
    // The start is on the ridge between the wells up to rounding, which grows as e^t.
    let model = Model::of(&DUFFING, &[-1.0, 1.0, 0.0]);
    let problem = Problem { model, q: vec![1e-12], p: vec![0.0], end: 200.0 };
    let found = pick::run(&problem, wanted(1e-6), &Silent).expect("an answer");
    let Some(TooSensitive::Roundings { growth, error, until }) = found.too_sensitive else {
        panic!("{:?}\n{}", found.too_sensitive, says(&found));
    };
    println!("{growth:e} {error:e} {until}");
    assert!(
        growth > 1e9 && error > 1e-6 && until > 5.0 && until < 200.0,
        "{growth:e} {error:e} {until}"
    );
    assert!(found.qualified.is_empty() && found.tried.is_empty());
    // Up to that time the error can be met.
    let shorter = Problem { end: 0.9 * until, ..problem };
    let found = pick::run(&shorter, wanted(1e-6), &Silent).expect("an answer");
    assert!(found.too_sensitive.is_none() && !found.qualified.is_empty(), "{}", says(&found));
}

#[test]
fn a_pick_with_a_kink_is_honest() {
    let problem = Problem {
        model: custom("9.81*(1 - cos(q1))", "0.1*abs(p1)*p1"),
        q: vec![3.0],
        p: vec![0.0],
        end: 10.0,
    };
    let asked = Wanted { error: 1e-6, at_end: false, keep_k: true, passive: true };
    let found = pick::run(&problem, asked, &Silent).expect("a pick");
    let winner = found.qualified.first().expect("some qualify");
    let off = checked_at(&problem, winner, usize::MAX);
    println!("{}: {off:e}", says(&found));
    assert!(off <= 1e-6 && off > 1e-9, "{off:e}");
    // The reported error agrees with the one measured, and with that of a finer run.
    let said =
        winner.run.error_qp.zip(winner.run.error_w).map(|(qp, w)| qp.max(w)).expect("errors");
    assert!((0.95 * said..=1.05 * said).contains(&off), "{off:e}, said {said:e}");
    let [qp, w] = found.check.expect("a finer run");
    assert!((0.2 * said..=1.8 * said).contains(&qp.max(w)), "{qp:e} {w:e}, said {said:e}");
    for candidate in &found.qualified {
        assert_eq!(candidate.run.passivity_violations, Some(0), "{}", candidate.run.method);
        assert!(candidate.run.k_drift < 1e-9, "{}", candidate.run.method);
    }
}

#[test]
fn an_interrupted_pick_has_what_was_found_so_far() {
    let model = Model::of(&DUFFING, &[-1.0, 1.0, 0.3]);
    let problem = Problem { model, q: vec![2.3], p: vec![-3.1], end: 20.0 };
    let stop = After(AtomicUsize::new(0), 4);
    let found = pick::run(&problem, wanted(1e-4), &stop).expect("an answer");
    assert!(found.interrupted && !found.tried.is_empty(), "{}", says(&found));
    assert!(found.qualified.len() + found.others.len() > 1, "{}", says(&found));
    // Methods that were begun give the interruption as the reason; most were not begun.
    let reasons = found.others.iter().map(|one| one.why_not.as_deref());
    assert!(reasons.into_iter().all(|why| why.is_some()), "{}", says(&found));
    assert!(found.qualified.len() + found.others.len() < 10, "{}", says(&found));
    // If nothing was begun, the result is empty and says that it was interrupted.
    let found =
        pick::run(&problem, wanted(1e-4), &After(AtomicUsize::new(0), 0)).expect("an answer");
    assert!(found.interrupted && found.qualified.is_empty() && found.tried.is_empty());
}

/// Asks to stop after a time.
struct Late(Instant, Duration);

impl Progress for Late {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
    fn stopped(&self) -> bool {
        self.0.elapsed() > self.1
    }
}

#[test]
fn a_long_search_ends_soon_after_it_is_asked_to() {
    let mut q = vec![0.0; 40];
    q[0] = 1.0;
    let model = Model::of(&FPUT_CHAIN, &[40.0, 0.3, 0.01]);
    let problem = Problem { model, p: vec![0.0; 40], q, end: 1000.0 };
    for patience in [50, 3000] {
        let (clock, patience) = (Instant::now(), Duration::from_millis(patience));
        let found = pick::run(&problem, wanted(1e-9), &Late(clock, patience)).expect("an answer");
        let late = clock.elapsed().saturating_sub(patience);
        // One second, and another for a machine that is busy with other tests.
        assert!(found.interrupted && late < Duration::from_secs(2), "{late:?}");
    }
}
