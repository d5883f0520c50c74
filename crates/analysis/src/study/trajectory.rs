//! Trajectories.

use super::outcome::Ending;
use super::{Problem, numbered};
use crate::progress::{Piece, Progress};
use afterbay_core::{Grid, IntegrateError, StateRef, Tolerance};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// A row of `trajectory.csv`, under the [`columns`].
#[derive(Clone, Debug, Serialize)]
pub struct TrajectoryRow {
    /// Name of the method.
    pub method: &'static str,
    /// Steps done.
    pub step: u64,
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Momenta.
    pub p: Vec<f64>,
    /// Reservoir.
    pub w: Vec<f64>,
    /// H(q, p)
    pub energy: f64,
    /// K = H + Σ w
    pub total: f64,
}

/// The names of the columns: `method,step,t,q1..qN,p1..pN,w1..wN,H,K`.
pub fn columns(dof: usize) -> Vec<String> {
    let names = |list: &[&str]| list.iter().map(ToString::to_string).collect::<Vec<_>>();
    let parts = ["q", "p", "w"].into_iter().flat_map(|name| numbered(name, dof));
    names(&["method", "step", "t"]).into_iter().chain(parts).chain(names(&["H", "K"])).collect()
}

/// One run.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Name of the method.
    pub method: &'static str,
    /// Every `every`-th state, and the last good one.
    pub rows: Vec<TrajectoryRow>,
    /// How the run ended.
    pub ending: Ending,
}

/// The most steps, times degrees of freedom, between two checks whether to stop.
const ASKED: u64 = 4096;

/// Runs each method with steps of size h and keeps every `every`-th state.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    h: f64,
    every: u64,
    progress: &dyn Progress,
) -> Result<Vec<Trajectory>, IntegrateError> {
    let grid = Grid::<f64>::new(h, problem.end)?;
    methods
        .par_iter()
        .map(|row| {
            let system = problem.model.system::<f64>()?;
            let (mut rows, every) = (Vec::new(), every.max(1));
            let mut record = |step: u64, state: StateRef<'_, f64>| {
                let [q, p, w] = [state.q, state.p, state.w].map(<[f64]>::to_vec);
                let (energy, total) = (state.energy(&*system), state.total(&*system));
                rows.push(TrajectoryRow {
                    method: row.name,
                    step,
                    t: state.t,
                    q,
                    p,
                    w,
                    energy,
                    total,
                });
            };
            let (mut state, mut done, mut recorded) = (problem.start()?, 0, 0);
            let mut piece = Piece::new(progress);
            let stride = if every <= ASKED / state.q.len() as u64 { every } else { 1 };
            let result =
                problem.model.bind(row)?.run(grid, &mut state, stride, &mut |step, state| {
                    done = step;
                    piece.reach(step, grid.steps);
                    if step % every == 0 {
                        record(step, state);
                        recorded = step;
                    }
                    if progress.stopped() {
                        ControlFlow::Break(())
                    } else {
                        ControlFlow::Continue(())
                    }
                });
            drop(piece);
            progress.advance();
            let last = match &result {
                Ok(_) if progress.stopped() => done,
                Ok(_) => grid.steps,
                Err(IntegrateError::Run(error)) => error.step - 1,
                Err(IntegrateError::Input(_) | IntegrateError::Interrupted) => 0,
            };
            if last != recorded {
                record(last, state.state_ref());
            }
            Ok(Trajectory { method: row.name, rows, ending: Ending::of(&result, grid.steps, last) })
        })
        .collect()
}

/// Runs a method that chooses its steps, and keeps the states at the times of every `every`-th step
/// of size h. K is exact at these times too.
///
/// # Errors
/// Invalid input.
pub fn sampled(
    problem: &Problem,
    row: &'static Row,
    tolerance: f64,
    h: f64,
    every: u64,
    progress: &dyn Progress,
) -> Result<Trajectory, IntegrateError> {
    let (grid, every) = (Grid::<f64>::new(h, problem.end)?, every.max(1));
    let system = problem.model.system::<f64>()?;
    let last = (grid.steps % every != 0).then_some(grid.steps);
    let steps: Vec<u64> = (0..=grid.steps / every).map(|n| n * every).chain(last).collect();
    let times: Vec<f64> = steps.iter().map(|&step| step as f64 * h).collect();
    let (mut rows, mut state) = (Vec::new(), problem.start()?);
    let (run, mut piece) = (problem.model.bind(row)?, Piece::new(progress));
    let result = run.sample(&Tolerance::all(tolerance), &times, &mut state, &mut |n, state| {
        let [q, p, w] = [state.q, state.p, state.w].map(<[f64]>::to_vec);
        let (energy, total) = (state.energy(&*system), state.total(&*system));
        let step = steps.get(n as usize).copied().unwrap_or(grid.steps);
        piece.reach(step, grid.steps);
        rows.push(TrajectoryRow { method: row.name, step, t: state.t, q, p, w, energy, total });
        if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    drop(piece);
    progress.advance();
    if let Err(IntegrateError::Input(error)) = result {
        return Err(error.into());
    }
    let done = rows.last().map_or(0, |row| row.step);
    Ok(Trajectory { method: row.name, rows, ending: Ending::of(&result, grid.steps, done) })
}
