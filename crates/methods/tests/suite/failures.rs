//! Failures of steps: each names the place, the cause and the size of the error, and leaves the
//! state unchanged.

use crate::bind::{Curved, by_force};
use crate::catalog::{As, Built, duffing, modified_van_der_pol, oscillator, van_der_pol};
use afterbay_core::{
    Block, Curvature, Dissipation, Formulas, FromFormulas, Grid, InputError, IntegrateError,
    Method, Quantity, RunError, Scalar, Separable, State, StateRef, StepFailure, System, Tolerance,
    integrate_within,
};
use afterbay_methods::moddg::steps::Equation;
use afterbay_methods::registry::{FIXED, Needs, Run, find};
use afterbay_methods::{AdaptiveCollocation, Collocation, Gonzalez, LinearSolver};
use std::ops::ControlFlow;

/// A free particle with D = 0.1 p and V = 0 up to q = 1, beyond which the force is NaN.
struct Wall;

impl Wall {
    fn force(at: f64) -> f64 {
        if at > 1.0 { f64::NAN } else { 0.0 }
    }
}

impl System<f64> for Wall {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, _q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (Self::force(q[0]), p[0]);
    }
    fn dissipation(&self, _q: &[f64], p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.1 * p[0];
    }
}

impl Separable<f64> for Wall {
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        Self::force(at)
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.1 * p[0], by_q: 0.0, by_p: 0.1 }
    }
}

/// Two degrees of freedom coupled by q1 q2; the force on the second is NaN where q2 > 1.
pub(crate) struct Pair;

impl System<f64> for Pair {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (p[0] * p[0] + p[1] * p[1]) / 2.0 + q[0] * q[1]
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hp.copy_from_slice(p);
        (hq[0], hq[1]) = (self.partial(q, 0, q[0]), self.partial(q, 1, q[1]));
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(0.0);
    }
}

impl Separable<f64> for Pair {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        if j == 1 && at > 1.0 { f64::NAN } else { q[1 - j] }
    }
    fn dissipation_of(&self, _q: &[f64], _p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.0, by_q: 0.0, by_p: 0.0 }
    }
}

pub(crate) fn state(q: f64, p: f64) -> State<[f64; 1]> {
    State::new([q], [p]).unwrap()
}

pub(crate) fn bound(name: &str, system: &Built) -> Run<f64> {
    system.bind(find(name).unwrap(), As::Nonlinear).unwrap()
}

pub(crate) fn closed(name: &str, system: &Built) -> Run<f64> {
    system.bind(find(name).unwrap(), As::Linear).unwrap()
}

/// The failure of a step, after checking that the state is unchanged.
pub(crate) fn failure(run: &Run<f64>, h: f64, start: &State<[f64; 1]>) -> StepFailure {
    let mut state = start.clone();
    let error = run.step(h, &mut state).unwrap_err();
    assert_eq!(&state, start, "{error}");
    let IntegrateError::Run(RunError { step: 1, failure, .. }) = error else { panic!("{error}") };
    failure
}

/// Checks that the message contains all of these parts.
pub(crate) fn assert_says(error: &impl std::fmt::Display, parts: &[&str]) {
    let message = error.to_string();
    for part in parts {
        assert!(message.contains(part), "no {part:?} in {message:?}");
    }
}

/// Runs until the force is NaN, and checks that the state is that after the last successful step.
fn run_into_the_wall(name: &str, step: u64, failure: impl Fn(&StepFailure) -> bool) {
    let h = 0.125;
    let start = || State { t: 5.0, ..State::new(vec![-0.3], vec![1.0]).unwrap() };
    let (mut met, mut good) = (start(), start());
    let run = |steps: u64, state: &mut State<Vec<f64>>| {
        let run = by_force(find(name).unwrap(), Wall).unwrap();
        run.run(Grid::of(h, steps).unwrap(), state, 1, &mut |_, _| ControlFlow::Continue(()))
    };
    let error = run(100, &mut met).unwrap_err();
    run(step - 1, &mut good).unwrap();
    let IntegrateError::Run(error) = error else { panic!("{error}") };
    assert!(error.step == step && error.t == good.t && failure(&error.failure), "{error:?}");
    assert_eq!(met, good);
    assert!(met.t == 5.0 + h * (step - 1) as f64 && met.check(1).is_ok());
    assert_says(&error, &[&format!("step {step} "), &format!("t = {}", met.t), "1 becomes NaN"]);
}

