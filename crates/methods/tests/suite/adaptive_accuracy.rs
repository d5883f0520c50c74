//! Errors of the methods with step size control relative to the tolerance, against end states from
//! other libraries, Taylor series and exact flows.
//!
//! `cargo test -p afterbay-methods --test suite adaptive_accuracy -- --nocapture` prints the table.

use crate::bind::{Curved, erased};
use crate::catalog::{As, Built, chain, duffing, oscillator, pendulum, van_der_pol, written};
use crate::many::{InSeries, exact_end, start};
use afterbay_core::{Formulas, FromFormulas, Grid, Scalar, State, Statistics, Tolerance};
use afterbay_methods::registry::{ADAPTIVE, Row, Setting, find};
use afterbay_systems::{Description, DissipationText};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;

/// End states of the test set, by heyoka in 113 bits and by Taylor series in 106 bits
/// (benches/peers/data/references.py and benches/peers/examples/references.rs).
const REFERENCES: &str = include_str!("../../../../benches/peers/data/references.csv");

/// q, p and w at the end of a scene.
fn reference(scene: &str) -> [Vec<f64>; 3] {
    let rows = REFERENCES.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let rows: Vec<_> = rows.filter(|row| row[0] == scene).collect();
    [2, 3, 4].map(|column| rows.iter().map(|row| row[column].parse().unwrap()).collect())
}

/// q, p and w at the end, by Taylor series.
fn series(system: &InSeries<f64>, from: [&[f64]; 2], end: f64) -> [Vec<f64>; 3] {
    let exact = exact_end(system, &start(from), end);
    [exact.q, exact.p, exact.w]
}

/// q, p and w at the end of a run within a tolerance, and its work.
pub(crate) fn run(
    row: &Row,
    system: &Arc<Curved<f64>>,
    start: [&[f64]; 2],
    end: f64,
    tolerance: f64,
) -> ([Vec<f64>; 3], Statistics) {
    end_of(row, system, start, Setting::Tolerance(Tolerance::all(tolerance), end))
}

