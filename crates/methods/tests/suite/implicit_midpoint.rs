//! The implicit midpoint rule: the discrete equations, order, K, passivity, failures.

use crate::slope::slope;
use crate::systems::{Twisted, start};
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Curvature, Grid, Method, Quad, Scalar, Series, State, StepFailure, System, integrate,
};
use afterbay_methods::{Collocation, Gonzalez, ImplicitMidpoint};
use afterbay_systems::{Custom, DampedDoublePendulum, Description, Duffing, FputChain};

const TWISTED: Twisted = Twisted { c: 0.3, offset: 0.0 };

/// The state at t = 1 after `steps` steps.
fn carry<T, S, M>(method: &M, system: &S, steps: u64, begin: &State<[T; 2]>) -> State<[T; 2]>
where
    T: Scalar,
    S: Curvature<T>,
    M: Method<[T; 2], S>,
{
    let mut state = begin.clone();
    let grid = Grid { h: T::one() / T::from_f64(steps as f64), steps };
    integrate(method, system, grid, &mut state, &mut ()).unwrap();
    state
}

fn far<T: Scalar>(a: [T; 2], b: [T; 2]) -> f64 {
    a.iter().zip(b).map(|(&a, b)| (a - b).to_f64().abs()).fold(0.0, f64::max)
}

fn begin<T: Scalar>() -> State<[T; 2]> {
    let (q, p) = start(2);
    State::new(q.try_into().unwrap(), p.try_into().unwrap()).unwrap()
}

#[test]
fn the_equations_as_they_are_written_are_solved() {
    let h = 0.05;
    let mut state = begin::<f64>();
    let mut workspace = ImplicitMidpoint.workspace(&TWISTED).unwrap();
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
        ImplicitMidpoint.step(&TWISTED, h, &mut state, &mut workspace).unwrap();
        let found = [state.q, state.p, state.w].into_iter().flatten();
        for (found, expected) in found.zip([q1, p1, w1].into_iter().flatten()) {
            assert!((found - expected).abs() < 3e-15, "{found} {expected}");
        }
    }
}

/// The slopes of the errors of q, p, w and K at t = 1.
fn orders<T: Scalar>(counts: &[u64]) -> [f64; 4]
where
    Twisted: Curvature<T> + System<Series<T, 24>>,
{
    let exact = trajectory::<_, _, 24>(&TWISTED, &begin(), T::one(), 1).unwrap()[1].clone();
    let mut errors = [(); 4].map(|()| Vec::new());
    for &count in counts {
        let end = carry(&ImplicitMidpoint, &TWISTED, count, &begin::<T>());
        let drift = (end.total(&TWISTED) - begin::<T>().total(&TWISTED)).to_f64().abs();
        let found = [far(end.q, exact.q), far(end.p, exact.p), far(end.w, exact.w), drift];
        errors.iter_mut().zip(found).for_each(|(errors, error)| errors.push(error));
    }
    let steps: Vec<f64> = counts.iter().map(|&count| 1.0 / count as f64).collect();
    errors.map(|errors| slope(&steps, &errors))
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
    fn apart<S: Curvature<f64>>(system: &S) -> [f64; 2] {
        let found = carry(&ImplicitMidpoint, system, 10, &begin());
        let others = [
            carry(&Gonzalez::default(), system, 10, &begin()),
            carry(&Collocation::new(1), system, 10, &begin()),
        ];
        others.map(|other| far(found.p, other.p))
    }
    let pendulum = DampedDoublePendulum::new([1.0; 2], [1.0; 2], 9.81, [0.2; 2]).unwrap();
    assert!(apart(&TWISTED).iter().all(|&far| far > 1e-5));
    assert!(apart(&pendulum).iter().all(|&far| far > 1e-5));
    let springs = FputChain::new(2, 0.0, 0.2).unwrap();
    assert!(apart(&springs).iter().all(|&far| far < 1e-13));
}

#[test]
fn k_is_kept_where_h_is_quadratic() {
    let springs = FputChain::new(2, 0.0, 0.2).unwrap();
    for steps in [1, 10, 100] {
        let end = carry(&ImplicitMidpoint, &springs, steps, &begin::<f64>());
        let drift = end.total(&springs) - begin::<f64>().total(&springs);
        assert!(drift.abs() < 1e-14, "{steps}: {drift:e}");
        assert!(end.w.iter().all(|&w| w > 0.0), "{end:?}");
    }
}

#[test]
fn the_sum_of_the_reservoirs_only_rises_where_friction_couples_velocities() {
    let mut workspace = ImplicitMidpoint.workspace(&TWISTED).unwrap();
    let (mut least, mut least_of_one) = (0.0_f64, 0.0_f64);
    for i in 0..10_000 {
        let angle = 0.7 * f64::from(i);
        let mut state = State::new([angle.sin(), 0.3], [(1.3 * angle).cos(), -0.2]).unwrap();
        ImplicitMidpoint.step(&TWISTED, 0.5, &mut state, &mut workspace).unwrap();
        least = least.min(state.w.iter().sum());
        least_of_one = state.w.iter().fold(least_of_one, |least, &w| least.min(w));
    }
    assert!(least >= 0.0 && least_of_one < 0.0, "{least:e} {least_of_one:e}");
}

#[test]
fn failures_have_names_and_leave_the_state_alone() {
    fn fails<S: Curvature<f64>>(system: &S, h: f64, q: f64) -> StepFailure {
        let mut state = State::new([q], [1.0]).unwrap();
        let mut workspace = ImplicitMidpoint.workspace(system).unwrap();
        let failure = ImplicitMidpoint.step(system, h, &mut state, &mut workspace).unwrap_err();
        assert_eq!((state.q, state.p, state.w), ([q], [1.0], [0.0]));
        failure
    }
    // The equation is quadratic, and has no real root at this step.
    let falling = Description { potential: "-q1^3/3".into(), ..Description::default() };
    let stalled = fails(&Custom::new(&falling).unwrap(), 2.0, 2.0);
    assert!(matches!(stalled, StepFailure::NewtonStalled { dof: 0, .. }), "{stalled}");
    // 1 - h²/4 = 0
    let singular = fails(&Duffing::new(-1.0, 0.0, 0.0).unwrap(), 2.0, 2.0);
    assert!(matches!(singular, StepFailure::Singular { dof: 0, .. }), "{singular}");
    let overflow = fails(&Duffing::new(0.0, 1.0, 0.1).unwrap(), 0.1, 1e200);
    assert!(matches!(overflow, StepFailure::NonFinite { .. }), "{overflow}");
}