#[test]
fn a_force_that_ends_stops_the_run_at_the_last_good_step() {
    let of = |wanted: Quantity| {
        move |failure: &StepFailure| {
            let StepFailure::NonFinite { quantity, dof: 0, value } = failure else { return false };
            *quantity == wanted && value.is_nan()
        }
    };
    // A step fails when a trial point lies behind the wall; the particle needs 1.4 time units to
    // reach it.
    run_into_the_wall("leapfrog", 12, of(Quantity::Momentum));
    run_into_the_wall("rk4", 12, of(Quantity::Coordinate));
    run_into_the_wall("moddg", 12, of(Quantity::Force));
    run_into_the_wall("moddg-fixed-point", 12, of(Quantity::Force));
}

#[test]
fn the_degree_of_freedom_is_named() {
    for (name, quantity) in [("leapfrog", Quantity::Momentum), ("rk4", Quantity::Momentum)] {
        let mut state = State::new(vec![0.0, 0.9], vec![0.0, 1.0]).unwrap();
        let run = by_force(find(name).unwrap(), Pair).unwrap();
        let mut look = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let error = run.run(Grid::of(0.2, 9).unwrap(), &mut state, 1, &mut look);
        let IntegrateError::Run(RunError { step: 1, t: 0.0, failure }) = error.unwrap_err() else {
            panic!()
        };
        let StepFailure::NonFinite { quantity: found, dof: 1, .. } = failure else {
            panic!("{failure}")
        };
        assert_eq!(found, quantity);
        assert_says(&failure, &["p2 becomes NaN"]);
    }
}

#[test]
fn a_stiff_simple_iteration_does_not_contract() {
    let stiff = &duffing(1e3, 1.0, 0.1);
    let found = failure(&bound("moddg-fixed-point", stiff), 1.0, &state(1.0, 0.5));
    let StepFailure::NotContracting { dof: 0, iterations, ratio } = found else {
        panic!("{found}")
    };
    assert!(iterations > 3 && ratio > 1.0, "{found}");
    assert_says(
        &found,
        &["degree of freedom 1", &format!("{iterations} iterations"), &format!("{ratio:.2e}")],
    );
    // Newton's method takes the step.
    bound("moddg", stiff).step(1.0, &mut state(1.0, 0.5)).unwrap();
}

#[test]
fn a_simple_iteration_far_from_contracting_is_not_taken_for_done() {
    // ∂F/∂v is -2e12 here, so the rounding of q changes F by as much as the updates, which must not
    // count as convergence.
    let (mu, alpha, beta) = (-4.639779684474526, 3.7658394849613304, -8.126693682460336e-12);
    let system = &modified_van_der_pol(mu, alpha, beta);
    let run = bound("moddg-fixed-point", system);
    let found = failure(&run, 1.922333041947047, &state(680728.5370767893, 0.0));
    assert!(matches!(found, StepFailure::NotContracting { .. }), "{found}");
}

#[test]
fn a_solution_that_does_not_last_to_the_end_of_the_step_is_none() {
    // V = -q²/2 - 5 q⁴/4 is unbounded below: the solution that continues from h = 0 merges with
    // another before the end of the step, and both vanish.
    let found = failure(&bound("moddg", &duffing(-1.0, -5.0, 0.1)), 5.0, &state(2.0, 1.0));
    let StepFailure::SeveralSolutions { dof: 0, share } = found else { panic!("{found}") };
    assert!(share > 0.0 && share < 0.2, "{found}");
    assert_says(&found, &["degree of freedom 1", "several solutions", "smaller step"]);
}

