//! The cost of a step as the number of degrees of freedom grows.

use super::{Problem, work_precision};
use crate::progress::Progress;
use afterbay_core::{Grid, IntegrateError};
use afterbay_methods::registry::Row;
use serde::Serialize;

/// A row of `cost.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct CostRow {
    /// Name of the method.
    pub method: &'static str,
    /// Degrees of freedom.
    pub n: usize,
    /// The step, in the unit of time of the problem.
    pub h: f64,
    /// Steps of the run.
    pub steps: u64,
    /// Wall-clock time of the run alone in seconds, that of the fastest of several runs.
    pub seconds: f64,
}

impl CostRow {
    /// Nanoseconds per degree of freedom and step.
    pub fn nanoseconds(&self) -> f64 {
        1e9 * self.seconds / (self.n as f64 * self.steps as f64)
    }
}

/// Times `steps` steps of size h of each method on each problem, one run after another.
///
/// # Errors
/// Invalid input, and the failure of a run, whose time would be meaningless.
pub fn run(
    problems: &[(Problem, u64)],
    methods: &[&'static Row],
    h: f64,
    progress: &dyn Progress,
) -> Result<Vec<CostRow>, IntegrateError> {
    let mut rows = Vec::new();
    for row in methods {
        for (problem, steps) in problems {
            let problem = Problem { end: h * *steps as f64, ..problem.clone() };
            let seconds =
                work_precision::time(&problem, row, Grid::new(h, problem.end)?.into(), progress)?
                    .as_secs_f64();
            rows.push(CostRow {
                method: row.name,
                n: problem.model.dof(),
                h,
                steps: *steps,
                seconds,
            });
            progress.advance();
        }
    }
    Ok(rows)
}
