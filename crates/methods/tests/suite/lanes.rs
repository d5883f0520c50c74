//! Eight systems side by side: each lane computes what its system computes alone, to the bit.

use afterbay_core::{Grid, Scalar, State, f64x8};
use afterbay_methods::registry::{METHODS, bind};
use afterbay_systems::catalog::Number;
use afterbay_systems::{
    DAMPED_OSCILLATOR, DUFFING, FPUT_CHAIN, SystemRow, VAN_DER_POL, VAN_DER_POL_RING,
};
use std::ops::ControlFlow;

const STEPS: u64 = 200;

/// q and p at the start, of degree of freedom j in lane k.
fn start(k: usize, j: usize) -> [f64; 2] {
    let phase = 0.7 * j as f64 + 0.3 * k as f64;
    [phase.sin() * (1.0 + k as f64 / 16.0), (1.3 * phase).cos()]
}

/// Compares every method that has lanes on a system of the catalogue, whose parameters are given in
/// every lane. Returns the names of the methods.
fn compare(
    system: &'static SystemRow,
    n: usize,
    parameters: &[[f64; 8]],
    h: f64,
) -> Vec<&'static str> {
    let side_by_side: Vec<f64x8> = parameters.iter().map(|&x| f64x8::new(x)).collect();
    let lanes = f64x8::system(system, n, &side_by_side).unwrap();
    let alone = |k: usize| {
        let parameters: Vec<f64> = parameters.iter().map(|x| x[k]).collect();
        f64::system(system, n, &parameters).unwrap()
    };
    let mut compared = Vec::new();
    for row in METHODS {
        let Ok(run) = bind(row, lanes.clone()) else { continue };
        compared.push(row.name);
        let [q, p] = [0, 1].map(|part| {
            let lane = |j| f64x8::new(std::array::from_fn(|k| start(k, j)[part]));
            (0..n).map(lane).collect::<Vec<_>>()
        });
        let mut together = State::new(q, p).unwrap();
        let grid = Grid { h: f64x8::from_f64(h), steps: STEPS };
        run.run(grid, &mut together, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
        for k in 0..8 {
            let [q, p] = [0, 1].map(|part| (0..n).map(|j| start(k, j)[part]).collect::<Vec<_>>());
            let mut state = State::new(q, p).unwrap();
            let run = bind(row, alone(k)).unwrap();
            let grid = Grid::of(h, STEPS).unwrap();
            run.run(grid, &mut state, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
            for (part, lanes, alone) in [
                ("q", &together.q, &state.q),
                ("p", &together.p, &state.p),
                ("w", &together.w, &state.w),
            ] {
                for (j, (lanes, alone)) in lanes.iter().zip(alone).enumerate() {
                    let same = lanes.lane(k).to_bits() == alone.to_bits();
                    assert!(same, "{} {part}{j} in lane {k}: {lanes:?} {alone:?}", row.name);
                }
            }
        }
    }
    compared
}

fn spread(from: f64, to: f64) -> [f64; 8] {
    std::array::from_fn(|k| from + (to - from) * k as f64 / 7.0)
}

#[test]
fn one_degree_of_freedom_is_the_same_in_a_lane_and_alone() {
    let (c, mu) = (spread(0.0, 0.7), spread(0.1, 2.0));
    // The potential of half of the lanes has two wells.
    let alpha = spread(-1.5, 1.0);
    let names = [
        compare(&DUFFING, 1, &[alpha, [0.5; 8], c], 0.1),
        compare(&VAN_DER_POL, 1, &[mu], 0.05),
        // Closed forms.
        compare(&DAMPED_OSCILLATOR, 1, &[[2.0; 8], c], 0.1),
    ];
    for names in names {
        for name in ["leapfrog", "rk4", "moddg", "increment-2", "increment-8"] {
            assert!(names.contains(&name), "{name} is not compared: {names:?}");
        }
    }
}

#[test]
fn chains_and_rings_are_the_same_in_a_lane_and_alone() {
    let (beta, mu) = (spread(0.0, 2.0), spread(0.1, 1.5));
    let names = [
        compare(&FPUT_CHAIN, 5, &[beta, [0.1; 8]], 0.1),
        compare(&VAN_DER_POL_RING, 6, &[mu, [0.4; 8]], 0.05),
    ];
    for names in names {
        for name in ["leapfrog", "rk4", "increment-2", "increment-8"] {
            assert!(names.contains(&name), "{name} is not compared: {names:?}");
        }
    }
}