#[test]
fn delta_q_has_its_pole_at_turning_points() {
    let system = &oscillator(1.0, 0.1);
    for row in FIXED.iter().filter(|row| row.poles().contains(&Equation::Q)) {
        let found = failure(&closed(row.name, system), 0.1, &state(1.0, 0.0));
        assert_eq!(found, StepFailure::Pole { dof: 0, denominator: 0.0 }, "{}", row.name);
        assert_says(&found, &["degree of freedom 1", "pole", "0e0"]);
    }
    let nonlinear_pole =
        failure(&bound("moddg-q3-shared", &van_der_pol(0.5)), 0.1, &state(1.5, 0.0));
    assert!(matches!(nonlinear_pole, StepFailure::Pole { .. }), "{nonlinear_pole}");
}

#[test]
fn delta_p_has_its_pole_where_the_force_vanishes() {
    // k q + b p = 0 exactly.
    let (system, start) = (&oscillator(2.0, 0.5), state(0.25, -1.0));
    for row in FIXED.iter().filter(|row| row.poles().contains(&Equation::P)) {
        let found = failure(&closed(row.name, system), 0.1, &start);
        assert_eq!(found, StepFailure::Pole { dof: 0, denominator: 0.0 }, "{}", row.name);
    }
}

#[test]
fn a_system_at_rest_is_a_pole_too() {
    for row in FIXED.iter().filter(|row| !row.poles().is_empty()) {
        let found = failure(&closed(row.name, &oscillator(1.0, 0.1)), 0.1, &state(0.0, 0.0));
        assert_eq!(found, StepFailure::Pole { dof: 0, denominator: 0.0 }, "{}", row.name);
    }
}

#[test]
fn without_damping_there_is_no_pole() {
    for row in FIXED.iter().filter(|row| row.needs != Needs::Printed) {
        for start in [state(1.0, 0.0), state(0.0, 1.0)] {
            closed(row.name, &oscillator(1.0, 0.0)).step(0.1, &mut start.clone()).unwrap();
        }
    }
}

#[test]
fn a_closed_form_without_a_solution_is_singular() {
    // σ = 1 + h/2 (b + h k/2) = 1 + (-2.5 + 0.5)/2 = 0.
    let found = failure(&closed("moddg", &oscillator(1.0, -2.5)), 1.0, &state(1.0, 1.0));
    assert_eq!(found, StepFailure::Singular { dof: 0, slope: Some(0.0) });
    assert_says(&found, &["degree of freedom 1", "0e0", "singular"]);
    // Newton's method finds no solution either.
    let found = failure(&bound("moddg", &oscillator(1.0, -2.5)), 1.0, &state(1.0, 1.0));
    assert!(
        matches!(found, StepFailure::NewtonStalled { iterations, .. } if iterations > 50),
        "{found}"
    );
    assert_says(&found, &["degree of freedom 1", "iterations", "last update"]);
}

#[test]
fn leapfrog_is_singular_where_the_drive_cancels_the_momentum() {
    // 1 + h/2 ∂D/∂p = 1 - h/2 μ (1 - q²) = 0.
    let found = failure(&bound("leapfrog", &van_der_pol(4.0)), 0.5, &state(0.0, 1.0));
    assert_eq!(found, StepFailure::Singular { dof: 0, slope: Some(0.0) });
}

/// An oscillator of one degree of freedom, whose derivatives name a second one.
struct Misnamed;

impl System<f64> for Misnamed {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (q[0] * q[0] + p[0] * p[0]) / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (q[0], p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.0;
    }
}

impl Curvature<f64> for Misnamed {
    fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hqq, 0, 1, 1.0);
        put(Block::Hpp, 0, 0, 1.0);
    }
}

