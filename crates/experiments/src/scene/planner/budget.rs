//! The budget of a scene: the most steps, rows, values, cells and tolerances.

use super::{Planned, Planner};
use crate::scene::problem::SceneProblem;

/// The most steps of a run, and of all runs of a study.
pub(super) const MOST_STEPS: f64 = 1e11;
/// The most bytes of a table that is made in memory.
pub(super) const MOST_OUTPUT: f64 = 1e9;
/// The most bytes of the table of a run, which is written as it is computed.
const MOST_WRITTEN: f64 = 1e12;
/// Bytes of a number in a table, including its separator.
pub(super) const BYTES: f64 = 20.0;
/// The most states kept where a scene does not give `every`, at all points of a sweep together.
const STATES_KEPT: u64 = 10_000;
/// The most cells of a map.
pub(super) const MOST_CELLS: f64 = 1e6;
/// The most tolerances. Each is a run of an unknown number of steps.
pub(super) const MOST_TOLERANCES: f64 = 1000.0;
/// The advice where the states of steps take too many bytes.
pub(super) const FEWER_STATES: &str = "keep fewer states with `every`, or take larger steps";

impl Planner<'_> {
    /// Refuses a size beyond its limit.
    pub(in crate::scene) fn budget(
        &self,
        path: &str,
        what: &'static str,
        (size, limit): (f64, f64),
        change: &'static str,
    ) -> Planned<()> {
        if size <= limit {
            return Ok(());
        }
        self.refuse(path, SceneProblem::Budget { what, size, limit, change })
    }

    /// The number of steps between two states kept, of a run of `steps` steps.
    pub(super) fn every(&self, path: &str, every: Option<u64>, steps: u64) -> Planned<u64> {
        match every {
            Some(0) => self.refuse(
                path,
                SceneProblem::Range { name: "every", value: 0.0, range: "a whole number from 1" },
            ),
            Some(every) => Ok(every),
            None => Ok(steps.div_ceil((STATES_KEPT / self.points as u64).max(2)).max(1)),
        }
    }

    /// Refuses too many steps.
    pub(super) fn steps_fit(&self, path: &str, steps: f64) -> Planned<()> {
        self.budget(
            path,
            "the number of steps",
            (steps * self.points as f64, MOST_STEPS),
            "take larger steps, fewer of them, or an earlier end",
        )
    }

    /// Refuses a table of too many bytes.
    pub(super) fn table_fits(&self, path: &str, rows: u64, numbers: usize) -> Planned<()> {
        self.output(path, (rows, numbers), MOST_OUTPUT, FEWER_STATES)
    }

    /// Refuses a run whose states take too many bytes.
    pub(super) fn states_fit(
        &self,
        path: &str,
        size: (u64, usize),
        change: &'static str,
    ) -> Planned<()> {
        let limit = if self.points > 1 { MOST_OUTPUT } else { MOST_WRITTEN };
        self.output(path, size, limit, change)
    }

    fn output(
        &self,
        path: &str,
        (rows, numbers): (u64, usize),
        limit: f64,
        change: &'static str,
    ) -> Planned<()> {
        let size = (rows as f64 + 1.0) * numbers as f64 * BYTES * self.points as f64;
        self.budget(path, "the output in bytes", (size, limit), change)
    }
}
