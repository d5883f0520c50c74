//! Splitting methods with projection: stability, failures, K over many steps, D that is not linear.

use crate::bind::curved;
use crate::catalog::{As, Both, Built, chain, duffing};
use crate::k_on_expressions::custom;
use crate::many;
use crate::rubbed::Rubbed;
use afterbay_core::{
    DissipationForm, Effort, Formulas, FromFormulas, Grid, InputError, IntegrateError, Method,
    Passive, Quad, RunError, Scalar, Separable, State, StepFailure, Tolerance, integrate,
};
use afterbay_methods::registry::{Setting, find};
use afterbay_methods::{Composition, Splitting};
use allocation_counter::measure;
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn methods() -> [(f64, Splitting); 3] {
    let of = |composition| Splitting::new(composition).unwrap();
    [
        (2.0, of(Composition::pair())),
        (6.315, of(Composition::blanes_moan4())),
        (6.146, of(Composition::blanes_moan6())),
    ]
}

/// A run without observation.
fn run(
    method: &Splitting,
    system: &dyn Separable<f64>,
    (h, steps): (f64, u64),
    state: &mut State<Vec<f64>>,
) -> Result<Effort, IntegrateError> {
    integrate(method, system, Grid::of(h, steps)?, state, &mut ())
}

/// The limits that the documentation states, for the fastest mode of a chain whose energy is in
/// the slowest: just below, its share stays at rounding; just above, it grows until a step fails.
#[test]
fn the_limits_of_stability_are_those_stated() {
    let n = 15;
    let angle = |k: usize| PI * k as f64 / (n + 1) as f64;
    let (chain, fastest) = (chain(n, 0.0, 0.0).separable(), 2.0 * (0.5 * angle(n)).sin());
    for (limit, method) in methods() {
        let go = |share: f64| {
            let q = (1..=n).map(|j| angle(j).sin()).collect();
            let mut state = State::new(q, vec![0.0; n]).unwrap();
            run(&method, &*chain, (share * limit / fastest, 400), &mut state)
        };
        go(0.99).unwrap_or_else(|error| panic!("below {limit}: {error}"));
        let Err(IntegrateError::Run(error)) = go(1.01) else { panic!("none beyond {limit}") };
        assert!(matches!(error.failure, StepFailure::ProjectionFailed { .. }), "{error}");
    }
}

/// The growth per step of an oscillator with frequency 1 without projection, from the trace of the
/// matrix of a step; 1 if it is bounded.
fn growth(composition: &Composition, h: f64) -> f64 {
    // The images of (1, 0) and (0, 1).
    let mut images = [[1.0, 0.0], [0.0, 1.0]];
    let fractions: Vec<f64> = composition.fractions().collect();
    for pair in fractions.chunks_exact(2) {
        for [q, p] in &mut images {
            *q += pair[0] * h * *p;
            *p -= (pair[0] + pair[1]) * h * *q;
            *q += pair[1] * h * *p;
        }
    }
    let half = (0.5 * (images[0][0] + images[1][1])).abs();
    if half > 1.0 { half + (half * half - 1.0).sqrt() } else { 1.0 }
}

/// The resonance that the documentation states: bounded up to it and beyond it, and within it the
/// growth stated.
#[test]
fn the_resonance_is_weak() {
    for (composition, limit, percent) in
        [(Composition::blanes_moan4(), 6.31, 1.4), (Composition::blanes_moan6(), 6.14, 0.8)]
    {
        let (mut inside, mut outside) = (1.0_f64, 1.0_f64);
        for step in 1..(1000.0 * limit) as u32 {
            let h = 1e-3 * f64::from(step);
            let most = if (3.13..3.17).contains(&h) { &mut inside } else { &mut outside };
            *most = most.max(growth(&composition, h));
        }
        println!("up to {limit}: {inside} in the resonance, {outside} elsewhere");
        assert!(outside < 1.0 + 1e-6, "{outside}");
        assert!((100.0 * (inside - 1.0) - percent).abs() < 0.05, "{inside}");
        assert!(growth(&composition, limit + 0.02) > 1.01);
    }
}

/// 200,000 steps of a chain: the errors of K do not add up, for short steps as for long ones.
#[test]
fn k_does_not_drift() {
    let chain = chain(5, 0.5, 0.001);
    for name in ["splitting-2", "splitting-4", "splitting-6"] {
        let run = chain.bind(find(name).unwrap(), As::Separable).unwrap();
        for h in [1e-4, 0.2] {
            let mut state = State::new(vec![0.5, -0.3, 0.8, 0.1, 0.2], vec![0.1; 5]).unwrap();
            let total = state.total(&*chain);
            let mut worst = 0.0_f64;
            run.run(Grid::of(h, 200_000).unwrap(), &mut state, 1, &mut |_, state| {
                worst = worst.max((state.total(&*chain) - total).abs());
                ControlFlow::Continue(())
            })
            .unwrap();
            assert!(worst < 16.0 * f64::EPSILON * total, "{name}, h = {h}: {worst:e}");
        }
    }
}

/// Two bodies of unequal masses with a drag cubic in the velocity.
#[derive(Clone, Copy)]
struct Viscous;

impl Formulas for Viscous {
    fn dof(&self) -> usize {
        2
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let apart = q[0] - q[1];
        apart * apart * (q[0] * q[0] + T::one()) - q[0].sin_cos().1 - q[1].sin_cos().1
    }
    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], j: usize) -> T {
        T::from_f64(0.3) * (T::one() + q[j] * q[j]) * v[j] * (T::one() + v[j] * v[j])
    }
    fn mass(&self, j: usize) -> f64 {
        [1.0, 2.5][j]
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::GENERAL }
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