fn end_of(
    row: &Row,
    system: &Arc<Curved<f64>>,
    [q, p]: [&[f64]; 2],
    setting: Setting<f64>,
) -> ([Vec<f64>; 3], Statistics) {
    let mut state = State::new(q.to_vec(), p.to_vec()).unwrap();
    let run = erased(row, system.clone()).unwrap();
    let done = run.run(setting, &mut state, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
    ([state.q, state.p, state.w], done)
}

/// The solution of a linear system.
fn linear_exact(system: &Arc<Curved<f64>>, start: [&[f64]; 2], end: f64) -> [Vec<f64>; 3] {
    let steps = Setting::Step(Grid::new(end / 100.0, end).unwrap());
    end_of(find("linear-exact").unwrap(), system, start, steps).0
}

fn far(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// The errors of q, p and w relative to the errors that [`Tolerance`] allows at the end.
fn shares(found: &[Vec<f64>; 3], exact: &[Vec<f64>; 3], tolerance: f64) -> [f64; 3] {
    [0, 1, 2].map(|part| {
        let size = exact[part].iter().fold(1.0, |sum: f64, x| sum.max(1.0 + x.abs()));
        far(&found[part], &exact[part]) / (tolerance * size)
    })
}

/// One line of the table for each method, at tolerances from 1e-3 to 1e-12: the largest error
/// relative to the allowed one. None exceeds ten.
fn lines(
    name: &str,
    system: Arc<Curved<f64>>,
    start: [&[f64]; 2],
    end: f64,
    exact: &[Vec<f64>; 3],
) -> Vec<Vec<f64>> {
    println!("{name}");
    ADAPTIVE.iter().map(|row| line(row, &system, start, end, exact)).collect()
}

pub(crate) fn line(
    row: &Row,
    system: &Arc<Curved<f64>>,
    start: [&[f64]; 2],
    end: f64,
    exact: &[Vec<f64>; 3],
) -> Vec<f64> {
    let mut evaluations = 0;
    let errors: Vec<f64> = (3..=12)
        .map(|digits| {
            let tolerance = 10f64.powi(-digits);
            let (found, done) = run(row, system, start, end, tolerance);
            evaluations += done.effort.evaluations;
            shares(&found, exact, tolerance).into_iter().fold(0.0, f64::max)
        })
        .collect();
    let columns: String = errors.iter().map(|error| format!("{error:8.0e}")).collect();
    println!("  {:22}{columns} {evaluations:9}", row.name);
    assert!(errors.iter().all(|&error| error < 10.0), "{}: {errors:?}", row.name);
    errors
}

pub(crate) fn head() {
    let columns: String = (3..=12).map(|digits| format!("{:>8}", format!("1e-{digits}"))).collect();
    println!("{:24}{columns} {:>9}", "error / allowed at", "evaluated");
}

#[test]
fn errors_are_within_ten_times_the_tolerance() {
    head();
    let a = oscillator(1.0, 0.1).curved();
    lines("A oscillator", a, [&[2.3], &[-3.1]], 100.0, &reference("A"));
    let b = duffing(-1.0, 1.0, 0.1).curved();
    lines("B Duffing", b, [&[1.5], &[0.5]], 50.0, &reference("B"));
    let c1 = van_der_pol(1.0).curved();
    lines("C1 Van der Pol", c1, [&[2.0], &[0.0]], 50.0, &reference("C1"));
    let sine =
        |n: usize| (1..=n).map(|i| (PI * i as f64 / (n + 1) as f64).sin()).collect::<Vec<_>>();
    let d64 = chain(64, 1.0, 0.01).curved();
    lines("D64 chain", d64, [&sine(64), &[0.0; 64]], 100.0, &reference("D64"));
    let e = pendulum([1.0; 2], [1.0; 2], 1.0, [0.1; 2]).curved();
    lines("E double pendulum", e, [&[1.5, -0.5], &[0.0; 2]], 5.0, &reference("E"));
    // Beyond the test set: a pendulum whose solutions diverge from each other, and a chain whose
    // steps are limited by the error.
    let fast = pendulum([1.0; 2], [1.0; 2], 9.81, [0.1; 2]);
    let start: [&[f64]; 2] = [&[1.0, 1.5], &[0.0; 2]];
    lines("double pendulum, fast", fast.curved(), start, 5.0, &series(&*fast.series(), start, 5.0));
    let d8 = chain(8, 1.0, 0.01);
    let q = sine(8);
    let start: [&[f64]; 2] = [&q, &[0.0; 8]];
    lines("chain of 8", d8.curved(), start, 50.0, &series(&*d8.series(), start, 50.0));
}

/// A system with this potential and these dissipative forces.
pub(crate) fn described(potential: &str, forces: &[&str]) -> Built {
    let dissipation = DissipationText::Forces(forces.iter().map(ToString::to_string).collect());
    let potential = potential.to_owned();
    written(&Description { potential, dissipation, ..Description::default() })
}

/// A fast oscillator beside a slow one, for the methods that may take steps longer than its period.
/// Its amplitude of q is that of errors at a tolerance of 1e-6, that of p is 1000 times as large.
#[test]
fn a_small_fast_oscillation_is_seen() {
    head();
    let system = described("q1^2/2 + 5e5*q2^2", &["0", "0.2*v2"]);
    let (start, end): ([&[f64]; 2], f64) = ([&[1.0, 1e-6], &[0.0; 2]], 1.0);
    let exact = series(&*system.series(), start, end);
    for name in ["adaptive-collocation", "adaptive-radau"] {
        line(find(name).unwrap(), &system.curved(), start, end, &exact);
    }
}

/// Two masses that move together on a stiff spring, of which only one is held: the spring
/// oscillates with a small amplitude, which is seen neither in q nor in p.
#[test]
fn a_small_oscillation_of_a_stiff_spring_is_seen() {
    head();
    let system = described("q1^2/2 + 1.5e5*(q2 - q1)^2", &["0.1*v1", "0.1*v2"]);
    let (start, end): ([&[f64]; 2], f64) = ([&[1.0; 2], &[0.0; 2]], 10.0);
    let exact = linear_exact(&system.curved(), start, end);
    line(find("adaptive-radau").unwrap(), &system.curved(), start, end, &exact);
}

/// A mass on a spring in a plane, with a drag proportional to |v| v. It nearly moves along a line:
/// v turns, and the drag with it, within a small part of a step.
#[test]
fn a_drag_that_turns_within_a_step_is_seen() {
    head();
    let drag = |j: usize| format!("v{j}*sqrt(v1^2 + v2^2)");
    let system = described("(q1^2 + q2^2)/2", &[&drag(1), &drag(2)]);
    let (start, end): ([&[f64]; 2], f64) = ([&[1.0, 0.1], &[0.0, 0.01]], 40.0);
    let exact = series(&*system.series(), start, end);
    for name in ["adaptive-collocation", "adaptive-radau"] {
        line(find(name).unwrap(), &system.curved(), start, end, &exact);
    }
}

/// The slope of the drag changes near v = 0 within a small part of a step. It is small beside the
/// spring. A single run may miss it by chance, so that the share of runs counts that err by more
/// than ten times the tolerance. It is 0.2 if the flow is taken for as smooth as the solution.
#[test]
fn a_drag_that_changes_at_low_speed_is_seen() {
    let (row, mut random) = (find("adaptive-collocation").unwrap(), 0.5_f64);
    let (mut runs, mut far, mut largest) = (0.0, 0.0, 0.0_f64);
    for potential in ["q1^2/2", "cosh(q1)"] {
        let system = described(potential, &["0.2*v1*sqrt(v1^2 + 0.0001)"]);
        for _ in 0..20 {
            let [q, p] = [(); 2].map(|()| {
                // The fractional parts of multiples of the golden ratio.
                random = (random + 0.618_033_988_749_895).fract();
                4.0 * random - 2.0
            });
            let (start, end): ([&[f64]; 2], f64) = ([&[q], &[p]], 30.0);
            let exact = series(&*system.series(), start, end);
            for digits in 4..=12 {
                let tolerance = 10f64.powi(-digits);
                let (found, _) = run(row, &system.curved(), start, end, tolerance);
                let error = shares(&found, &exact, tolerance).into_iter().fold(0.0, f64::max);
                (runs, largest) = (runs + 1.0, largest.max(error));
                far += f64::from(u8::from(error > 10.0));
            }
        }
    }
    println!("{far} of {runs} runs, at most {largest:.0} times the tolerance");
    assert!(far < 0.03 * runs && largest < 300.0, "{far} of {runs}, {largest}");
}

/// The forces of a long chain cancel, and at the tightest tolerance the error allowed of p is below
/// the roundings of their terms. Steps do not shrink to it.
#[test]
fn steps_do_not_shrink_to_the_rounding_of_forces_that_cancel() {
    let chain: Arc<Curved<f64>> = chain(64, 1.0, 0.01).curved();
    let q: Vec<f64> = (1..=64).map(|i| (PI * f64::from(i) / 65.0).sin()).collect();
    for row in ADAPTIVE {
        let (_, done) = run(row, &chain, [&q, &[0.0; 64]], 100.0, 1e-14);
        println!("{}: {done:?}", row.name);
        assert!(done.accepted + done.rejected < 2000, "{}: {done:?}", row.name);
    }
}

/// Two coupled pendulums in a fluid, with the drag c|v|v, whose second derivative jumps where a
/// pendulum turns, or with c√|v| v, whose second derivative is not finite there.
#[derive(Clone, Copy)]
struct InFluid {
    c: f64,
    root: bool,
}

impl Formulas for InFluid {
    fn dof(&self) -> usize {
        2
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let twist = q[1] - q[0];
        (twist * twist).half() - q[0].sin_cos().1 - q[1].sin_cos().1
    }

    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        let size = v[j].abs();
        T::from_f64(self.c) * if self.root { size.sqrt() } else { size } * v[j]
    }

    fn kinks<T: Scalar>(&self, _q: &[T], v: &[T], put: &mut dyn FnMut(T)) {
        v.iter().for_each(|&v| put(v));
    }
}

/// Across a kink the order of a method is lost.
#[test]
fn errors_are_within_ten_times_the_tolerance_across_kinks() {
    head();
    for c in [0.1, 2.0] {
        let system = Arc::new(FromFormulas(InFluid { c, root: false }));
        let start: [&[f64]; 2] = [&[2.5, -0.5], &[0.0, 1.0]];
        let exact = series(&*system, start, 20.0);
        lines(&format!("two pendulums in a fluid, c = {c}"), system, start, 20.0, &exact);
    }
}

/// From rest the slopes grow as t^1.5, which the weights of an estimate may hardly see. The runs
/// end at many times, so that their steps differ.
#[test]
fn errors_are_within_three_times_the_tolerance_from_rest_with_a_root_of_the_velocity() {
    let system: Arc<Curved<f64>> = Arc::new(FromFormulas(InFluid { c: 0.3, root: true }));
    let start: [&[f64]; 2] = [&[2.5, -0.5], &[0.0, 0.0]];
    for end in (1..=20).map(|i| 0.35 * f64::from(i)) {
        let verner98 = find("adaptive-verner98").unwrap();
        let (exact, _) = run(verner98, &system, start, end, 1e-13);
        for name in ["adaptive-dop853", "adaptive-verner98", "adaptive-verner87"] {
            for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
                let (found, _) = run(find(name).unwrap(), &system, start, end, tolerance);
                let worst = shares(&found, &exact, tolerance).into_iter().fold(0.0, f64::max);
                assert!(worst < 3.0, "{name} to {end} at {tolerance:e}: {worst}");
            }
        }
    }
}

