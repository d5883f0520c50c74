//! The systems with many degrees of freedom against end states computed by another library, without
//! H.

use afterbay_core::{Quad, Scalar, Series, State, System, taylor};
use afterbay_systems::{DampedDoublePendulum, FputChain, VanDerPolRing};

/// From `many_degrees.py` beside it.
const TABLE: &str = include_str!("../data/many_degrees.csv");

/// The time, and q, p, w of each degree of freedom.
type Row<const D: usize> = (usize, [[Quad; D]; 3]);

/// The rows of a system, the initial state first.
fn rows<const D: usize>(name: &str) -> Vec<Row<D>> {
    let parse =
        |line: &'static str| line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    let lines: Vec<_> = TABLE
        .lines()
        .filter_map(|line| Some(parse(line.strip_prefix(name)?.strip_prefix(',')?)))
        .collect();
    assert!(lines.len().is_multiple_of(D));
    let part =
        |rows: &[Vec<f64>], k: usize| std::array::from_fn(|j| Quad(rows[j][k], rows[j][k + 1]));
    lines.chunks(D).map(|rows| (rows[0][0] as usize, [2, 4, 6].map(|k| part(rows, k)))).collect()
}

/// The largest error of q, p and w at the times of the table, all of which are whole numbers.
fn worst<T, S, const D: usize>(name: &str, system: &S, low: impl Fn(T) -> f64) -> f64
where
    T: Scalar,
    S: System<Series<T, 24>>,
{
    let rows = rows::<D>(name);
    let (start, rest) = rows.split_first().unwrap();
    let [q, p, _] = start.1.map(|part| part.map(|x| T::from_f64(x.0)));
    let end = rest.last().unwrap().0;
    let states = taylor::trajectory(system, &State::new(q, p).unwrap(), T::one(), end).unwrap();
    let mut worst = 0.0_f64;
    for (t, exact) in rest {
        let State { q, p, w, .. } = &states[*t];
        for (found, exact) in [q, p, w].into_iter().flatten().zip(exact.iter().flatten()) {
            worst = worst.max(Quad(found.to_f64(), low(*found)).sub_accurate(*exact).0.abs());
        }
    }
    worst
}

macro_rules! assert_agrees {
    ($name:literal, $dof:literal, $system:expr, $plain:literal, $quad:literal) => {{
        let system = $system.unwrap();
        let plain = worst::<f64, _, $dof>($name, &system.map(Series::constant), |_| 0.0);
        let lift = |x| Series::constant(Quad::from_f64(x));
        let quad = worst::<Quad, _, $dof>($name, &system.map(lift), |x| x.1);
        assert!(plain < $plain && quad < $quad, "{}: {plain:e} {quad:e}", $name);
    }};
}

#[test]
fn the_chain_ends_where_it_should() {
    assert_agrees!("fput-chain", 8, FputChain::new(8, 1.0, 0.05), 2e-15, 2e-31);
}

#[test]
fn the_ring_ends_where_it_should() {
    assert_agrees!("van-der-pol-ring", 5, VanDerPolRing::new(5, 1.0, 0.3), 5e-13, 1e-29);
}

#[test]
fn the_double_pendulum_ends_where_it_should() {
    let system = DampedDoublePendulum::new([1.0; 2], [1.0; 2], 9.81, [0.1, 0.2]);
    assert_agrees!("damped-double-pendulum", 2, system, 5e-14, 1e-29);
}
