//! Collocation by Newton's method for any number of degrees of freedom, compared with known
//! solutions.

use super::scenes::{Rubs, Web, drift, falls, wave};
use crate::bind::Curved;
use afterbay_core::{Block, Curvature, DissipationForm, Method, State, StepFailure, System};
use afterbay_methods::{Collocation, Gonzalez};
use afterbay_systems::{DampedOscillator, Duffing, FputChain};

/// Checks that steps converge, conserve K to 16 roundings and decrease no reservoir.
fn solved(
    name: &str,
    system: &Curved<f64>,
    stages: usize,
    h: f64,
    steps: u32,
    start: State<Vec<f64>>,
) {
    let method = Collocation::new(stages);
    let mut workspace = method.workspace(system).unwrap();
    let mut state = start;
    for step in 0..steps {
        let before = state.clone();
        if let Err(failure) = method.step(system, h, &mut state, &mut workspace) {
            panic!("{name}, s = {stages}, h = {h}, step {step}: {failure}");
        }
        let roundings = drift(system, h, &before, &state);
        assert!(
            roundings < 16.0,
            "{name}, s = {stages}, h = {h}: K is off by {roundings} roundings"
        );
        let fell = falls(system.dissipation_form().passive, &before.w, &state.w);
        assert_eq!(fell, 0, "{name}, s = {stages}, h = {h}: reservoirs fell");
    }
}

/// The stability limit of the explicit methods is h = 1 on the linear chain.
#[test]
fn chains_of_2000_are_solved() {
    for beta in [0.0, 1.0] {
        let n = 2000;
        let chain = FputChain::new(n, beta, 0.1).unwrap();
        for stages in 1..=8 {
            let start = State::new(wave(n, 1.0), vec![0.0; n]).unwrap();
            solved(
                &format!("β = {beta}"),
                &chain,
                stages,
                3.0,
                if beta == 0.0 { 3 } else { 1 },
                start,
            );
        }
    }
    let stiff = FputChain::new(2000, 1e4, 5.0).unwrap();
    solved("stiff", &stiff, 2, 1.0, 1, State::new(wave(2000, 0.01), vec![0.0; 2000]).unwrap());
}

#[test]
fn dense_systems_are_solved() {
    for (rubs, beta, g) in [
        (Rubs::Linearly, 0.0, 0.5),
        (Rubs::Wind, 1.0, 0.5),
        (Rubs::Unevenly, 1.0, 0.0),
        (Rubs::Wind, 0.0, 0.0),
    ] {
        for stages in 1..=8 {
            let web = Web::new(50, 1e4, 0.4, g, beta, rubs);
            let start = State::new(wave(50, 1.0), wave(50, 0.3)).unwrap();
            solved(&format!("{rubs:?} {beta} {g}"), &web, stages, 1.0, 2, start);
        }
    }
    let web = Web::new(300, 1e4, 0.4, 0.5, 0.0, Rubs::Linearly);
    solved("300", &web, 2, 1.0, 1, State::new(wave(300, 1.0), wave(300, 0.3)).unwrap());
}

/// A normal mode of the chain is a damped oscillator, which is solved with another matrix.
#[test]
fn a_long_step_of_a_mode_is_that_of_an_oscillator() {
    let (n, k) = (2000, 1500.0);
    let angle = k * std::f64::consts::PI / (n + 1) as f64;
    let rate = 2.0 * (0.5 * angle).sin();
    let chain: &Curved<f64> = &FputChain::new(n, 0.0, 0.3).unwrap();
    let alone: &Curved<f64> = &DampedOscillator::new(rate * rate, 0.3).unwrap();
    let shape: Vec<f64> = (1..=n).map(|j| (angle * j as f64).sin()).collect();
    for stages in 1..=8 {
        for h in [0.7, 5.0, 60.0] {
            let method = Collocation::new(stages);
            let mut all = State::new(shape.clone(), vec![0.0; n]).unwrap();
            let mut one = State::new(vec![1.0], vec![0.0]).unwrap();
            method.step(chain, h, &mut all, &mut method.workspace(chain).unwrap()).unwrap();
            method.step(alone, h, &mut one, &mut method.workspace(alone).unwrap()).unwrap();
            for (j, shape) in shape.iter().enumerate() {
                let off =
                    (all.q[j] - shape * one.q[0]).abs().max((all.p[j] - shape * one.p[0]).abs());
                let off = off.max((all.w[j] - shape * shape * one.w[0]).abs());
                assert!(off < 1e-12, "s = {stages}, h = {h}, mass {j}: {off:e}");
            }
        }
    }
}

/// With one coefficient and quadratic H the method is the midpoint discrete gradient, whose
/// equations differ.
#[test]
fn one_stage_is_the_midpoint_rule() {
    let web: &Curved<f64> = &Web::new(50, 1e3, 0.4, 0.5, 0.0, Rubs::Linearly);
    let (one, other) = (Collocation::new(1), Gonzalez::default());
    let start = State::new(wave(50, 1.0), wave(50, 0.3)).unwrap();
    let [mut a, mut b] = [start.clone(), start];
    one.step(web, 2.0, &mut a, &mut one.workspace(web).unwrap()).unwrap();
    other.step(web, 2.0, &mut b, &mut other.workspace(web).unwrap()).unwrap();
    for (a, b) in a.q.iter().chain(&a.p).chain(&a.w).zip(b.q.iter().chain(&b.p).chain(&b.w)) {
        assert!((a - b).abs() < 1e-10 * (1.0 + a.abs()), "{a} {b}");
    }
}

