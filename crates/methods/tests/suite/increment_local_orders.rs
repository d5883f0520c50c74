//! The orders of the local errors of coordinate increments in q, p and w, which differ for several
//! coordinates.

use crate::bind::separable;
use crate::catalog::{As, chain, ring};
use crate::many::InSeries;
use crate::slope::slope;
use afterbay_core::taylor::Expansion;
use afterbay_core::{Block, Curvature, Dissipation, Quad, Scalar, Separable, State, System};
use afterbay_methods::registry::{FIXED, Order, Row, Run};

const N: usize = 3;
/// Small enough for the leading error term to dominate, and for order 8 large enough for it to
/// exceed the rounding of 31 digits over h.
const STEPS: [f64; 5] = [0.0005, 0.0008, 0.0012, 0.002, 0.003];
const STEPS_ORDER_8: [f64; 5] = [0.006, 0.008, 0.01, 0.012, 0.016];

fn start<T: Scalar>() -> State<[T; N]> {
    State::new([0.8, -0.3, 0.5].map(T::from_f64), [0.9, 0.7, -0.6].map(T::from_f64)).unwrap()
}

/// H = Σ (p_j²/2 + q_j²/2) + q1 q2² + q2 q3², with friction that depends on the neighbours: D_j = c
/// (1 + (q1 + q2 + q3)²) p_j.
struct Crowd;

fn sum<T: Scalar>(q: &[T]) -> T {
    q[0] + q[1] + q[2]
}

fn gamma<T: Scalar>(q: &[T]) -> T {
    T::from_f64(0.3) * (T::one() + sum(q) * sum(q))
}

impl<T: Scalar> System<T> for Crowd {
    fn dof(&self) -> usize {
        N
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let squares = p.iter().chain(q).fold(T::zero(), |sum, &x| sum + x * x);
        squares.half() + q[0] * q[1] * q[1] + q[1] * q[2] * q[2]
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (0..N).for_each(|j| hq[j] = self.partial(q, j, q[j]));
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        (0..N).for_each(|j| d[j] = gamma(q) * v[j]);
    }
}

impl<T: Scalar> Separable<T> for Crowd {
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        match j {
            0 => at + q[1] * q[1],
            1 => at + (q[0] * at + q[0] * at) + q[2] * q[2],
            _ => at + (q[1] * at + q[1] * at),
        }
    }
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let by_q = T::from_f64(0.6) * sum(q) * p[j];
        Dissipation { value: gamma(q) * p[j], by_q, by_p: gamma(q) }
    }
}

impl<T: Scalar> Curvature<T> for Crowd {
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let twice = |x: T| x + x;
        let mixed = [T::one(), T::one() + twice(q[0]), T::one() + twice(q[1])];
        for i in 0..N {
            put(Block::Hqq, i, i, mixed[i]);
            put(Block::Hpp, i, i, T::one());
            put(Block::Dp, i, i, gamma(q));
            for j in 0..N {
                put(Block::Dq, i, j, T::from_f64(0.6) * sum(q) * p[i]);
            }
        }
        for (i, j, x) in [(0, 1, twice(q[1])), (1, 2, twice(q[2]))] {
            put(Block::Hqq, i, j, x);
            put(Block::Hqq, j, i, x);
        }
    }
}

fn increments() -> impl Iterator<Item = &'static Row> {
    FIXED.iter().filter(|row| row.name.starts_with("increment"))
}

/// The slopes of the largest local errors (x(t + h) - x1)/h of q, p and w.
fn slopes(row: &Row, run: &Run<Quad>, lifted: &InSeries<Quad>) -> [f64; 3] {
    let exact = Expansion::<[Quad; N], 24>::about(lifted, &start());
    let steps = if row.order() < Order::Of(8) { STEPS } else { STEPS_ORDER_8 };
    let errors = steps.map(|h| {
        let (mut state, end) = (start(), exact.at(Quad::from_f64(h)));
        run.step(Quad::from_f64(h), &mut state).unwrap();
        [(state.q, end.q), (state.p, end.p), (state.w, end.w)]
            .map(|(a, b)| a.iter().zip(&b).map(|(&a, &b)| (a - b).0.abs()).fold(0.0, f64::max) / h)
    });
    [0, 1, 2].map(|variable| slope(&steps, &errors.map(|error| error[variable])))
}

/// The local orders of q, p and w in the registry.
fn claimed(row: &Row) -> [u32; 3] {
    row.local_order.map(|order| order.number().expect("not exact"))
}

fn assert_orders(row: &Row, found: [f64; 3], orders: [u32; 3]) {
    println!("{:12} {found:.3?}", row.name);
    for (found, order) in found.into_iter().zip(orders) {
        assert!((found - f64::from(order)).abs() < 0.1, "{}: {found:.3}, not {order}", row.name);
    }
}

#[test]
fn increments_have_the_local_orders_of_their_row() {
    for row in increments() {
        assert_orders(row, slopes(row, &separable(row, Crowd).unwrap(), &Crowd), claimed(row));
    }
}

/// If D_j depends on q_j and p_j alone, w of the single sweep has one order more.
#[test]
fn local_friction_is_kinder_to_the_reservoir() {
    for row in increments() {
        let orders = if row.order() == Order::Of(1) { [2, 1, 2] } else { claimed(row) };
        for system in [chain(N, 1.0, 0.3), ring(N, 0.8, 0.6)] {
            let run = system.bind(row, As::Separable).unwrap();
            assert_orders(row, slopes(row, &run, &*system.series()), orders);
        }
    }
}
