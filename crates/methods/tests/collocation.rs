//! Energy-preserving collocation: orders 2 to 16 in q, p and w, symmetry, K, passivity, stiff scenes.

#![cfg(test)]

mod slope;

use afterbay_core::{
    Block, Curvature, Damping, Grid, Method, Passive, Quad, Scalar, State, StepFailure, System, Vector,
    integrate,
};
use afterbay_methods::Collocation;
use afterbay_systems::{
    DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, VanDerPol, VanDerPolRing,
};
use proptest::prelude::*;
use slope::slope;

/// The state the time `end` after (q, p).
fn after<T: Scalar, S: Curvature<T>>(
    system: &S,
    stages: usize,
    [q, p]: [&[f64]; 2],
    end: f64,
    steps: u64,
) -> State<Vec<T>> {
    let lift = |x: &[f64]| Vec::filled(x, T::from_f64);
    let mut state = State::new(lift(q), lift(p)).unwrap();
    let grid = Grid { h: T::from_f64(end) / T::from_f64(steps as f64), steps };
    integrate(&Collocation::new(stages), system, grid, &mut state, &mut ()).unwrap();
    state
}

/// The largest error of q, p and w.
fn errors<T: Scalar>(state: &State<Vec<T>>, exact: &State<Vec<T>>) -> [f64; 3] {
    let parts = [(&state.q, &exact.q), (&state.p, &exact.p), (&state.w, &exact.w)];
    parts.map(|(found, exact)| {
        found.iter().zip(exact).fold(0.0, |most: f64, (&a, &b)| most.max((a - b).abs().to_f64()))
    })
}

/// The global orders are 2s to within 0.1, by the steps `counts` of each number of stages.
fn orders<T: Scalar, S: Curvature<T>>(
    name: &str,
    system: &S,
    start: [&[f64]; 2],
    end: f64,
    plan: &[(usize, [u64; 3])],
    finer: f64,
) {
    let plan = plan.iter().map(|&(stages, counts)| (stages, counts.map(|n| (n as f64 * finer) as u64)));
    let plan: Vec<_> = plan.collect();
    let exact = after(system, 8, start, end, 4 * plan.iter().map(|plan| plan.1[2]).min().unwrap());
    for (stages, counts) in plan {
        let all = counts.map(|steps| errors(&after(system, stages, start, end, steps), &exact));
        let steps = counts.map(|count| end / count as f64);
        for (part, variable) in ["q", "p", "w"].into_iter().enumerate() {
            let found = slope(&steps, &all.map(|error| error[part]));
            let wanted = 2.0 * stages as f64;
            println!("{name} s={stages} {variable} {found:.3} {:?}", all.map(|e| e[part]));
            assert!((found - wanted).abs() < 0.1, "{name} {stages} {variable}: {found} {all:?}");
        }
    }
}

/// Steps for an end of about 1, short enough for the order to show and long enough for 31 digits to hold the error.
const PLAN: [(usize, [u64; 3]); 8] = [
    (1, [60, 80, 110]),
    (2, [30, 40, 55]),
    (3, [20, 28, 40]),
    (4, [16, 22, 30]),
    (5, [14, 18, 24]),
    (6, [12, 16, 20]),
    (7, [10, 13, 16]),
    (8, [10, 13, 16]),
];

#[test]
fn orders_of_a_chain() {
    let chain = FputChain::new(3, 0.5, 0.2).unwrap().map(Quad::from_f64);
    orders("chain", &chain, [&[0.5, -0.3, 0.8], &[0.2, 0.7, -0.4]], 1.0, &PLAN, 1.0);
}

#[test]
fn orders_of_a_ring() {
    let ring = VanDerPolRing::new(3, 0.7, 0.4).unwrap().map(Quad::from_f64);
    orders("ring", &ring, [&[0.5, -0.3, 0.8], &[0.2, 0.7, -0.4]], 2.0, &PLAN, 1.0);
}

#[test]
fn orders_of_a_double_pendulum() {
    let pendulum = DampedDoublePendulum::new([1.0, 0.8], [1.0, 0.7], 3.0, [0.1, 0.2]).unwrap();
    orders("pendulum", &pendulum.map(Quad::from_f64), [&[0.6, -0.4], &[0.3, 0.5]], 0.8, &PLAN, 2.0);
}

#[test]
fn orders_of_duffing() {
    let duffing = Duffing::new(-1.0, 1.0, 0.1).unwrap();
    orders("duffing", &duffing.map(Quad::from_f64), [&[1.5], &[0.5]], 1.0, &PLAN, 1.0);
    orders("duffing", &duffing, [&[1.5], &[0.5]], 1.0, &PLAN[..3], 1.0);
}
