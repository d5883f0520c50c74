//! Global errors and the order they show.

use super::{Problem, VARIABLES, distance};
use crate::Solution;
use crate::progress::Progress;
use afterbay_core::{Grid, IntegrateError};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// A row of `global_orders.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct GlobalRow {
    /// Name of the method.
    pub method: &'static str,
    /// q, p or w.
    pub variable: &'static str,
    /// The step.
    pub h: f64,
    /// max |x - x(t)| over the run and over the degrees of freedom; none if it did not reach its end.
    pub error: Option<f64>,
    /// log(error/error before) / log(h/h before), against the step before it.
    pub order: Option<f64>,
}

/// Global errors of each method at each of the `steps`, in the order given.
///
/// # Errors
/// Those of the input. A run that fails leaves its errors empty.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    steps: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<GlobalRow>, IntegrateError> {
    let solutions = steps
        .par_iter()
        .map(|&h| problem.solution(h, Grid::<f64>::new(h, problem.end)?.steps as usize))
        .collect::<Result<Vec<_>, _>>()?;
    let tasks: Vec<_> = methods
        .iter()
        .flat_map(|&row| steps.iter().zip(&solutions).map(move |(&h, solution)| (row, h, solution)))
        .collect();
    let errors = tasks
        .par_iter()
        .map(|(row, h, solution)| {
            let error = largest_error(problem, row, *h, solution);
            progress.advance();
            error
        })
        .collect::<Result<Vec<_>, _>>()?;

    let mut rows = Vec::new();
    for (method, errors) in methods.iter().zip(errors.chunks(steps.len().max(1))) {
        for (variable, name) in VARIABLES.into_iter().enumerate() {
            let mut before: Option<(f64, f64)> = None;
            for (&h, error) in steps.iter().zip(errors) {
                let error = error.map(|error| error[variable]);
                let order = before.zip(error).map(|((h0, e0), e)| (e / e0).ln() / (h / h0).ln());
                rows.push(GlobalRow {
                    method: method.name,
                    variable: name,
                    h,
                    error,
                    order: order.filter(|order| order.is_finite()),
                });
                before = error.map(|error| (h, error));
            }
        }
    }
    Ok(rows)
}

fn largest_error(
    problem: &Problem,
    row: &Row,
    h: f64,
    solution: &Solution<f64>,
) -> Result<Option<[f64; 3]>, IntegrateError> {
    let method = problem.model.subject::<f64>()?.bind(row)?;
    let mut state = problem.start()?;
    let mut largest = [0.0_f64; 3];
    let result = method.run(Grid::new(h, problem.end)?, &mut state, 1, &mut |step, state| {
        for (largest, now) in largest.iter_mut().zip(distance(state, solution.at(step as usize))) {
            *largest = largest.max(now);
        }
        ControlFlow::Continue(())
    });
    Ok(result.is_ok().then_some(largest))
}
