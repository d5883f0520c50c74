//! Gonzalez's discrete gradient: orders, linear solvers, storage, the discrete equations, failures.

use crate::bind::{Curved, after, curved, erased};
use crate::many::orders::orders_at_end;
use crate::many::{InSeries, exact_end};
use crate::systems::{Springs, Twisted, start};
use afterbay_core::{
    Block, Coupling, Curvature, DissipationForm, Grid, InputError, IntegrateError, Method, Quad,
    RunError, State, StepFailure, System, Vector, integrate,
};
use afterbay_methods::registry::{Number, Run, find};
use afterbay_methods::{Gonzalez, LinearSolver};
use nalgebra::{DVector, SVector};
use std::sync::Arc;

const METHOD: Gonzalez = Gonzalez { solver: None };

/// Checks that the slopes of the global errors of q, p and w at t = 1 are 2, and K.
pub(crate) fn check_order<T: Number>(
    system: &Arc<Curved<T>>,
    series: &InSeries<T>,
    counts: &[u64],
) {
    let (q, p) = start(system.dof());
    let begin = State::new(q, p).unwrap();
    let k = begin.total(&**system);
    let run = erased(find("gonzalez").unwrap(), system.clone()).unwrap();
    let found = orders_at_end(&exact_end(series, &begin, 1.0), counts, &mut |grid| {
        let end = after(&run, grid, &begin);
        let drift = (end.total(&**system) - k).to_f64().abs();
        let roundings = 20.0 * (grid.steps as f64).sqrt();
        assert!(drift < roundings * T::EPSILON * k.to_f64().abs(), "{drift:e}");
        end
    });
    println!("{found:.3?}");
    assert!(found.iter().all(|slope| (slope - 2.0).abs() < 0.1), "{found:?}");
}

#[test]
fn order_2_in_q_p_and_w() {
    fn check<T: Number>(counts: &[u64]) {
        let twisted = Arc::new(Twisted { c: 0.3, offset: 0.0 });
        check_order::<T>(&(twisted.clone() as Arc<Curved<T>>), &*twisted, counts);
        for springs in [Springs::chain(5, 0.2), Springs::ring(4, 0.2)].map(Arc::new) {
            check_order::<T>(&(springs.clone() as Arc<Curved<T>>), &*springs, counts);
        }
    }
    check::<f64>(&[50, 70, 100, 140, 200]);
    check::<Quad>(&[200, 400, 800]);
}

/// The method in the form of the registry.
fn bound<S: Curvature<f64> + 'static>(system: S) -> Run<f64> {
    curved(find("gonzalez").unwrap(), system).unwrap()
}

/// The state after `steps` steps of h = 0.1.
fn carry<S, V>(method: Gonzalez, system: &S, steps: u64, q: V, p: V) -> State<V>
where
    S: Curvature<f64> + ?Sized,
    V: Vector<Scalar = f64>,
{
    let mut state = State::new(q, p).unwrap();
    integrate(&method, system, Grid::of(0.1, steps).unwrap(), &mut state, &mut ()).unwrap();
    state
}

/// q, p and w in one vector.
fn numbers<V: Vector<Scalar = f64>>(state: &State<V>) -> Vec<f64> {
    [&state.q, &state.p, &state.w].iter().flat_map(|part| part.as_slice().to_vec()).collect()
}

#[test]
fn every_linear_solver_leads_to_the_same_state() {
    let refused =
        |error: &InputError| matches!(error, InputError::Unsupported { method: "gonzalez", .. });
    let check = |system: &Curved<f64>, (q, p): (Vec<f64>, Vec<f64>), fits: &[LinearSolver]| {
        let end = |method: Gonzalez| {
            Method::<Vec<f64>, _>::workspace(&method, system)?;
            Ok(numbers(&carry(method, system, 10, q.clone(), p.clone())))
        };
        let chosen: Vec<f64> = end(METHOD).unwrap();
        for solver in LinearSolver::ALL {
            match end(Gonzalez { solver: Some(solver) }) {
                Ok(found) => {
                    for (a, b) in chosen.iter().zip(&found) {
                        assert!((a - b).abs() < 2e-14 * (1.0 + a.abs()), "{solver:?}: {a} {b}");
                    }
                }
                Err(error) => {
                    assert!(!fits.contains(&solver) && refused(&error), "{error}");
                }
            }
        }
    };
    let general = [LinearSolver::Small, LinearSolver::Sparse, LinearSolver::Dense];
    let of_rings = [&general[..], &[LinearSolver::Ring]].concat();
    for n in [3, 50] {
        check(&Springs::chain(n, 0.2), start(n), &LinearSolver::ALL);
    }
    for n in [4, 5, 7, 50] {
        check(&Springs::ring(n, 0.2), start(n), &of_rings);
    }
    check(&Springs::dense(60, 0.2), start(60), &general);
    check(&Twisted { c: 0.3, offset: 0.0 }, (vec![0.4, -0.7], vec![1.1, 0.2]), &general);
}

