//! The distance of two trajectories at the times that both have.

use super::join::{Joined, entry, number};
use super::table::Table;
use serde::Serialize;

/// The variables that are compared.
pub(super) const VARIABLES: [&str; 3] = ["q", "p", "w"];

/// The distance of two states at a time.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Distance {
    /// The method, and the point of a sweep.
    pub(super) run: String,
    /// The time.
    pub(super) t: f64,
    /// The largest |q_j(B) - q_j(A)|, and that of p and of w; none if one is not finite.
    pub(super) q: Option<f64>,
    pub(super) p: Option<f64>,
    pub(super) w: Option<f64>,
}

impl Distance {
    /// The distances in q, p and w.
    pub(super) fn each(&self) -> [Option<f64>; 3] {
        [self.q, self.p, self.w]
    }
}

/// The distances at all common times.
pub(super) fn distances(joined: &Joined, (a, b): (&Table, &Table)) -> Vec<Distance> {
    let entries = VARIABLES.map(|variable| {
        let names = a.header.iter().filter(|name| is_entry(name, variable));
        names.filter(|name| b.column(name).is_some()).collect::<Vec<_>>()
    });
    let one = |&[i, j]: &[usize; 2]| {
        let largest = |names: &Vec<&String>| {
            let mut sizes = names.iter().map(|name| {
                let (a, b) = (number(entry(a, i, name))?, number(entry(b, j, name))?);
                Some((b - a).abs()).filter(|size| size.is_finite())
            });
            sizes.try_fold(0.0, |most: f64, size| Some(most.max(size?)))
        };
        let [q, p, w] = [0, 1, 2].map(|variable| largest(&entries[variable]));
        Some(Distance { run: run(joined, a, i), t: number(entry(a, i, "t"))?, q, p, w })
    };
    joined.pairs.iter().filter_map(one).collect()
}

/// The run of a row: the method, and the values of a sweep.
fn run(joined: &Joined, table: &Table, row: usize) -> String {
    let swept = joined.keys.iter().filter_map(|key| {
        let name = key.strip_prefix("sweep_")?;
        Some(format!("{name} = {}", entry(table, row, key)))
    });
    let method = entry(table, row, "method").to_owned();
    [method].into_iter().chain(swept).collect::<Vec<_>>().join(", ")
}

/// Whether a column is an entry of a variable, such as q1.
fn is_entry(column: &str, variable: &str) -> bool {
    let number = column.strip_prefix(variable);
    number.is_some_and(|number| number.parse::<usize>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_meet_at_common_times() {
        let table = |h: f64, shift: f64| Table {
            header: ["method", "t", "q1", "q2", "p1", "p2", "w1"].map(str::to_owned).to_vec(),
            rows: (0..8)
                .map(|n| h * f64::from(n))
                .map(|t| [t, 1.0, 2.0 + shift * t, 0.0, -shift, f64::NAN].map(|x| x.to_string()))
                .map(|entries| ["rk4".to_owned()].into_iter().chain(entries).collect())
                .collect(),
        };
        let (a, b) = (table(0.1, 0.0), table(0.3, 2.0));
        let joined = Joined::of("trajectory", &a, &b);
        let found = distances(&joined, (&a, &b));
        assert_eq!(found.len(), 3);
        assert!((found[1].t - 0.3).abs() < 1e-12 && found[1].run == "rk4");
        assert!(found[2].q.is_some_and(|q| (q - 1.2).abs() < 1e-9));
        assert_eq!((found[2].p, found[2].w), (Some(2.0), None));
    }
}
