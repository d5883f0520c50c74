//! The implicit midpoint rule: the discrete equations, order, K, passivity, failures.

use crate::bind::{Curved, after, erased};
use crate::catalog::{chain, duffing, pendulum, written};
use crate::many::exact_end;
use crate::many::orders::orders_at_end;
use crate::slope::slope;
use crate::systems::{Twisted, start};
use afterbay_core::{Grid, IntegrateError, Quad, RunError, Scalar, State, StepFailure, System};
use afterbay_methods::registry::{Number, Run, find};
use afterbay_systems::Description;
use std::sync::Arc;

const TWISTED: Twisted = Twisted { c: 0.3, offset: 0.0 };

/// The method with this name, bound to a system.
fn bound<T: Number>(name: &str, system: Arc<Curved<T>>) -> Run<T> {
    erased(find(name).unwrap(), system).unwrap()
}

fn midpoint(system: Arc<Curved<f64>>) -> Run<f64> {
    bound("implicit-midpoint", system)
}

/// The state at t = 1 after `steps` steps.
fn carry(run: &Run<f64>, steps: u64) -> State<Vec<f64>> {
    after(run, Grid { h: 1.0 / steps as f64, steps }, &begin())
}

fn begin<T: Scalar>() -> State<Vec<T>> {
    let (q, p) = start(2);
    State::new(q, p).unwrap()
}

#[test]
fn the_equations_as_they_are_written_are_solved() {
    let h = 0.05;
    let (q, p) = start::<f64>(2);
    let mut state = State::new([q[0], q[1]], [p[0], p[1]]).unwrap();
    let run = midpoint(Arc::new(TWISTED));
    for _ in 0..50 {
        // Fixed-point iteration of the discrete equations.
        let State { q: q0, p: p0, w: w0, .. } = state;
        let (mut q1, mut p1, mut w1) = (q0, p0, w0);
        for _ in 0..60 {
            let mean = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|j| (a[j] + b[j]) / 2.0);
            let (q, p) = (mean(q0, q1), mean(p0, p1));
            let [mut hq, mut v, mut d] = [[0.0; 2]; 3];
            TWISTED.gradient(&q, &p, &mut hq, &mut v);
            TWISTED.dissipation(&q, &p, &v, &mut d);
            q1 = [0, 1].map(|j| q0[j] + h * v[j]);
            p1 = [0, 1].map(|j| p0[j] - h * (hq[j] + d[j]));
            w1 = [0, 1].map(|j| w0[j] + h * d[j] * v[j]);
        }
        run.step(h, &mut state).unwrap();
        let found = [state.q, state.p, state.w].into_iter().flatten();
        for (found, expected) in found.zip([q1, p1, w1].into_iter().flatten()) {
            assert!((found - expected).abs() < 3e-15, "{found} {expected}");
        }
    }
}

/// The slopes of the errors of q, p, w and K at t = 1.
fn orders<T: Number>(counts: &[u64]) -> [f64; 4] {
    let (run, begin) = (bound::<T>("implicit-midpoint", Arc::new(TWISTED)), begin());
    let (k, mut drifts) = (begin.total(&TWISTED), Vec::new());
    let [q, p, w] = orders_at_end(&exact_end(&TWISTED, &begin, 1.0), counts, &mut |grid| {
        let end = after(&run, grid, &begin);
        drifts.push((end.total(&TWISTED) - k).to_f64().abs());
        end
    });
    let steps: Vec<f64> = counts.iter().map(|&count| 1.0 / count as f64).collect();
    [q, p, w, slope(&steps, &drifts)]
}

#[test]
fn order_2_in_q_p_w_and_k() {
    for found in [orders::<f64>(&[50, 70, 100, 140, 200]), orders::<Quad>(&[200, 400, 800])] {
        println!("{found:.3?}");
        assert!(found.iter().all(|slope| (slope - 2.0).abs() < 0.1), "{found:?}");
    }
}

#[test]
fn it_is_neither_gonzalez_nor_collocation_unless_h_is_quadratic() {
    /// The distances in p to the ends of the two.
    fn apart(system: Arc<Curved<f64>>) -> [f64; 2] {
        let found = carry(&midpoint(system.clone()), 10);
        ["gonzalez", "collocation-2"].map(|name| {
            let other = carry(&bound(name, system.clone()), 10);
            found.p.iter().zip(&other.p).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        })
    }
    let pendulum = pendulum([1.0; 2], [1.0; 2], 9.81, [0.2; 2]).curved();
    assert!(apart(Arc::new(TWISTED)).iter().all(|&far| far > 1e-5));
    assert!(apart(pendulum).iter().all(|&far| far > 1e-5));
    let springs = chain(2, 0.0, 0.2).curved();
    assert!(apart(springs).iter().all(|&far| far < 1e-13));
}

#[test]
fn k_is_kept_where_h_is_quadratic() {
    let springs = chain(2, 0.0, 0.2).curved();
    for steps in [1, 10, 100] {
        let end = carry(&midpoint(springs.clone()), steps);
        let drift = end.total(&*springs) - begin::<f64>().total(&*springs);
        assert!(drift.abs() < 1e-14, "{steps}: {drift:e}");
        assert!(end.w.iter().all(|&w| w > 0.0), "{end:?}");
    }
}

#[test]
fn the_sum_of_the_reservoirs_only_rises_where_friction_couples_velocities() {
    let run = midpoint(Arc::new(TWISTED));
    let (mut least, mut least_of_one) = (0.0_f64, 0.0_f64);
    for i in 0..10_000 {
        let angle = 0.7 * f64::from(i);
        let mut state = State::new([angle.sin(), 0.3], [(1.3 * angle).cos(), -0.2]).unwrap();
        run.step(0.5, &mut state).unwrap();
        least = least.min(state.w.iter().sum());
        least_of_one = state.w.iter().fold(least_of_one, |least, &w| least.min(w));
    }
    assert!(least >= 0.0 && least_of_one < 0.0, "{least:e} {least_of_one:e}");
}

#[test]
fn failures_have_names_and_leave_the_state_alone() {
    let fails = |run: Run<f64>, h: f64, q: f64| {
        let mut state = State::new([q], [1.0]).unwrap();
        let error = run.step(h, &mut state).unwrap_err();
        assert_eq!((state.q, state.p, state.w), ([q], [1.0], [0.0]));
        let IntegrateError::Run(RunError { failure, .. }) = error else { panic!("{error}") };
        failure
    };
    // The equation is quadratic, and has no real root at this step.
    let falling = Description { potential: "-q1^3/3".into(), ..Description::default() };
    let stalled = fails(midpoint(written(&falling).curved()), 2.0, 2.0);
    assert!(matches!(stalled, StepFailure::NewtonStalled { dof: 0, .. }), "{stalled}");
    // 1 - h²/4 = 0
    let singular = fails(midpoint(duffing(-1.0, 0.0, 0.0).curved()), 2.0, 2.0);
    assert!(matches!(singular, StepFailure::Singular { dof: 0, .. }), "{singular}");
    let overflow = fails(midpoint(duffing(0.0, 1.0, 0.1).curved()), 0.1, 1e200);
    assert!(matches!(overflow, StepFailure::NonFinite { .. }), "{overflow}");
}
