//! Errors and energy balance as the number of degrees of freedom grows.

use super::{Problem, work_precision};
use crate::progress::Progress;
use afterbay_core::{Grid, IntegrateError};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;

/// A row of `size.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct SizeRow {
    /// Name of the method.
    pub method: &'static str,
    /// Degrees of freedom.
    pub n: usize,
    /// The step.
    pub h: f64,
    /// The outcome of the run.
    pub outcome: &'static str,
    /// H at t = 0.
    pub initial_energy: f64,
    /// The largest error of q and p over the degrees of freedom at the end; none if the run did not
    /// reach it.
    pub error_qp: Option<f64>,
    /// The largest error of w.
    pub error_w: Option<f64>,
    /// max |K - K0| over all steps done.
    pub k_drift: f64,
    /// Steps that violate passivity; none where the system is not known to be passive.
    pub passivity_violations: Option<u64>,
    /// The doubt of q and p of the reference.
    pub doubt_qp: f64,
    /// The doubt of w of the reference.
    pub doubt_w: f64,
}

/// Runs each method with steps of size h on each problem.
///
/// # Errors
/// Invalid input. The row of a run that fails contains its ending.
pub fn run(
    problems: &[Problem],
    methods: &[&'static Row],
    h: f64,
    progress: &dyn Progress,
) -> Result<Vec<SizeRow>, IntegrateError> {
    let by_problem = problems
        .par_iter()
        .map(|problem| {
            let exact = problem.solution(problem.end, 1, progress)?;
            let system = problem.model.system::<f64>()?;
            let initial_energy = problem.start()?.energy(&*system);
            let rows = methods.iter().map(|row| {
                let found = work_precision::errors(
                    problem,
                    row,
                    Grid::new(h, problem.end)?.into(),
                    &exact,
                    progress,
                )?;
                progress.advance();
                Ok(SizeRow {
                    method: row.name,
                    n: problem.model.dof(),
                    h,
                    outcome: found.outcome,
                    initial_energy,
                    error_qp: found.error_qp,
                    error_w: found.error_w,
                    k_drift: found.k_drift,
                    passivity_violations: found.passivity_violations,
                    doubt_qp: found.doubt_qp,
                    doubt_w: found.doubt_w,
                })
            });
            rows.collect::<Result<Vec<_>, IntegrateError>>()
        })
        .collect::<Result<Vec<_>, _>>()?;
    let of_method = |i: usize| by_problem.iter().filter_map(move |rows| rows.get(i)).cloned();
    Ok((0..methods.len()).flat_map(of_method).collect())
}