/// Only the first step allocates, and only with more than 2048 unknowns.
#[test]
fn later_steps_allocate_nothing() {
    let n = 400;
    let chain: &Curved<f64> = &FputChain::new(n, 0.0, 0.1).unwrap();
    let method = Collocation::new(4);
    let mut state = State::new(wave(n, 1.0), vec![0.0; n]).unwrap();
    let mut workspace = method.workspace(chain).unwrap();
    method.step(chain, 3.0, &mut state, &mut workspace).unwrap();
    let allocated = allocation_counter::measure(|| {
        for _ in 0..5 {
            method.step(chain, 3.0, &mut state, &mut workspace).unwrap();
        }
    });
    assert_eq!(allocated.count_total, 0);
}

/// A system that declares all-to-all coupling, for a step that needs linear equations.
struct Crowd(usize);

impl System<f64> for Crowd {
    fn dof(&self) -> usize {
        self.0
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        q.iter().chain(p).map(|x| x * x / 2.0).sum()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hq.copy_from_slice(q);
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(0.0);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
}

impl Curvature<f64> for Crowd {
    fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for i in 0..self.0 {
            put(Block::Hpp, i, i, 1.0);
            for j in (i % 7..self.0).step_by(7) {
                put(Block::Hqq, i, j, f64::from(u8::from(i == j)));
            }
        }
    }
}

/// Matrices beyond the memory limit are refused with their size, and the step that the message
/// advises succeeds.
#[test]
fn what_does_not_fit_in_memory_is_named() {
    let crowd: &Curved<f64> = &Crowd(9000);
    let method = Collocation::new(8);
    let mut state = State::new(vec![1.0; 9000], vec![0.0; 9000]).unwrap();
    let before = state.clone();
    let mut workspace = method.workspace(crowd).unwrap();
    let failure = method.step(crowd, 100.0, &mut state, &mut workspace).unwrap_err();
    assert!(
        matches!(failure, StepFailure::TooLarge { unknowns: 9000, bytes } if bytes > 4e9),
        "{failure}"
    );
    assert_eq!(state, before);
    method.step(crowd, 0.1, &mut state, &mut workspace).unwrap();
}

/// The failure names its degree of freedom: the second of two, whose force is NaN.
#[test]
fn failures_name_their_degree_of_freedom() {
    struct Cliff;
    impl System<f64> for Cliff {
        fn dof(&self) -> usize {
            2
        }
        fn energy(&self, _q: &[f64], p: &[f64]) -> f64 {
            (p[0] * p[0] + p[1] * p[1]) / 2.0
        }
        fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
            hp.copy_from_slice(p);
            (hq[0], hq[1]) = (0.0, if q[1] > 1.0 { f64::NAN } else { 0.0 });
        }
        fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
            d.copy_from_slice(v);
        }
        fn dissipation_form(&self) -> DissipationForm {
            DissipationForm::LINEAR
        }
    }
    impl Curvature<f64> for Cliff {
        fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
            for j in 0..2 {
                put(Block::Hpp, j, j, 1.0);
                put(Block::Dp, j, j, 1.0);
            }
        }
    }
    for stages in 1..=8 {
        let method = Collocation::new(stages);
        let mut state = State::new(vec![0.0, 0.5], vec![0.0, 5.0]).unwrap();
        let cliff: &Curved<f64> = &Cliff;
        let mut workspace = method.workspace(cliff).unwrap();
        let failure = method.step(cliff, 1.0, &mut state, &mut workspace).unwrap_err();
        let named = matches!(
            failure,
            StepFailure::NonFinite { dof: 1, .. } | StepFailure::NewtonStalled { dof: 1, .. }
        );
        assert!(named, "s = {stages}: {failure}");
    }
}

/// For steps up to h = 2 on single and double wells nearly all steps succeed, and where one fails,
/// a step of half or a quarter of its length succeeds.
#[test]
fn hardly_a_step_fails_and_the_advice_helps() {
    let x = |i: u32, a: f64| 2.0 * (a * f64::from(i)).sin();
    let (mut failed, runs) = (0, 8 * 400);
    for stages in 1..=8 {
        for i in 0..400 {
            let system: &Curved<f64> =
                &Duffing::new(1.5 * x(i, 1.3), 0.75 + 0.375 * x(i, 2.9), 0.5).unwrap();
            let h = 1.05 + 0.475 * x(i, 0.7);
            let method = Collocation::new(stages);
            let start = State::new(vec![x(i, 3.7)], vec![x(i, 5.1)]).unwrap();
            let step = |h: f64| {
                let mut state = start.clone();
                method.step(system, h, &mut state, &mut method.workspace(system).unwrap())
            };
            if let Err(failure) = step(h) {
                failed += 1;
                assert!(
                    step(h / 4.0).is_ok() || step(h / 8.0).is_ok(),
                    "s = {stages}, h = {h}: {failure}"
                );
            }
        }
    }
    println!("{failed} of {runs} steps fail");
    assert!(failed * 200 <= runs, "{failed} of {runs} steps fail");
}