#[test]
fn a_derivative_by_a_coordinate_that_does_not_exist_is_refused() {
    let system: &Curved<f64> = &Misnamed;
    let refused = |error: &InputError| match error {
        InputError::Unsupported { why, .. } => why.contains("does not exist"),
        _ => false,
    };
    let method = Collocation::new(2);
    let fixed = Method::<Vec<f64>, _>::workspace(&method, system).map(drop).unwrap_err();
    assert!(refused(&fixed), "{fixed}");
    for relative in [1e-3, 1e-9] {
        let (mut state, tolerance) = (state(1.0, 0.0), Tolerance::all(relative));
        let method = AdaptiveCollocation;
        let found = integrate_within(&method, system, &tolerance, 1.0, &mut state, &mut ());
        let Err(IntegrateError::Input(error)) = found else { panic!("{found:?}") };
        assert!(refused(&error), "{error}");
    }
}

/// A system without degrees of freedom.
struct Nobody;

impl System<f64> for Nobody {
    fn dof(&self) -> usize {
        0
    }
    fn energy(&self, _q: &[f64], _p: &[f64]) -> f64 {
        0.0
    }
    fn gradient(&self, _q: &[f64], _p: &[f64], _hq: &mut [f64], _hp: &mut [f64]) {}
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], _d: &mut [f64]) {}
}

impl Curvature<f64> for Nobody {
    fn curvature(&self, _q: &[f64], _p: &[f64], _put: impl FnMut(Block, usize, usize, f64)) {}
}

#[test]
fn no_degrees_of_freedom_are_nothing_to_do() {
    for solver in LinearSolver::ALL {
        let mut state = State::new(vec![], vec![]).unwrap();
        let method = Gonzalez { solver: Some(solver) };
        let nobody: &Curved<f64> = &Nobody;
        let mut workspace = method.workspace(nobody).unwrap();
        method.step(nobody, 0.1, &mut state, &mut workspace).unwrap();
        assert_eq!(state.dof(), 0);
    }
}

#[test]
fn a_step_of_no_time_changes_nothing() {
    for row in FIXED.iter().filter(|row| row.poles().is_empty()) {
        let solved = duffing(1.0, 1.0, 0.5).bind(row, As::Nonlinear).ok();
        let closed = oscillator(2.0, 0.5).bind(row, As::Linear).ok();
        for run in solved.into_iter().chain(closed) {
            let (start, mut after) = (state(1.3, -0.7), state(1.3, -0.7));
            let outcome = run.step(0.0, &mut after);
            assert!(outcome.is_ok() && after == start, "{}: {outcome:?} {after:?}", row.name);
        }
    }
}

/// V = acos(cos q), a triangular wave, which is not known to rounding where q is a multiple of π.
struct Zigzag;

impl Formulas for Zigzag {
    fn dof(&self) -> usize {
        1
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        q[0].cos().acos()
    }

    fn dissipation<T: Scalar>(&self, _q: &[T], _v: &[T], _j: usize) -> T {
        T::zero()
    }
}

#[test]
fn a_run_that_stands_still_ends() {
    let mut longest = 0;
    for p in [2.9, 3.0, 3.1, 3.2, 3.3, 3.4, 3.5] {
        let mut state = State::new([1.0], [p]).unwrap();
        let mut watch = |n: u64, _: &State<[f64; 1]>| {
            longest = longest.max(n);
            if n < 100_000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let (method, tolerance) = (AdaptiveCollocation, Tolerance::all(1e-9));
        let system = FromFormulas(Zigzag);
        let done = integrate_within(&method, &system, &tolerance, 10.0, &mut state, &mut watch);
        let Err(IntegrateError::Run(error)) = done else { panic!("p = {p}: {done:?} {state:?}") };
        // Roundings of V near the kink may also differ from its gradient.
        let (failure, pi) = (error.failure, std::f64::consts::PI);
        let named =
            matches!(failure, StepFailure::Vanishes { .. } | StepFailure::NotGradient { .. });
        assert!(named, "p = {p}: {error}");
        assert!((state.q[0] - pi).abs() < 1e-3, "p = {p}: {state:?}");
    }
    assert!(longest > 1000, "no run stands still: at most {longest} steps");
}
