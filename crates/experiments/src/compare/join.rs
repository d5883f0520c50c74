//! Two tables joined by the keys of their rows, and the differences of their columns.

use super::table::Table;
use serde::Serialize;
use std::collections::HashMap;

/// The measure of the difference of two numbers in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Times: by their ratio. Unequal times are no difference of the results.
    Time,
    /// Errors and counts: by their ratio, B/A.
    Ratio,
    /// Other numbers: by their difference, B - A.
    Difference,
}

impl Measure {
    fn of(column: &str) -> Self {
        const RATIOS: [&str; 11] = [
            "h",
            "k_drift",
            "rms",
            "steps",
            "points",
            "evaluations",
            "iterations",
            "passivity_violations",
            "spectral_radius",
            "steps_done",
            "decay",
        ];
        match column {
            "seconds" => Self::Time,
            _ if column.starts_with("error") || column.starts_with("doubt") => Self::Ratio,
            _ if RATIOS.contains(&column) => Self::Ratio,
            _ => Self::Difference,
        }
    }

    /// The comparison of two numbers; none if it is not finite.
    fn compare(self, a: f64, b: f64) -> Option<f64> {
        let compared = match self {
            Self::Time | Self::Ratio => b / a,
            Self::Difference => b - a,
        };
        compared.is_finite().then_some(compared)
    }

    /// The ending of the name of the column with the comparison.
    fn suffix(self) -> &'static str {
        if self == Self::Difference { "difference" } else { "ratio" }
    }
}

/// A column that both tables have, over the rows that both have.
#[derive(Clone, Debug, Serialize)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The measure of the difference of its numbers.
    pub measure: Measure,
    /// Whether an entry is neither a number nor empty.
    pub words: bool,
    /// The number of rows whose entries differ.
    pub different: usize,
    /// The number of rows with an entry that is empty in one table only.
    pub empty: usize,
    /// The smallest and the largest comparison of the numbers that differ.
    pub range: Option<[f64; 2]>,
}

/// Two tables joined by their keys.
#[derive(Clone, Debug, Serialize)]
pub struct Joined {
    /// The name below `data`, without `.csv`.
    pub name: String,
    /// The columns that identify a row.
    pub keys: Vec<String>,
    /// The number of rows in both.
    pub rows: usize,
    /// The number of rows in A only, and in B only.
    pub rows_in_one: [usize; 2],
    /// The columns in A only, and in B only.
    pub columns_in_one: [Vec<String>; 2],
    /// The other columns that both have.
    pub columns: Vec<Column>,
    /// The places of the rows in both tables.
    #[serde(skip)]
    pub(super) pairs: Vec<[usize; 2]>,
}

impl Joined {
    /// Joins two tables. Rows with the same key are joined in their order.
    pub(super) fn of(name: &str, a: &Table, b: &Table) -> Self {
        let mut keys = a.keys(name);
        keys.retain(|key| b.column(key).is_some());
        let mut seen = HashMap::<Vec<String>, Vec<usize>>::new();
        for (at, row) in b.rows.iter().enumerate().rev() {
            seen.entry(b.key(row, &keys)).or_default().push(at);
        }
        let mut pairs = Vec::new();
        for (at, row) in a.rows.iter().enumerate() {
            let other = seen.get_mut(&a.key(row, &keys)).and_then(Vec::pop);
            pairs.extend(other.map(|other| [at, other]));
        }
        let in_one = |one: &Table, other: &Table| -> Vec<String> {
            let names = one.header.iter().filter(|name| other.column(name).is_none());
            names.cloned().collect()
        };
        let shared = a.header.iter().filter(|name| b.column(name).is_some());
        let columns = shared.filter(|name| !keys.contains(name));
        let columns = columns.map(|name| Column::of(name, a, b, &pairs)).collect();
        Self {
            name: name.into(),
            rows: pairs.len(),
            rows_in_one: [a.rows.len() - pairs.len(), b.rows.len() - pairs.len()],
            columns_in_one: [in_one(a, b), in_one(b, a)],
            columns,
            keys,
            pairs,
        }
    }

    /// The columns whose entries differ, other than times.
    pub(super) fn different(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(|c| c.different > 0 && c.measure != Measure::Time)
    }

    /// The columns of times that differ.
    pub(super) fn times(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(|c| c.different > 0 && c.measure == Measure::Time)
    }

    /// Whether nothing differs but times.
    pub(super) fn is_equal(&self) -> bool {
        self.different().next().is_none()
            && self.rows_in_one == [0, 0]
            && self.columns_in_one.iter().all(Vec::is_empty)
    }

    /// The header of the joined table: the keys, and of each column A, B and their comparison.
    pub(super) fn header(&self, columns: &[&Column]) -> Vec<String> {
        let mut header = self.keys.clone();
        for Column { name, measure, words, .. } in columns {
            header.extend([format!("{name}_a"), format!("{name}_b")]);
            header.extend((!words).then(|| format!("{name}_{}", measure.suffix())));
        }
        header
    }

