//! Systems of several degrees of freedom: orders, and end states computed with another library.

use crate::bind::Curved;
use crate::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{Grid, Quad, Scalar, Series, State, System, integrate};
use afterbay_methods::Gonzalez;
use afterbay_systems::{DampedDoublePendulum, FputChain, VanDerPolRing};
use slope::slope;

/// q, p and w at `end`, after `steps` steps.
fn carry<T: Scalar>(system: &Curved<T>, q: &[T], p: &[T], end: f64, steps: u64) -> [Vec<T>; 3] {
    let mut state = State::new(q.to_vec(), p.to_vec()).unwrap();
    let grid = Grid { h: T::from_f64(end) / T::from_f64(steps as f64), steps };
    integrate(&Gonzalez::default(), system, grid, &mut state, &mut ()).unwrap();
    [state.q, state.p, state.w]
}

/// The largest absolute difference of two vectors.
fn far<T: Scalar>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (a - b).to_f64().abs()).fold(0.0, f64::max)
}

/// Checks that the slopes of the global errors of q, p and w at t = 1 are 2.
fn orders<T: Scalar, const N: usize>(
    system: &Curved<T>,
    series: &dyn System<Series<T, 24>>,
    counts: &[u64],
) {
    let q: [T; N] = std::array::from_fn(|j| T::from_f64((0.4 + 1.7 * j as f64).sin()));
    let p: [T; N] = std::array::from_fn(|j| T::from_f64((2.1 + 1.7 * j as f64).sin()));
    let exact =
        trajectory::<_, _, 24>(series, &State::new(q, p).unwrap(), T::one(), 1).unwrap()[1].clone();
    let ends = counts.iter().map(|&count| carry(system, &q, &p, 1.0, count));
    let errors: Vec<[f64; 3]> =
        ends.map(|[q, p, w]| [far(&q, &exact.q), far(&p, &exact.p), far(&w, &exact.w)]).collect();
    let steps: Vec<f64> = counts.iter().map(|&count| 1.0 / count as f64).collect();
    for part in 0..3 {
        let errors: Vec<f64> = errors.iter().map(|errors| errors[part]).collect();
        let slope = slope(&steps, &errors);
        assert!((slope - 2.0).abs() < 0.1, "order {slope} of {part}: {errors:?}");
    }
}

#[test]
fn order_2_in_q_p_and_w() {
    let (counts, fine) = ([50, 70, 100, 140, 200], [200, 400, 800]);
    let quad = Quad::from_f64;
    let pendulum = DampedDoublePendulum::new([1.0, 0.7], [1.0, 0.8], 9.81, [0.3, 0.2]).unwrap();
    orders::<f64, 2>(&pendulum, &pendulum.map(Series::constant), &counts.map(|count| 4 * count));
    orders::<Quad, 2>(&pendulum.map(quad), &pendulum.map(quad).map(Series::constant), &fine);
    let chain = FputChain::new(5, 1.0, 0.2).unwrap();
    orders::<f64, 5>(&chain, &chain.map(Series::constant), &counts);
    orders::<Quad, 5>(&chain.map(quad), &chain.map(quad).map(Series::constant), &fine);
    let ring = VanDerPolRing::new(4, 1.0, 0.3).unwrap();
    orders::<f64, 4>(&ring, &ring.map(Series::constant), &counts);
    orders::<Quad, 4>(&ring.map(quad), &ring.map(quad).map(Series::constant), &fine);
}

/// End states computed by mpmath to 30 digits (crates/systems/tests/data/many_degrees.py).
const REFERENCES: &str = include_str!("../../../systems/tests/data/many_degrees.csv");

/// (q, p, w) of a system at one of the reference times.
fn reference(system: &str, t: &str) -> [Vec<f64>; 3] {
    let rows = REFERENCES.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let rows: Vec<_> = rows.filter(|row| row[0] == system && row[1] == t).collect();
    [3, 5, 7].map(|column| rows.iter().map(|row| row[column].parse().unwrap()).collect())
}

/// The method is symmetric, so its error is a series in h². Extrapolation from four step sizes
/// removes three of its terms.
fn check(name: &str, times: [&str; 2], h: f64, system: &Curved<f64>) {
    let [q, p, _] = reference(name, "0");
    for t in times {
        let end: f64 = t.parse().unwrap();
        let steps = (end / h).round() as u64;
        let mut table =
            [1, 2, 4, 8].map(|finer| carry(system, &q, &p, end, steps * finer).concat());
        for level in 1..4 {
            let share = 1.0 / (4.0_f64.powi(level as i32) - 1.0);
            for row in (level..4).rev() {
                let (coarse, fine) = table.split_at_mut(row);
                for (fine, coarse) in fine[0].iter_mut().zip(&coarse[row - 1]) {
                    *fine += (*fine - coarse) * share;
                }
            }
        }
        let off = far(&table[3], &reference(name, t).concat());
        assert!(off < 1e-11, "{name} at t = {t}: {off:e}");
    }
}

#[test]
fn end_states_are_those_of_another_library() {
    check("fput-chain", ["5", "20"], 0.02, &FputChain::new(8, 1.0, 0.05).unwrap());
    let pendulum = DampedDoublePendulum::new([1.0; 2], [1.0; 2], 9.81, [0.1, 0.2]).unwrap();
    check("damped-double-pendulum", ["2", "5"], 0.0025, &pendulum);
    check("van-der-pol-ring", ["5", "10"], 0.01, &VanDerPolRing::new(5, 1.0, 0.3).unwrap());
}
