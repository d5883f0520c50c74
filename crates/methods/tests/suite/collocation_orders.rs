//! Energy-preserving collocation has order 2 to 16 in q, p and w: errors against Taylor series, in
//! 31 digits.

use crate::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{Curvature, Grid, Quad, Scalar, Series, State, System, integrate};
use afterbay_methods::Collocation;
use afterbay_systems::{DampedDoublePendulum, Duffing, FputChain, VanDerPolRing};
use slope::slope;

/// The number of terms of the series.
const TERMS: usize = 40;

/// The largest error of q, p and w at `end`, after `steps` steps from (q, p).
fn errors<S: Curvature<Quad>, const N: usize>(
    system: &S,
    stages: usize,
    steps: u64,
    start: &State<[Quad; N]>,
    exact: &State<[Quad; N]>,
) -> [f64; 3] {
    let mut state = start.clone();
    let grid = Grid { h: exact.t / Quad::from_f64(steps as f64), steps };
    integrate(&Collocation::new(stages), system, grid, &mut state, &mut ()).unwrap();
    [(&state.q, &exact.q), (&state.p, &exact.p), (&state.w, &exact.w)].map(|(found, exact)| {
        (0..N).fold(0.0, |most: f64, j| most.max((found[j] - exact[j]).to_f64().abs()))
    })
}

/// Checks that the global orders at `end` are 2s to within 0.05. The numbers of steps per unit of
/// time are those of [`PLAN`] times `finer`.
fn orders<const N: usize>(
    system: &impl Curvature<Quad>,
    series: &impl System<Series<Quad, TERMS>>,
    [q, p]: [[f64; N]; 2],
    end: f64,
    finer: f64,
) {
    let start = State::new(q.map(Quad::from_f64), p.map(Quad::from_f64)).unwrap();
    let exact = &trajectory::<_, _, TERMS>(series, &start, Quad::from_f64(end), 1).unwrap()[1];
    for (stages, counts) in PLAN {
        let counts = counts.map(|count| (count * finer * end).round());
        let all = counts.map(|steps| errors(system, stages, steps as u64, &start, exact));
        for (part, variable) in ["q", "p", "w"].into_iter().enumerate() {
            let errors = all.map(|error| error[part]);
            let found = slope(&counts.map(|count| end / count), &errors);
            println!("s={stages} {variable} {found:.3} {errors:?}");
            assert!(
                (found - 2.0 * stages as f64).abs() < 0.05,
                "{stages} {variable}: {found} {errors:?}"
            );
            // The smallest errors are below the rounding of `f64`.
            assert!(
                stages < 5 || errors[2] < f64::EPSILON / 2.0,
                "{stages} {variable}: {errors:?}"
            );
        }
    }
}

/// The stages, and the numbers of steps per unit of time.
const PLAN: [(usize, [f64; 3]); 8] = [
    (1, [120.0, 160.0, 220.0]),
    (2, [60.0, 80.0, 110.0]),
    (3, [40.0, 52.0, 70.0]),
    (4, [28.0, 36.0, 46.0]),
    (5, [22.0, 27.0, 33.0]),
    (6, [17.0, 21.0, 25.0]),
    (7, [14.0, 17.0, 20.0]),
    (8, [12.0, 14.0, 16.0]),
];

#[test]
fn of_a_chain() {
    let chain = FputChain::new(3, 0.5, 0.2).unwrap().map(Quad::from_f64);
    orders(&chain, &chain.map(Series::constant), [[0.5, -0.3, 0.8], [0.2, 0.7, -0.4]], 1.0, 1.0);
}

#[test]
fn of_a_ring() {
    let ring = VanDerPolRing::new(3, 0.7, 0.4).unwrap().map(Quad::from_f64);
    orders(&ring, &ring.map(Series::constant), [[0.9, -0.5, 1.3], [0.4, 1.2, -0.7]], 1.0, 1.0);
}

/// A system whose H is not separable.
#[test]
fn of_a_double_pendulum() {
    let pendulum = DampedDoublePendulum::new([1.0, 0.8], [1.0, 0.7], 3.0, [0.1, 0.2])
        .unwrap()
        .map(Quad::from_f64);
    orders(&pendulum, &pendulum.map(Series::constant), [[0.6, -0.4], [0.3, 0.5]], 0.5, 2.0);
}

#[test]
fn of_duffing() {
    let duffing = Duffing::new(-1.0, 1.0, 0.1).unwrap().map(Quad::from_f64);
    orders(&duffing, &duffing.map(Series::constant), [[1.5], [0.5]], 1.0, 1.0);
}