    /// The entries of a joined row.
    pub(super) fn entries(
        &self,
        (a, b): (&Table, &Table),
        pair: [usize; 2],
        columns: &[&Column],
    ) -> Vec<String> {
        let keys = self.keys.iter().map(|key| entry(a, pair[0], key).to_owned());
        let mut entries: Vec<String> = keys.collect();
        for Column { name, measure, words, .. } in columns {
            let (a, b) = (entry(a, pair[0], name), entry(b, pair[1], name));
            entries.extend([a.to_owned(), b.to_owned()]);
            let compared = number(a).zip(number(b)).and_then(|(a, b)| measure.compare(a, b));
            entries.extend((!words).then(|| compared.map_or(String::new(), |x| x.to_string())));
        }
        entries
    }
}

impl Column {
    fn of(name: &str, left: &Table, right: &Table, pairs: &[[usize; 2]]) -> Self {
        let measure = Measure::of(name);
        // A row of a sweep names what its value is.
        let is_time = |row: usize| entry(left, row, "what") == "seconds";
        let mut column =
            Self { name: name.into(), measure, words: false, different: 0, empty: 0, range: None };
        for [i, j] in pairs {
            let (a, b) = (entry(left, *i, name), entry(right, *j, name));
            column.words |= [a, b].iter().any(|entry| !entry.is_empty() && number(entry).is_none());
            column.empty += usize::from(a.is_empty() != b.is_empty());
            if is_same(a, b) || is_time(*i) {
                continue;
            }
            column.different += 1;
            let numbers = number(a).zip(number(b));
            if let Some(x) = numbers.and_then(|(a, b)| measure.compare(a, b)) {
                let [lo, hi] = column.range.unwrap_or([x, x]);
                column.range = Some([lo.min(x), hi.max(x)]);
            }
        }
        column
    }
}

/// An entry; empty if there is none.
pub(super) fn entry<'a>(table: &'a Table, row: usize, column: &str) -> &'a str {
    let row = table.rows.get(row);
    let entry = row.and_then(|row| row.get(table.column(column)?));
    entry.map_or("", String::as_str)
}

/// The number in an entry. It may be NaN.
pub(super) fn number(entry: &str) -> Option<f64> {
    entry.parse().ok()
}

/// Whether two entries have the same text, are the same number or both no number.
fn is_same(a: &str, b: &str) -> bool {
    let numbers = number(a).zip(number(b));
    a == b || numbers.is_some_and(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(lines: &[&str]) -> Table {
        let entries = |text: &&str| text.split(',').map(str::to_owned).collect();
        Table { header: entries(&lines[0]), rows: lines[1..].iter().map(entries).collect() }
    }

    #[test]
    fn rows_meet_by_their_keys_whatever_their_order() {
        let a = table(&["method,h,outcome,error_qp,seconds", "x,0.1,completed,2e-3,1", "y,0.1,,,"]);
        let b = table(&["method,h,outcome,error_qp,seconds", "z,0.1,,,", "x,0.10,pole,1e-3,3"]);
        let joined = Joined::of("work_precision", &a, &b);
        assert_eq!((joined.rows, joined.rows_in_one), (1, [1, 1]));
        let names: Vec<_> = joined.different().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["outcome", "error_qp"]);
        assert_eq!(joined.columns[1].range, Some([0.5, 0.5]));
        assert_eq!(joined.columns[2].range, Some([3.0, 3.0]));
        let columns: Vec<_> = joined.columns.iter().collect();
        assert_eq!(
            joined.header(&columns).join(","),
            "method,h,outcome_a,outcome_b,error_qp_a,error_qp_b,error_qp_ratio,seconds_a,\
             seconds_b,seconds_ratio"
        );
        let entries = joined.entries((&a, &b), joined.pairs[0], &columns);
        assert_eq!(entries.join(","), "x,0.1,completed,pole,2e-3,1e-3,0.5,1,3,3");
    }

    #[test]
    fn times_alone_are_no_difference() {
        let a = table(&["method,h,seconds", "x,0.1,1"]);
        let b = table(&["method,h,seconds", "x,0.1,2"]);
        assert!(Joined::of("work_precision", &a, &b).is_equal());
        let a = table(&["topic,of,what,value", "cost,rk4,seconds,1", "cost,rk4,steps,8"]);
        let b = table(&["topic,of,what,value", "cost,rk4,seconds,2", "cost,rk4,steps,8"]);
        assert!(Joined::of("sweep", &a, &b).is_equal());
        let c = table(&["topic,of,what,value", "cost,rk4,seconds,1", "cost,rk4,steps,9"]);
        assert!(!Joined::of("sweep", &a, &c).is_equal());
        let a = table(&["method,h,seconds", "x,0.1,1"]);
        let more = table(&["method,h,seconds,steps", "x,0.1,2,3"]);
        assert!(!Joined::of("work_precision", &a, &more).is_equal());
    }

    #[test]
    fn empty_cells_and_nan_are_counted_and_have_no_comparison() {
        let a = table(&["method,t,H,K", "x,0,1,NaN", "x,1,,NaN", "x,2,0,1"]);
        let b = table(&["method,t,H,K", "x,0,,NaN", "x,1,,2", "x,2,0,inf"]);
        let joined = Joined::of("energy", &a, &b);
        let [h, k] = &joined.columns[..] else { panic!("two columns") };
        assert_eq!((h.different, h.empty, h.range), (1, 1, None));
        assert_eq!((k.different, k.empty, k.range), (2, 0, None));
    }
}