#[test]
fn orders_with_masses_and_cubic_drag() {
    let (system, end) = (FromFormulas(Viscous), 4.0);
    let start = || State::new(vec![0.9, -0.4], vec![0.3, 0.8]).unwrap();
    let (mut exact, setting) = (start(), Setting::Tolerance(Tolerance::all(1e-13), end));
    let accurate = curved(find("adaptive-verner98").unwrap(), FromFormulas(Viscous)).unwrap();
    accurate.run(setting, &mut exact, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
    for ((_, method), (order, counts)) in
        methods().iter().zip([(2.0, [400, 800]), (4.0, [100, 200]), (6.0, [60, 90])])
    {
        let errors = counts.map(|steps: u64| {
            let mut state = start();
            let total = state.total(&system);
            let effort = run(method, &system, (end / steps as f64, steps), &mut state).unwrap();
            assert!(effort.iterations > 0, "p½ is solved");
            // Each step rounds K anew, so that its error grows with the root of their number.
            let roundings = 8.0 * (steps as f64 / 200.0).sqrt().max(1.0);
            assert!((state.total(&system) - total).abs() < roundings * f64::EPSILON * total.abs());
            many::errors(&state, &exact)
        });
        for (coarse, fine) in errors[0].iter().zip(&errors[1]) {
            let slope = (coarse / fine).ln() / (counts[1] as f64 / counts[0] as f64).ln();
            println!("order {order}: {coarse:.1e} {fine:.1e} {slope:.3}");
            assert!((slope - order).abs() < 0.1, "order {order}: {slope} {errors:?}");
        }
    }
}

#[test]
fn what_it_cannot_do_is_refused_by_name() {
    for (_, method) in methods() {
        let rubbed: &dyn Separable<f64> = &Rubbed { c: 0.1 };
        let refused = Method::<Vec<f64>, _>::workspace(&method, rubbed).map(|_| ());
        let Err(InputError::Unsupported { why, .. }) = refused else {
            panic!("{method:?} takes D that couples momenta")
        };
        assert!(why.contains("couples the momenta"), "{why}");
    }
    let odd = Splitting::new(Composition::sweep()).unwrap_err().to_string();
    assert_eq!(odd, "parameter number of fractions = 1.0 must be even");
}

#[test]
fn a_failing_step_leaves_the_state_and_steps_do_not_allocate() {
    let chain = &*chain(3, 0.5, 0.1).separable::<f64>();
    for (_, method) in methods() {
        let mut state = State::new(vec![0.5, -0.3, 0.8], vec![0.1; 3]).unwrap();
        let mut workspace = method.workspace(chain).unwrap();
        let allocated = measure(|| {
            for _ in 0..50 {
                method.step(chain, 0.1, &mut state, &mut workspace).unwrap();
            }
        });
        assert_eq!(allocated.count_total, 0);
        let before = state.clone();
        assert!(method.step(chain, 50.0, &mut state, &mut workspace).is_err());
        assert_eq!(state, before);
        let mut fresh = method.workspace(chain).unwrap();
        let mut other = state.clone();
        method.step(chain, 0.1, &mut other, &mut fresh).unwrap();
        method.step(chain, 0.1, &mut state, &mut workspace).unwrap();
        assert_eq!(other, state, "a failed step left something behind");
    }
}

/// At an equilibrium away from the origin, one rounding beside it: no change of q restores K.
#[test]
fn at_rest_but_for_a_rounding() {
    let duffing = &*duffing(-3.0, 0.1, 0.1).separable();
    for (_, method) in methods() {
        for off in [0.0, f64::EPSILON, -4.0 * f64::EPSILON, 1e-12] {
            let mut state = State::new(vec![30.0_f64.sqrt() * (1.0 + off)], vec![0.0]).unwrap();
            let total = state.total(duffing);
            run(&method, duffing, (0.05, 5000), &mut state)
                .unwrap_or_else(|error| panic!("{off:e}: {error}"));
            assert!((state.total(duffing) - total).abs() <= 1e-14 * total.abs());
        }
    }
}

/// A long step on which q grows to 4e102. H is 9e307, but its terms q ∂V/∂q overflow, so that no
/// error of K can be compared with them.
#[test]
fn a_step_is_refused_if_the_terms_of_h_overflow() {
    fn check<T: Both>(system: &Built) {
        let q = [-1.7452836713585562, -1.9057012314616473];
        let before = many::start([&q, &[-3.8807856605135695, -3.0905686198187223]]);
        let (run, mut state) = (
            system.bind::<T>(find("splitting-4").unwrap(), As::Separable).unwrap(),
            before.clone(),
        );
        let taken = run.step(T::from_f64(8.947101652442445), &mut state);
        let Err(IntegrateError::Run(RunError { failure, .. })) = taken else { panic!("{taken:?}") };
        assert!(
            matches!(failure, StepFailure::ProjectionFailed { excess } if excess > 1e307),
            "{failure}"
        );
        assert_eq!(state, before);
    }
    let potential = "(q1^2 + q2^2)/20 + 1.0996327471061373*abs(q1)^3 \
                     + 1.0430407371066857*atan(q1 + 3*q2)";
    let system = custom(potential, "c*p/(1 + q1^2)", 2, 0.05455789674116246);
    check::<f64>(&system);
    check::<Quad>(&system);
}
