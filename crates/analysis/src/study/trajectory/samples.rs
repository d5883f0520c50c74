//! States between the steps of a run.

use super::legs::{Keep, KeptState, Legs};
use super::{Balance, Steps, Trajectory, TrajectoryRow, steps_of_leg};
use crate::progress::{Piece, Progress};
use crate::study::Problem;
use crate::study::outcome::Ending;
use afterbay_core::{Grid, IntegrateError, RunError, State, StateRef, TakeStep, Tolerance};
use afterbay_methods::registry::Row;
use std::ops::ControlFlow;

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
        legs.sample(problem, row, steps, spacing, keep, progress)
    })
}

impl Legs {
    /// Computes the next leg of a run whose states are kept at the multiples of `spacing`, in the
    /// unit of time, as in [`dense`].
    ///
    /// # Errors
    /// As for [`dense`].
    pub fn sample(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        steps: Steps,
        spacing: f64,
        keep: Keep<'_>,
        progress: &dyn Progress,
    ) -> Result<(), IntegrateError> {
        let Some(state) = self.state.take() else { return Ok(()) };
        let (model, grid) = (&problem.model, Grid::<f64>::new(steps.h, problem.end)?);
        let (system, bound) = (model.system::<f64>()?, model.bind(row)?);
        let (begin, mut state) = (self.done, state.at(self.done as f64 * grid.h));
        let (dof, balance) = (model.degrees(), &mut self.balance);
        let mut keep = |n: u64, state: StateRef<'_, f64>, balance: &mut Balance| {
            balance.see(&*system, state, dof);
            keep(TrajectoryRow::of(row.name, n, state, &*system, model))
        };
        let mut stopped = begin == 0 && keep(0, state.state_ref(), balance).is_break();
        self.samples = self.samples.max(1);
        let times = Times { spacing, count: samples(problem.end, spacing) };
        let stepper = || bound.stepper(steps.tolerance.map(Tolerance::all), problem.end);
        // Two runs, so that the first goes on where its last step ended.
        let (mut step, mut step_to_sample) = (stepper()?, stepper()?);
        let end = grid.steps.min(begin.saturating_add(steps_of_leg(&state)));
        let (mut piece, mut result) = (Piece::new(progress), Ok(()));
        while self.done < end && !stopped {
            let (n, before) = (self.done + 1, state.clone());
            let mut advance = || -> Result<bool, IntegrateError> {
                step(grid.h, &mut state, &mut unwatched)?;
                (state.t, self.done) = (n as f64 * grid.h, n);
                piece.report(n, grid.steps);
                // In the order of time, since a rise of H is one from a state to a later one.
                let between = &mut |state: StateRef<'_, f64>| keep(n, state, balance);
                times.keep_between(
                    &before,
                    &state,
                    &mut self.samples,
                    &mut *step_to_sample,
                    between,
                )
            };
            match advance() {
                Ok(stops) => stopped |= stops,
                Err(error) => {
                    result = Err(of_step(n, before.t, error));
                    break;
                }
            }
            balance.see(&*system, state.state_ref(), dof);
            stopped |= progress.stopped();
        }
        if let Err(IntegrateError::Input(error)) = result {
            return Err(error.into());
        }
        if result.is_err() {
            // The run is over, whether or not the row can be written.
            let _ = keep(self.done, state.state_ref(), balance);
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

/// The error of step n, which begins at t.
fn of_step(n: u64, t: f64, error: IntegrateError) -> IntegrateError {
    match error {
        IntegrateError::Run(RunError { failure, .. }) => RunError { step: n, t, failure }.into(),
        error => error,
    }
}

/// The number of the last multiple of `spacing` up to `end`: 3 of 0.1 up to 0.3, though the
/// quotient of these numbers is below 3.
pub fn samples(end: f64, spacing: f64) -> u64 {
    (end / spacing * (1.0 + ROUNDED)) as u64
}

/// Lets the steps that a method chooses pass.
fn unwatched(_: StateRef<'_, f64>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The times of the states that are kept.
struct Times {
    spacing: f64,
    count: u64,
}

impl Times {
    /// Keeps the states between two steps, from that of number `next` on. Returns whether the run
    /// is to stop.
    ///
    /// # Errors
    /// The failure of a step to one of the states.
    fn keep_between(
        &self,
        before: &State<Vec<f64>>,
        after: &State<Vec<f64>>,
        next: &mut u64,
        step: TakeStep<'_>,
        keep: &mut dyn FnMut(StateRef<'_, f64>) -> ControlFlow<()>,
    ) -> Result<bool, IntegrateError> {
        while *next <= self.count {
            let t = *next as f64 * self.spacing;
            // The times of the steps are rounded.
            let (early, late) = (t - before.t, t - after.t);
            if late > ROUNDED * after.t {
                break;
            }
            let is_after = late.abs() <= ROUNDED * after.t;
            let mut there = if is_after { after.clone() } else { before.clone() };
            if there.t < after.t {
                step(early, &mut there, &mut unwatched)?;
            }
            there.t = t;
            *next += 1;
            if keep(there.state_ref()).is_break() {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_a_sample_where_it_is_a_multiple() {
        for (end, spacing, count) in
            [(0.3, 0.1, 3), (0.6, 0.2, 3), (0.7, 0.1, 7), (20.0, 0.3, 66), (0.9, 0.3, 3)]
        {
            assert_eq!(samples(end, spacing), count, "{end} by {spacing}");
        }
    }
}
