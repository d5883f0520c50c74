//! Eight systems side by side: each lane computes what its system computes alone, to the bit.

use afterbay_core::{Abilities, Grid, Scalar, State, f64x8};
use afterbay_methods::registry::{METHODS, bind};
use afterbay_systems::{DampedOscillator, Duffing, FputChain, VanDerPol, VanDerPolRing};
use std::ops::ControlFlow;
use std::sync::Arc;

const STEPS: u64 = 200;

/// q and p at the start, of degree of freedom j in lane k.
fn start(k: usize, j: usize) -> [f64; 2] {
    let phase = 0.7 * j as f64 + 0.3 * k as f64;
    [phase.sin() * (1.0 + k as f64 / 16.0), (1.3 * phase).cos()]
}

/// Compares every method that has lanes. `alone` is the system of a lane. Returns the names of the
/// methods.
fn compare(
    lanes: impl Abilities<f64x8> + 'static,
    alone: impl Fn(usize) -> Arc<dyn Abilities<f64>>,
    h: f64,
) -> Vec<&'static str> {
    let (n, lanes): (_, Arc<dyn Abilities<f64x8>>) = (lanes.dof(), Arc::new(lanes));
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
    let splat = f64x8::from_f64;
    let (c, mu) = (spread(0.0, 0.7), spread(0.1, 2.0));
    // The potential of half of the lanes has two wells.
    let alpha = spread(-1.5, 1.0);
    let duffing = Duffing::new(f64x8::new(alpha), splat(0.5), f64x8::new(c)).unwrap();
    let oscillator = DampedOscillator::new(splat(2.0), f64x8::new(c)).unwrap();
    let names = [
        compare(duffing, |k| Arc::new(Duffing::new(alpha[k], 0.5, c[k]).unwrap()), 0.1),
        compare(
            VanDerPol::new(f64x8::new(mu)).unwrap(),
            |k| Arc::new(VanDerPol::new(mu[k]).unwrap()),
            0.05,
        ),
        // Closed forms.
        compare(oscillator, |k| Arc::new(DampedOscillator::new(2.0, c[k]).unwrap()), 0.1),
    ];
    for names in names {
        for name in ["leapfrog", "rk4", "moddg", "increment-2", "increment-8"] {
            assert!(names.contains(&name), "{name} is not compared: {names:?}");
        }
    }
}

#[test]
fn chains_and_rings_are_the_same_in_a_lane_and_alone() {
    let splat = f64x8::from_f64;
    let (beta, mu) = (spread(0.0, 2.0), spread(0.1, 1.5));
    let chain = FputChain::new(5, f64x8::new(beta), splat(0.1)).unwrap();
    let ring = VanDerPolRing::new(6, f64x8::new(mu), splat(0.4)).unwrap();
    let names = [
        compare(chain, |k| Arc::new(FputChain::new(5, beta[k], 0.1).unwrap()), 0.1),
        compare(ring, |k| Arc::new(VanDerPolRing::new(6, mu[k], 0.4).unwrap()), 0.05),
    ];
    for names in names {
        for name in ["leapfrog", "rk4", "increment-2", "increment-8"] {
            assert!(names.contains(&name), "{name} is not compared: {names:?}");
        }
    }
}
