//! A run observed on its way, and one cell alone.

use super::measure::{Looks, Room, Scales, Seen};
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::side::Side;
use afterbay_core::{Grid, InputError, IntegrateError, State, StepFailure, System};
use afterbay_methods::registry::Run;
use std::ops::ControlFlow;

/// The outcome of a run.
pub(super) struct Ending {
    pub(super) seen: Seen<f64>,
    pub(super) steps_done: u64,
    pub(super) failure: Option<StepFailure>,
}

/// The steps of a run, and those after which it is observed.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    pub(super) h: f64,
    pub(super) looks: &'a Looks,
    /// Whether w is checked after every step. Otherwise it is checked where the run is observed.
    pub(super) watched: bool,
    pub(super) progress: &'a dyn Progress,
}

/// A run in progress.
#[derive(Clone)]
pub(super) struct Traveller<T: Side> {
    pub(super) state: State<Vec<T>>,
    pub(super) seen: Seen<T>,
}

/// A method, its system, and the scales by which its runs are measured.
pub(super) struct Vehicle<'a, T: Side> {
    pub(super) run: &'a Run<T>,
    pub(super) system: &'a dyn System<T>,
    pub(super) scales: &'a Scales<T>,
}

/// A failed step, and the number of good steps before it.
pub(super) struct Broken {
    pub(super) good: u64,
    pub(super) failure: StepFailure,
}

impl<T: Side> Vehicle<'_, T> {
    /// Takes the steps after `from` up to `to`, and observes the run where the course says.
    pub(super) fn carry(
        &self,
        course: Course<'_>,
        traveller: &mut Traveller<T>,
        from: u64,
        to: u64,
    ) -> Result<Option<Broken>, InputError> {
        let Course { h, looks, watched, progress } = course;
        let Traveller { state, seen } = traveller;
        let mut room = Room::new(state.dof(), &self.scales.track.image);
        let mut at = from;
        while at < to && !progress.stopped() {
            let (next, every) = stretch(looks, watched, at, to);
            let outcome =
                self.run.run(Grid::<T>::of(h, next - at)?, state, every, &mut |since, state| {
                    let look = if since > 0 { looks.after(at + since) } else { None };
                    if since > 0 && (watched || look.is_some()) {
                        seen.watch(state.w);
                    }
                    if let Some(look) = look {
                        seen.look(state, look, self.scales, self.system, &mut room);
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
fn stretch(looks: &Looks, watched: bool, at: u64, to: u64) -> (u64, u64) {
    let Looks { first, every, .. } = *looks;
    if watched {
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
    vehicle: &Vehicle<'_, f64>,
    course: Course<'_>,
) -> Result<Ending, InputError> {
    let state = problem.start::<f64>()?;
    let seen = Seen::nothing(state.dof(), &vehicle.scales.track.image);
    let mut traveller = Traveller { state, seen };
    let count = course.looks.count;
    let broken = vehicle.carry(course, &mut traveller, 0, count)?;
    Ok(traveller.ended(count, broken))
}

impl Traveller<f64> {
    /// The ending of a run.
    pub(super) fn ended(self, count: u64, broken: Option<Broken>) -> Ending {
        let (steps_done, failure) =
            broken.map_or((count, None), |broken| (broken.good, Some(broken.failure)));
        Ending { seen: self.seen, steps_done, failure }
    }
}
