//! Lists and ranges of values.

use super::{Planned, Planner};
use crate::scene::document::Spread;
use crate::scene::problem::SceneProblem;
use afterbay_analysis::Spacing;
use afterbay_core::{Grid, InputError};
use std::collections::HashSet;

/// The most values of a range.
const MOST_VALUES: u64 = 100_000;

/// The path of value i of a spread.
pub(super) fn entry(path: &str, steps: &Spread, i: usize) -> String {
    match steps {
        Spread::List(_) => format!("{path}.steps.{i}"),
        Spread::Range(_) => format!("{path}.steps"),
    }
}

/// A value of a range within this many roundings of its larger end is 0, as one between -0.1 and
/// 0.5.
const ROUNDINGS: f64 = 2.0;

impl Planner<'_> {
    /// The values of a spread of steps.
    pub(super) fn spread(&self, path: &str, spread: &Spread) -> Planned<Vec<f64>> {
        match spread {
            Spread::List(list) if list.is_empty() => {
                self.refuse(path, SceneProblem::Empty { what: "step" })
            }
            Spread::List(list) => {
                self.list(path, list, |h| Grid::<f64>::of(h, 1).map(drop))?;
                Ok(list.clone())
            }
            Spread::Range(range) => {
                self.range(path, (range.from, range.to), range.count, range.scale, 0.0)
            }
        }
    }

    /// Checks that each value passes `check` and occurs only once.
    pub(in crate::scene) fn list(
        &self,
        path: &str,
        list: &[f64],
        check: impl Fn(f64) -> Result<(), InputError>,
    ) -> Planned<()> {
        let mut seen = HashSet::new();
        for (i, &x) in list.iter().enumerate() {
            let path = format!("{path}.{i}");
            self.within(&path, check(x))?;
            if !seen.insert(x.to_bits()) {
                return self.refuse(&path, SceneProblem::Twice { name: x.to_string() });
            }
        }
        Ok(())
    }

    /// `count` values from `from` to `to`, which must exceed `above`.
    pub(in crate::scene) fn range(
        &self,
        path: &str,
        (from, to): (f64, f64),
        count: u64,
        scale: Spacing,
        above: f64,
    ) -> Planned<Vec<f64>> {
        let refuse = |key: &'static str, value: f64, range: &'static str| {
            self.refuse(&format!("{path}.{key}"), SceneProblem::Range { name: key, value, range })
        };
        if !(1..=MOST_VALUES).contains(&count) {
            return refuse("count", count as f64, "from 1 to 100000");
        }
        if count > 1 && from == to {
            return refuse("to", to, "another value than `from`, where there is more than one");
        }
        if count == 1 && from != to {
            return refuse("to", to, "that of `from`, where there is one value");
        }
        for (key, value) in [("from", from), ("to", to)] {
            if scale == Spacing::Log && value <= 0.0 {
                return refuse(key, value, "positive where the scale is \"log\"");
            }
            if value <= above {
                return refuse(key, value, "positive");
            }
        }
        if scale == Spacing::Linear && !(to - from).is_finite() {
            return refuse("to", to, "at a finite distance from `from`");
        }
        if scale == Spacing::Log && !(to / from).is_normal() {
            return refuse("to", to, "within a factor of 1e307 of `from`");
        }
        let share = |i: u64| if count > 1 { i as f64 / (count - 1) as f64 } else { 0.0 };
        let at = |i: u64| match scale {
            // The ends are those of the scene to the bit.
            _ if i == 0 => from,
            _ if i + 1 == count => to,
            Spacing::Log => from * (to / from).powf(share(i)),
            Spacing::Linear => {
                let value = from + (to - from) * share(i);
                let rounding = ROUNDINGS * f64::EPSILON * from.abs().max(to.abs());
                if value.abs() <= rounding { 0.0 } else { value }
            }
        };
        Ok((0..count).map(at).collect())
    }
}
