//! A run observed on its way, and one cell alone.

use super::measure::{Observations, Scales, Statistics, Workspace};
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::side::Side;
use afterbay_core::{Grid, InputError, IntegrateError, State, StepFailure, System};
use afterbay_methods::registry::Run;
use std::ops::ControlFlow;

/// The outcome of a run.
pub(super) struct Ending {
    pub(super) statistics: Statistics<f64>,
    pub(super) steps_done: u64,
    pub(super) failure: Option<StepFailure>,
}

/// The steps of a run, and those after which it is observed.
#[derive(Clone, Copy)]
pub(super) struct Schedule<'a> {
    pub(super) h: f64,
    pub(super) observations: &'a Observations,
    /// Whether w is checked after every step. Otherwise it is checked where the run is observed.
    pub(super) every_step: bool,
    pub(super) progress: &'a dyn Progress,
}

/// A run in progress.
#[derive(Clone)]
pub(super) struct ObservedRun<T: Side> {
    pub(super) state: State<Vec<T>>,
    pub(super) statistics: Statistics<T>,
}

/// A method, its system, and the scales by which its runs are measured.
pub(super) struct BoundMethod<'a, T: Side> {
    pub(super) run: &'a Run<T>,
    pub(super) system: &'a dyn System<T>,
    pub(super) scales: &'a Scales<T>,
}

/// A failed step, and the number of good steps before it.
pub(super) struct Broken {
    pub(super) good: u64,
    pub(super) failure: StepFailure,
}

impl<T: Side> BoundMethod<'_, T> {
    /// Takes the steps after `from` up to `to`, and observes the run where the schedule says.
    pub(super) fn advance(
        &self,
        schedule: Schedule<'_>,
        run: &mut ObservedRun<T>,
        from: u64,
        to: u64,
    ) -> Result<Option<Broken>, InputError> {
        let Schedule { h, observations, every_step, progress } = schedule;
        let ObservedRun { state, statistics } = run;
        let mut workspace = Workspace::new(state.dof(), &self.scales.track.image);
        let (mut at, mut ahead) = (from, observations.ahead(from));
        while at < to && !progress.stopped() {
            let (next, every) = stretch(observations, every_step, at, to);
            let outcome =
                self.run.run(Grid::<T>::of(h, next - at)?, state, every, &mut |since, state| {
                    let observation = if since > 0 { ahead.take(at + since) } else { None };
                    if since > 0 && (every_step || observation.is_some()) {
                        statistics.check_passivity(state.w);
                    }
                    if let Some(observation) = observation {
                        statistics.observe(
                            state,
                            observation,
                            self.scales,
                            self.system,
                            &mut workspace,
                        );
                        if progress.stopped() {
                            return ControlFlow::Break(());
                        }
                    }
                    ControlFlow::Continue(())
                });
            match outcome {
                Ok(_) => at = next,
                Err(IntegrateError::Input(error)) => return Err(error),
                Err(IntegrateError::Interrupted) => return Ok(None),
                Err(IntegrateError::Run(error)) => {
                    return Ok(Some(Broken { good: at + error.step - 1, failure: error.failure }));
                }
            }
        }
        Ok(None)
    }
}

/// The step up to which observations are equally spaced, and their spacing.
fn stretch(observations: &Observations, every_step: bool, at: u64, to: u64) -> (u64, u64) {
    let Observations { first, every, .. } = *observations;
    if every_step {
        return (to, 1);
    }
    if at < first {
        return (to.min(first), first - at);
    }
    let after = (at - first) % every;
    let whole = (to - at) / every * every;
    if after > 0 || whole == 0 {
        return (to.min(at + every - after), every - after);
    }
    (at + whole, every)
}

/// Runs one cell alone.
pub(super) fn alone(
    problem: &Problem,
    method: &BoundMethod<'_, f64>,
    schedule: Schedule<'_>,
) -> Result<Ending, InputError> {
    let state = problem.start::<f64>()?;
    let statistics = Statistics::nothing(state.dof(), &method.scales.track.image);
    let mut run = ObservedRun { state, statistics };
    let count = schedule.observations.count;
    let broken = method.advance(schedule, &mut run, 0, count)?;
    Ok(run.ended(count, broken))
}

impl ObservedRun<f64> {
    /// The ending of a run.
    pub(super) fn ended(self, count: u64, broken: Option<Broken>) -> Ending {
        let (steps_done, failure) =
            broken.map_or((count, None), |broken| (broken.good, Some(broken.failure)));
        Ending { statistics: self.statistics, steps_done, failure }
    }
}