/// On an oscillator without friction errors are not damped and have one sign: averaged over the
/// tolerances, the error at the end is the allowed one.
#[test]
fn the_tolerance_is_spent_where_errors_stay() {
    head();
    let oscillator = oscillator(1.0, 0.0).curved();
    let (start, end): ([&[f64]; 2], f64) = ([&[2.3], &[-3.1]], 100.0);
    let (sin, cos) = end.sin_cos();
    let exact = [vec![2.3 * cos - 3.1 * sin], vec![-3.1 * cos - 2.3 * sin], vec![0.0]];
    let all = lines("oscillator, no friction", oscillator, start, end, &exact);
    // The estimate of DOP853 is too large by one order of h, so tighter tolerances leave more of
    // the allowed error unused. The estimates of Verner's pairs are errors of the lower order.
    for (row, errors) in ADAPTIVE.iter().zip(&all) {
        let least = match row.name {
            "adaptive-collocation" => 0.4,
            "adaptive-dop853" => 0.04,
            "adaptive-verner98" => 0.002,
            "adaptive-verner87" => 0.004,
            "adaptive-radau" => 0.001,
            _ => continue,
        };
        let mean = (errors.iter().map(|error| error.ln()).sum::<f64>() / 10.0).exp();
        assert!((least..2.5).contains(&mean), "{mean}: {errors:?}");
    }
}

