//! Trajectories.

use super::events::Steps;
use super::outcome::Ending;
use super::{PUMPED, Problem, numbered};
use crate::Model;
use crate::progress::{Piece, Progress};
use afterbay_core::{
    Abilities, Accounts, Grid, IntegrateError, RunError, StateRef, Tolerance, accounts,
};
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
    /// The energy supplied by a drive; empty without one.
    pub s: Vec<f64>,
    /// The energy s_t pumped by V(q, t); empty where V and D do not depend on t.
    pub pumped: Vec<f64>,
    /// H
    pub energy: f64,
    /// K = H + Σ w - Σ s - s_t
    pub total: f64,
}

impl TrajectoryRow {
    /// A state of a run, without motors.
    pub(super) fn of(
        method: &'static str,
        step: u64,
        state: StateRef<'_, f64>,
        system: &dyn Abilities<f64>,
        model: &Model,
    ) -> Self {
        let n = model.degrees();
        let Accounts { w, s, pumped } = accounts(state, &model.motors());
        let supplied: f64 = state.p[n..].iter().sum();
        Self {
            method,
            step,
            t: state.t,
            q: state.q[..n].to_vec(),
            p: state.p[..n].to_vec(),
            w,
            s,
            pumped: pumped.into_iter().collect(),
            energy: state.energy(system) - supplied,
            total: state.total(system),
        }
    }
}

/// The names of the columns: `method,step,t,q1..qN,p1..pN,w1..wN,H,K`, with s1..sN behind w where
/// there is a drive, and st behind them where V or D depends on t.
pub fn columns(model: &Model) -> Vec<String> {
    let names = |list: &[&str]| list.iter().map(ToString::to_string).collect::<Vec<_>>();
    let pumped = model.has_clock().then(|| PUMPED.to_owned());
    let parts = model.variables().iter().flat_map(|name| numbered(name, model.degrees()));
    names(&["method", "step", "t"])
        .into_iter()
        .chain(parts)
        .chain(pumped)
        .chain(names(&["H", "K"]))
        .collect()
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
                rows.push(TrajectoryRow::of(row.name, step, state, &*system, &problem.model));
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
        let step = steps.get(n as usize).copied().unwrap_or(grid.steps);
        piece.reach(step, grid.steps);
        rows.push(TrajectoryRow::of(row.name, step, state, &*system, &problem.model));
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

/// Runs a method with steps of size h and keeps the states at the times `0, spacing, 2 spacing, ..`.
/// A state between two steps is the end of a shorter step from the first of them, or of a run within
/// the tolerance: it has the accuracy of the method, and K is kept if the method keeps it.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn dense(
    problem: &Problem,
    row: &'static Row,
    steps: Steps,
    spacing: f64,
    progress: &dyn Progress,
) -> Result<Trajectory, IntegrateError> {
    let grid = Grid::<f64>::new(steps.h, problem.end)?;
    let (model, count) = (&problem.model, (problem.end / spacing).floor() as u64);
    let (system, bound) = (model.system::<f64>()?, problem.model.bind(row)?);
    let mut step = bound.stepper(Tolerance::all(steps.tolerance));
    let mut state = problem.start()?;
    let mut rows = vec![TrajectoryRow::of(row.name, 0, state.state_ref(), &*system, model)];
    let (mut piece, mut result, mut done) = (Piece::new(progress), Ok(()), 0);
    for n in 1..=grid.steps {
        let (before, time) = (state.clone(), n as f64 * grid.h);
        if let Err(error) = step(grid.h, &mut state) {
            result = Err(match error {
                IntegrateError::Run(error) => {
                    RunError { step: n, t: before.t, failure: error.failure }.into()
                }
                error => error,
            });
            break;
        }
        (state.t, done) = (time, n);
        piece.reach(n, grid.steps);
        while rows.len() as u64 <= count {
            let t = rows.len() as f64 * spacing;
            // The times of the steps are rounded.
            let (early, late) = (t - before.t, t - time);
            if late > ROUNDED * time {
                break;
            }
            let mut there =
                if late.abs() <= ROUNDED * time { state.clone() } else { before.clone() };
            if there.t < time && step(early, &mut there).is_err() {
                break;
            }
            there.t = t;
            rows.push(TrajectoryRow::of(row.name, n, there.state_ref(), &*system, model));
        }
        if progress.stopped() {
            break;
        }
    }
    drop(piece);
    progress.advance();
    if let Err(IntegrateError::Input(error)) = result {
        return Err(error.into());
    }
    if result.is_err() {
        rows.push(TrajectoryRow::of(row.name, done, state.state_ref(), &*system, model));
    }
    Ok(Trajectory { method: row.name, rows, ending: Ending::of(&result, grid.steps, done) })
}

/// The largest difference of equal times, relative to them: some roundings.
const ROUNDED: f64 = 1e-13;
