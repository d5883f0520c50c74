//! A table as text, and the columns that tell its rows apart.

use crate::data::{self, DataError, DataFormat};
use std::path::Path;

/// A table of a result.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) header: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a table. An empty file is a table without columns.
    pub(super) fn read(path: &Path, format: DataFormat) -> Result<Self, DataError> {
        let (header, rows) = data::read(path, format)?;
        Ok(Self { header, rows })
    }

    /// The place of a column.
    pub(super) fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|other| other == name)
    }

    /// The columns that identify a row of the table `name`: those of the points of a sweep, then
    /// those of the contract of this table. Series over time have no h among them, so that the
    /// states of two steps meet at common times. Of a table that is not known, these are the
    /// columns of words and those that are usually varied.
    pub(super) fn keys(&self, name: &str) -> Vec<String> {
        let own: Vec<&str> = match name.rsplit('/').next().unwrap_or(name) {
            "trajectory" | "energy" | "overdamped_energy" => vec!["method", "t"],
            // The n-th event of a name in one result is compared with the n-th in the other.
            "events" => vec!["method", "event"],
            "local_orders" => vec!["method", "variable", "statistic"],
            "global_orders" => vec!["method", "variable", "h"],
            "work_precision" => vec!["method", "tolerance", "h"],
            "long_run" => vec!["method", "compensated", "steps"],
            "stability" => vec!["method", "parameter", "value", "h"],
            "local_errors" => vec!["method", "h", "t"],
            "size" | "cost" => vec!["method", "n"],
            "overdamped" => vec!["method", "b", "h"],
            "pick" => vec!["method"],
            "errata" => vec!["coefficient", "b", "q", "p"],
            "sweep" | "sweep_of_run" => vec!["topic", "of", "what"],
            _ => self.usual(),
        };
        let swept = self.header.iter().filter(|name| name.starts_with("sweep_"));
        let known = own.into_iter().filter(|name| self.column(name).is_some());
        swept.cloned().chain(known.map(str::to_owned)).collect()
    }

    fn usual(&self) -> Vec<&str> {
        const VARIED: [&str; 6] = ["n", "parameter", "value", "tolerance", "h", "t"];
        const RESULTS: [&str; 4] = ["outcome", "failure", "verdict", "why_not"];
        let is_word = |at: usize| {
            let mut entries = self.rows.iter().filter_map(|row| row.get(at));
            entries.any(|entry| !entry.is_empty() && entry.parse::<f64>().is_err())
        };
        let names = self.header.iter().map(String::as_str).enumerate();
        let keys = names.filter(|(at, name)| {
            VARIED.contains(name) || (!RESULTS.contains(name) && is_word(*at))
        });
        keys.map(|(_, name)| name).collect()
    }

    /// The key of a row, the entries of some columns. Numbers that agree in eleven digits, such as
    /// times counted in different steps, are the same. With a tolerance, h is a result and no key.
    pub(super) fn key(&self, row: &[String], columns: &[String]) -> Vec<String> {
        let entry = |name: &str| self.column(name).and_then(|at| row.get(at));
        let by_tolerance = entry("tolerance").is_some_and(|entry| !entry.is_empty());
        let part = |name: &String| match entry(name) {
            Some(_) if name == "h" && by_tolerance => String::new(),
            Some(text) => match text.parse::<f64>() {
                Ok(number) => format!("{:.10e}", number + 0.0),
                Err(_) => text.clone(),
            },
            None => String::new(),
        };
        columns.iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(header: &str, row: &str) -> Table {
        let entries = |text: &str| text.split(',').map(str::to_owned).collect();
        Table { header: entries(header), rows: vec![entries(row)] }
    }

    #[test]
    fn the_keys_of_a_known_table_are_those_of_its_contract() {
        let sweep = table("point,sweep_c,method,step,t,q1", "0,0.1,rk4,1,0.1,1");
        assert_eq!(sweep.keys("trajectory"), ["sweep_c", "method", "t"]);
        let events = table("method,event,t,q1", "rk4,top,0.1,1");
        assert_eq!(events.keys("events"), ["method", "event"]);
        let other = table("system,outcome,h,x", "duffing,completed,0.1,3");
        assert_eq!(other.keys("new"), ["system", "h"]);
    }

    #[test]
    fn times_of_two_steps_are_the_same() {
        let table = table("t", "0");
        let key = |t: f64| table.key(&[t.to_string()], &["t".into()]);
        assert_eq!(key(0.1 * 3.0), key(0.05 * 6.0));
        assert_eq!(key(0.3), key(0.1 + 0.2));
        assert_eq!(key(-0.0), key(0.0));
        assert_ne!(key(0.3), key(0.300_000_01));
    }

    #[test]
    fn a_mean_step_is_no_key() {
        let table = table("method,tolerance,h", "adaptive-dop853,1e-6,0.5");
        let columns = table.keys("work_precision");
        let key = |entries: [&str; 3]| table.key(&entries.map(str::to_owned), &columns);
        assert_eq!(key(["a", "1e-6", "0.5"]), key(["a", "1e-6", "0.4"]));
        assert_ne!(key(["a", "", "0.5"]), key(["a", "", "0.4"]));
    }
}
