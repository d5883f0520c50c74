//! Systems of several degrees of freedom: orders, and end states computed with another library.

use crate::bind::after;
use crate::catalog::{As, Both, Built, chain, pendulum, ring};
use crate::gonzalez::check_order;
use afterbay_core::{Grid, Quad, State};
use afterbay_methods::registry::{Run, find};
use afterbay_systems::catalog::Expandable;

/// q, p and w at `end`, after `steps` steps.
fn carry(run: &Run<f64>, q: &[f64], p: &[f64], end: f64, steps: u64) -> Vec<f64> {
    let start = State::new(q.to_vec(), p.to_vec()).unwrap();
    let State { q, p, w, .. } = after(run, Grid { h: end / steps as f64, steps }, &start);
    [q, p, w].concat()
}

#[test]
fn order_2_in_q_p_and_w() {
    fn check<T: Both + Expandable>(counts: &[u64], finer: u64) {
        let order = |system: Built, counts: &[u64]| {
            check_order::<T>(&system.curved(), &*system.series(), counts);
        };
        let shorter: Vec<u64> = counts.iter().map(|count| finer * count).collect();
        order(pendulum([1.0, 0.7], [1.0, 0.8], 9.81, [0.3, 0.2]), &shorter);
        order(chain(5, 1.0, 0.2), counts);
        order(ring(4, 1.0, 0.3), counts);
    }
    check::<f64>(&[50, 70, 100, 140, 200], 4);
    check::<Quad>(&[200, 400, 800], 1);
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
fn check(name: &str, times: [&str; 2], h: f64, system: &Built) {
    let [q, p, _] = reference(name, "0");
    let run = system.bind(find("gonzalez").unwrap(), As::Curved).unwrap();
    for t in times {
        let end: f64 = t.parse().unwrap();
        let steps = (end / h).round() as u64;
        let mut table = [1, 2, 4, 8].map(|finer| carry(&run, &q, &p, end, steps * finer));
        for level in 1..4 {
            let share = 1.0 / (4.0_f64.powi(level as i32) - 1.0);
            for row in (level..4).rev() {
                let (coarse, fine) = table.split_at_mut(row);
                for (fine, coarse) in fine[0].iter_mut().zip(&coarse[row - 1]) {
                    *fine += (*fine - coarse) * share;
                }
            }
        }
        let exact = reference(name, t).concat();
        let off = table[3].iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-11, "{name} at t = {t}: {off:e}");
    }
}

#[test]
fn end_states_are_those_of_another_library() {
    check("fput-chain", ["5", "20"], 0.02, &chain(8, 1.0, 0.05));
    let pendulum = pendulum([1.0; 2], [1.0; 2], 9.81, [0.1, 0.2]);
    check("damped-double-pendulum", ["2", "5"], 0.0025, &pendulum);
    check("van-der-pol-ring", ["5", "10"], 0.01, &ring(5, 1.0, 0.3));
}