/// Nor does the erasure of the type of the system.
#[test]
fn storage_changes_no_bit() {
    let twisted = Twisted { c: 0.3, offset: 0.0 };
    let erased: &Curved<f64> = &twisted;
    let (q, p) = ([0.4, -0.7], [1.1, 0.2]);
    let array = numbers(&carry(METHOD, &twisted, 100, q, p));
    assert_eq!(array, numbers(&carry(METHOD, erased, 100, q.to_vec(), p.to_vec())));
    assert_eq!(array, numbers(&carry(METHOD, erased, 100, SVector::from(q), SVector::from(p))));
    let (dq, dp) = (DVector::from_row_slice(&q), DVector::from_row_slice(&p));
    assert_eq!(array, numbers(&carry(METHOD, erased, 100, dq, dp)));
}

#[test]
fn without_dissipation_h_is_kept_and_nothing_is_held() {
    for system in [Springs::chain(12, 0.0), Springs::ring(12, 0.0), Springs::dense(12, 0.0)] {
        let (q, p) = start::<f64>(12);
        let before = system.energy(&q, &p);
        let state = carry::<Curved<f64>, _>(METHOD, &system, 1000, q, p);
        assert_eq!(state.w, vec![0.0; 12]);
        assert!((state.energy(&system) / before - 1.0).abs() < 2e-14);
    }
}

#[test]
fn the_equations_as_they_are_written_are_solved() {
    let (c, h) = (0.3, 0.05);
    let system = Springs {
        masses: vec![2.0, 2.0],
        springs: vec![(0, 1, 0.0)],
        c,
        coupling: Coupling::Chain,
    };
    let energy = |q: &[f64; 2], p: &[f64; 2]| System::<f64>::energy(&system, q, p);
    let mut state = State::new([0.9, -0.4], [0.3, 1.2]).unwrap();
    let run = bound(system.clone());
    for _ in 0..50 {
        // Fixed-point iteration of the discrete equations.
        let (q0, p0, w0) = (state.q, state.p, state.w);
        let (mut q1, mut p1, mut w1) = (q0, p0, w0);
        for _ in 0..60 {
            let mean = |a: &[f64; 2], b: &[f64; 2]| [0, 1].map(|j| (a[j] + b[j]) / 2.0);
            let (q, p) = (mean(&q0, &q1), mean(&p0, &p1));
            let ([mut hq, mut hp], mut d) = ([[0.0; 2]; 2], [0.0; 2]);
            system.gradient(&q, &p, &mut hq, &mut hp);
            let (dq, dp) = ([0, 1].map(|j| q1[j] - q0[j]), [0, 1].map(|j| p1[j] - p0[j]));
            let square: f64 = dq.iter().chain(&dp).map(|x| x * x).sum();
            let along: f64 = [0, 1].map(|j| hq[j] * dq[j] + hp[j] * dp[j]).iter().sum();
            let rest = energy(&q1, &p1) - energy(&q0, &p0) - along;
            let lambda = if square == 0.0 { 0.0 } else { rest / square };
            let v = [0, 1].map(|j| hp[j] + lambda * dp[j]);
            system.dissipation(&q, &p, &v, &mut d);
            for j in 0..2 {
                q1[j] = q0[j] + h * (hp[j] + lambda * dp[j]);
                p1[j] = p0[j] - h * (hq[j] + lambda * dq[j] + d[j]);
                w1[j] = w0[j] + h * d[j] * (hp[j] + lambda * dp[j]);
            }
        }
        run.step(h, &mut state).unwrap();
        let pairs =
            state.q.iter().zip(&q1).chain(state.p.iter().zip(&p1)).chain(state.w.iter().zip(&w1));
        for (found, expected) in pairs {
            assert!((found - expected).abs() < 3e-15, "{found} {expected}");
        }
    }
}

