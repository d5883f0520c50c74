//! What accuracy costs: errors against time and evaluations.

use super::outcome::{COMPLETED, Ending};
use super::passivity::Passivity;
use super::{Problem, distance};
use crate::Solution;
use crate::progress::Progress;
use crate::record::RunOutcome;
use afterbay_core::{Effort, Grid, IntegrateError};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// A row of `work_precision.csv`. The three figures of a run stand side by side: the error of (q, p), the error of w,
/// and the drift of K, which says nothing of the other two.
#[derive(Clone, Debug, Serialize)]
pub struct WorkRow {
    /// Name of the method.
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// How the run ended.
    pub outcome: &'static str,
    /// max(|Δq|, |Δp|) over the degrees of freedom at the end; none if the run did not reach it.
    pub error_qp: Option<f64>,
    /// max |Δw| at the end.
    pub error_w: Option<f64>,
    /// max |K - K0| over all steps done.
    pub k_drift: f64,
    /// Times Δw_j < 0 where Δw_j ≥ 0 is owed, step by step and degree of freedom by degree of freedom (in the sum over
    /// them where it is owed in sum); none where nothing is owed.
    pub passivity_violations: Option<u64>,
    /// Wall-clock time of the run alone.
    pub seconds: Option<f64>,
    /// Steps done.
    pub steps: u64,
    /// Evaluations of the force.
    pub evaluations: Option<u64>,
    /// Iterations of a nonlinear solver.
    pub iterations: Option<u64>,
    /// What went wrong, in words.
    pub failure: Option<String>,
    /// How far two computations of the reference are apart; 0 where it is known to rounding.
    pub reference_doubt: f64,
}

impl WorkRow {
    /// How the run ended, for the record.
    pub fn record(&self, system: &'static str) -> RunOutcome {
        let ending = Ending { outcome: self.outcome, failure: self.failure.clone() };
        ending.record("work-precision", system, self.method, self.h)
    }
}

/// Runs each method at each step: errors in parallel, then times one after the other.
///
/// # Errors
/// Those of the input. A run that fails keeps its row.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    steps: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<WorkRow>, IntegrateError> {
    let exact = problem.solution(problem.end, 1)?;
    let tasks: Vec<_> = methods.iter().flat_map(|&row| steps.iter().map(move |&h| (row, h))).collect();
    let mut rows = tasks
        .par_iter()
        .map(|&(row, h)| {
            let errors = errors(problem, row, h, &exact, progress);
            progress.advance();
            errors
        })
        .collect::<Result<Vec<_>, _>>()?;
    for (row, (method, h)) in rows.iter_mut().zip(tasks) {
        if row.outcome == COMPLETED && !progress.stopped() {
            row.seconds = Some(time(problem, method, h)?.as_secs_f64());
        }
        progress.advance();
    }
    Ok(rows)
}

/// The row of one run, its time not taken; `exact` begins with the start and the end.
pub(super) fn errors(
    problem: &Problem,
    row: &'static Row,
    h: f64,
    exact: &Solution<f64>,
    progress: &dyn Progress,
) -> Result<WorkRow, IntegrateError> {
    let subject = problem.model.subject::<f64>()?;
    let method = problem.model.bind(row)?;
    let mut state = problem.start()?;
    let total = state.total(&*subject);
    let (mut drift, mut steps) = (0.0_f64, 0);
    let mut passivity = Passivity::new(subject.damping().passive, &state.w);
    let grid = Grid::new(h, problem.end)?;
    let result = method.run(grid, &mut state, 1, &mut |step, state| {
        drift = drift.max((state.total(&*subject) - total).abs());
        passivity.see(state.w);
        steps = step;
        if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let Ending { outcome, failure } = Ending::of(&result, grid.steps, steps);
    let effort: Option<Effort> = result.ok().filter(|_| outcome == COMPLETED);
    let off = effort.map(|_| distance(state.view(), exact.at(1)));
    Ok(WorkRow {
        method: row.name,
        h,
        outcome,
        error_qp: off.map(|[q, p, _]| q.max(p)),
        error_w: off.map(|[.., w]| w),
        k_drift: drift,
        passivity_violations: passivity.violations(),
        seconds: None,
        steps,
        evaluations: effort.map(|effort| effort.evaluations),
        iterations: effort.map(|effort| effort.iterations),
        failure,
        reference_doubt: exact.doubt,
    })
}

/// Runs are repeated until they took this long together, and the fastest counts: what disturbs a run only slows it.
const LONG_ENOUGH: Duration = Duration::from_millis(3);
/// ... and at least this often.
const REPEATS: u32 = 3;

/// The fastest of several runs.
pub(super) fn time(problem: &Problem, row: &Row, h: f64) -> Result<Duration, IntegrateError> {
    let method = problem.model.bind(row)?;
    let grid = Grid::new(h, problem.end)?;
    let start = problem.start()?;
    let (mut best, mut all, mut repeats) = (Duration::MAX, Duration::ZERO, 0);
    while repeats < REPEATS || all < LONG_ENOUGH {
        let mut state = start.clone();
        let clock = Instant::now();
        method.run(grid, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(()))?;
        let elapsed = clock.elapsed();
        best = best.min(elapsed);
        all += elapsed;
        repeats += 1;
    }
    Ok(best)
}
