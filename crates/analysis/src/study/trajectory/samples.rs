//! States between the steps of a run.

use super::legs::{Keep, KeptState, Legs};
use super::{Trajectory, TrajectoryRow};
use crate::progress::{Piece, Progress};
use crate::study::Problem;
use crate::study::events::{SINGLE_STEPS, Steps};
use crate::study::outcome::Ending;
use afterbay_core::{Grid, IntegrateError, RunError, StateRef, Tolerance};
use afterbay_methods::registry::Row;

/// The largest difference of equal times, relative to them: some roundings.
const ROUNDED: f64 = 1e-13;

/// Runs a method with steps of size h and keeps the states at the times `0, spacing, 2 spacing,
/// ..`. A state between two steps is the end of a shorter step from the first of them, or of a run
/// within the tolerance: it has the accuracy of the method, and K is kept if the method keeps it.
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
    Trajectory::of_legs(Legs::new(problem, row)?, |legs, keep| {
        legs.sample(problem, row, (steps, spacing), keep, progress)
    })
}

impl Legs {
    /// Computes the next leg of a run whose states are kept as in [`dense`].
    ///
    /// # Errors
    /// As for [`dense`].
    pub fn sample(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        (steps, spacing): (Steps, f64),
        keep: Keep<'_>,
        progress: &dyn Progress,
    ) -> Result<(), IntegrateError> {
        let Some(state) = self.state.take() else { return Ok(()) };
        let grid = Grid::<f64>::new(steps.h, problem.end)?;
        let (model, count) = (&problem.model, (problem.end / spacing).floor() as u64);
        let (system, bound) = (model.system::<f64>()?, model.bind(row)?);
        let mut step = bound.stepper(Tolerance::all(steps.tolerance));
        let (begin, mut state) = (self.done, state.at(self.done as f64 * grid.h));
        let record = |n: u64, state: StateRef<'_, f64>| {
            TrajectoryRow::of(row.name, n, state, &*system, model)
        };
        let mut stopped = begin == 0 && keep(record(0, state.state_ref())).is_break();
        self.samples = self.samples.max(1);
        let leg = (SINGLE_STEPS / state.q.len() as u64).max(1);
        let end = grid.steps.min(begin.saturating_add(leg));
        let (mut piece, mut result) = (Piece::new(progress), Ok(()));
        while self.done < end && !stopped {
            let n = self.done + 1;
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
            (state.t, self.done) = (time, n);
            piece.reach(n, grid.steps);
            while self.samples <= count {
                let t = self.samples as f64 * spacing;
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
                stopped |= keep(record(n, there.state_ref())).is_break();
                self.samples += 1;
            }
            stopped |= progress.stopped();
        }
        if let Err(IntegrateError::Input(error)) = result {
            return Err(error.into());
        }
        if result.is_err() {
            // The run is over, whether or not the row can be written.
            let _ = keep(record(self.done, state.state_ref()));
        }
        self.ending = Ending::of(&result, grid.steps, self.done);
        if result.is_ok() && self.done == end && end < grid.steps && !stopped {
            self.state = Some(KeptState::of(state));
        } else {
            drop(piece);
            progress.advance();
        }
        Ok(())
    }
}