/// The error of w in roundings of the largest H along the run.
const ROUNDINGS: f64 = 8.0;

/// μ = 1000: two jumps in T = 2000, for which explicit methods would need millions of steps.
/// Between jumps solutions converge, so q is accurate to rounding. p = 9e-4 is the difference of
/// forces near 1 over steps of 100 and more, and A-stable steps propagate their rounding errors,
/// which leaves 1e-13. H is near 1e6 in a jump, and w is accurate to a rounding of that.
#[test]
fn stiff_runs_end_where_another_library_does() {
    stiff_run("adaptive-collocation");
    stiff_run("adaptive-radau");
}

fn stiff_run(name: &str) {
    let system = van_der_pol(1000.0);
    let within = system.bind(find(name).unwrap(), As::Curved).unwrap();
    let exact = reference("C2");
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let mut state = State::new([2.0], [0.0]).unwrap();
        let mut largest = 0.0_f64;
        let setting = Setting::Tolerance(Tolerance::all(tolerance), 2000.0);
        let done = within.run(setting, &mut state, 1, &mut |_, state| {
            largest = largest.max(state.energy(&*system));
            ControlFlow::Continue(())
        });
        let done = done.unwrap();
        let found = [state.q, state.p, state.w].map(|part| part.to_vec());
        let [q, p, w] = [0, 1, 2].map(|part| far(&found[part], &exact[part]));
        println!("{tolerance:e}: off by {q:.1e} {p:.1e} {w:.1e}, {done:?}, H up to {largest:.1e}");
        assert!(done.accepted < 2000, "{done:?}");
        let [of_q, of_p, _] = shares(&found, &exact, tolerance);
        assert!(of_q < 10.0 && of_p < 10.0, "{tolerance:e}: {q:e} {p:e}");
        let known = ROUNDINGS * f64::EPSILON * largest;
        assert!(
            w < 10.0 * tolerance + known,
            "{tolerance:e}: w by {w:e}, {known:e} of it roundings"
        );
    }
}