#[test]
fn each_reservoir_only_fills() {
    let system = Springs::chain(2, 0.5);
    let run = bound(system);
    let mut least = 0.0_f64;
    for i in 0..40_000 {
        let angle = f64::from(i) * 0.7;
        let mut state = State::new([angle.sin(), 0.3], [(1.3 * angle).cos(), -0.2]).unwrap();
        run.step(0.5, &mut state).unwrap();
        least = least.min(state.w[0]).min(state.w[1]);
    }
    assert!(least >= 0.0, "{least:e}");
}

#[test]
fn a_decay_to_rest_is_followed_to_the_end() {
    let carry = |system: Twisted, steps: u64, q: [f64; 2], p: [f64; 2]| {
        carry::<Curved<f64>, _>(METHOD, &system, steps, q.to_vec(), p.to_vec())
    };
    for offset in [0.0, 1.0, -30.0] {
        let system = Twisted { c: 0.8, offset };
        let state = carry(system, 5000, [0.4, -0.3], [0.2, 0.1]);
        assert!(numbers(&state)[..4].iter().all(|x| x.abs() < 1e-12), "{state:?}");
        let start = System::<f64>::energy(&system, &[0.4, -0.3], &[0.2, 0.1]);
        let drift = (state.total(&system) - start).abs();
        assert!(drift < 4e-13 * (1.0 + offset.abs()), "{offset} {drift:e}");
        // The same from every distance: the rounding of H has no effect.
        for exponent in 1..140 {
            let size = 10_f64.powi(-exponent);
            let state = carry(system, 3, [size, -size], [0.0, size / 3.0]);
            let centred = Twisted { c: 0.8, offset: 0.0 };
            let midpoint = carry(centred, 3, [size, -size], [0.0, size / 3.0]);
            for (a, b) in numbers(&state)[..4].iter().zip(&numbers(&midpoint)[..4]) {
                let noise = 1e-14 * size + 20.0 * 1e-16 * offset.abs() / size;
                assert!((a - b).abs() < noise.min(1e-3 * size), "{offset} {size:e}: {a:e} {b:e}");
            }
        }
    }
}

/// V = -a q³/3 - b q²/2, which is unbounded below.
struct Endless(f64, f64);

impl System<f64> for Endless {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 - self.0 * q[0].powi(3) / 3.0 - self.1 * q[0] * q[0] / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (-self.0 * q[0] * q[0] - self.1 * q[0], p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.0;
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl Curvature<f64> for Endless {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hqq, 0, 0, -2.0 * self.0 * q[0] - self.1);
        put(Block::Hpp, 0, 0, 1.0);
    }
}

#[test]
fn failures_have_names_and_leave_the_state_alone() {
    let fails = |(a, b): (f64, f64), h: f64, q: f64| {
        let mut state = State::new([q], [1.0]).unwrap();
        let error = bound(Endless(a, b)).step(h, &mut state).unwrap_err();
        assert_eq!((state.q, state.p, state.w), ([q], [1.0], [0.0]));
        let IntegrateError::Run(RunError { failure, .. }) = error else { panic!("{error}") };
        failure
    };
    let stalled = fails((1.0, 0.0), 2.0, 2.0);
    assert!(
        matches!(stalled, StepFailure::NewtonStalled { dof: 0, iterations, .. } if iterations > 10),
        "{stalled}"
    );
    // 1 - h²/4 = 0
    let singular = fails((0.0, 1.0), 2.0, 2.0);
    assert!(matches!(singular, StepFailure::Singular { dof: 0, .. }), "{singular}");
    assert!(matches!(fails((f64::NAN, 0.0), 0.1, 1.0), StepFailure::NonFinite { dof: 0, .. }));
    assert!(matches!(fails((f64::MAX, 0.0), 0.1, 1e3), StepFailure::NonFinite { dof: 0, .. }));
}

#[test]
fn what_was_before_is_no_part_of_a_step() {
    let system: &Curved<f64> = &Springs::chain(30, 0.2);
    let (q, p) = start::<f64>(30);
    let mut state = State::new(q, p).unwrap();
    let mut used = METHOD.workspace(system).unwrap();
    // The same after a longer step, and after one that failed.
    for h in [0.02, 0.02, 5.0, 0.02, f64::NAN, 0.3, 0.02] {
        let mut alone = state.clone();
        let fresh = METHOD.step(system, h, &mut alone, &mut METHOD.workspace(system).unwrap());
        assert_eq!(METHOD.step(system, h, &mut state, &mut used).is_ok(), fresh.is_ok());
        assert_eq!(alone, state, "{h}");
    }
}
