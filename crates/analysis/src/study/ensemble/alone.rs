//! One run from section to section.

use super::standstill::Standstill;
use super::{Ending, Ensemble, Job, Watch};
use crate::study::section::{Crossing, MOST_STEPS_BETWEEN, Section, rewind};
use crate::study::zero::{at_zero, copy};
use afterbay_core::{Grid, InputError, IntegrateError, StateRef};
use std::ops::ControlFlow;

/// Runs until the watch ends it, or a step fails.
pub(super) fn run<W: Watch>(ensemble: &Ensemble<'_>, job: &mut Job<W>) -> Result<(), InputError> {
    match ensemble.section {
        Section::Stroboscopic { .. } => {
            while job.ending.is_none() {
                finish(job, 0)?;
                if job.ending.is_none() {
                    job.state.t = job.grid.h * job.grid.steps as f64;
                    job.arrive(ensemble.progress);
                    job.begin_interval();
                }
            }
            Ok(())
        }
        Section::Crossing(crossing) => cross(ensemble, job, crossing),
    }
}

/// Takes the steps of an interval after the first `done`.
pub(super) fn finish<W: Watch>(job: &mut Job<W>, done: u64) -> Result<(), InputError> {
    let grid = Grid { steps: job.grid.steps - done, ..job.grid };
    let Job { run, state, path, watch, .. } = job;
    let outcome = run.run(grid, state, 1, &mut |step, state| {
        if step > 0 && W::WANTS_STEPS {
            watch.step(state);
        }
        path.see(state);
        ControlFlow::Continue(())
    });
    job.take_failure(outcome)
}

impl<W: Watch> Job<W> {
    /// Ends the run if its steps have failed.
    fn take_failure<R>(&mut self, outcome: Result<R, IntegrateError>) -> Result<(), InputError> {
        match outcome {
            Err(IntegrateError::Input(error)) => return Err(error),
            Err(IntegrateError::Run(error)) => self.fail(&error),
            Err(IntegrateError::Interrupted) | Ok(_) => {}
        }
        Ok(())
    }

    /// Begins the next interval of a stroboscopic section.
    pub(super) fn begin_interval(&mut self) {
        self.since += self.state.t;
        rewind(&mut self.state.q, &mut self.state.t, self.dof);
    }
}

/// Runs from crossing to crossing. At rest, the states after all further steps count as returns.
fn cross<W: Watch>(
    ensemble: &Ensemble<'_>,
    job: &mut Job<W>,
    crossing: &Crossing,
) -> Result<(), InputError> {
    let Job { member, run, grid, state, path, returns, watch, .. } = job;
    let period = member.model.periods().get(crossing.dof).copied().flatten();
    let mut before = state.clone();
    let mut off = crossing.distance(before.state_ref(), period);
    let (mut ending, mut missing) = (None, 0);
    let (mut standstill, mut rests) = (Standstill::new(&member.model), false);
    let outcome = loop {
        let outcome = run.run(*grid, state, 1, &mut |step, now| {
            if step == 0 {
                return ControlFlow::Continue(());
            }
            if W::WANTS_STEPS {
                watch.step(now);
            }
            let (last, h) = (std::mem::replace(&mut off, crossing.distance(now, period)), grid.h);
            missing += 1;
            rests = rests || standstill.is_seen(missing, now, path);
            let meets = crossing.between(last, off, period);
            if meets || rests {
                let distance = |state: StateRef<'_, f64>| crossing.distance(state, period);
                let mut there = before.clone();
                if meets {
                    there = at_zero(run, h, distance, &before, now);
                } else {
                    copy(now, &mut there);
                }
                (*returns, missing) = (*returns + 1, 0);
                path.see(there.state_ref());
                if watch.see(*returns, there.state_ref(), path).is_break() {
                    ending = Some(Ending::completed());
                }
                path.clear();
                path.see(there.state_ref());
            }
            path.see(now);
            if missing > MOST_STEPS_BETWEEN {
                ending = Some(not_met(now.t - h * missing as f64));
            } else if missing % STEPS_BETWEEN_LOOKS == 0 && ensemble.progress.stopped() {
                ending = Some(Ending::interrupted());
            }
            copy(now, &mut before);
            if ending.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if ending.is_some() || outcome.is_err() {
            break outcome;
        }
    };
    job.ending = ending;
    job.take_failure(outcome)
}

/// The ending of a run that has not met its section since the time `since`.
fn not_met(since: f64) -> Ending {
    let failure = format!(
        "the section is not met within {MOST_STEPS_BETWEEN} steps after t = {since}: the motion \
         does not pass it in this direction, or creeps towards a rest; take another section"
    );
    Ending { outcome: NOT_MET, failure: Some(failure) }
}

/// The word of a run that does not return to its section.
const NOT_MET: &str = "no-return";
/// Steps between two looks at whether the user wants to stop.
const STEPS_BETWEEN_LOOKS: u64 = 1024;
