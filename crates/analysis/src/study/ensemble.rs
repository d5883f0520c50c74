//! Runs of one method from section to section: eight side by side where the method can, else one by
//! one.
//!
//! A run that ends makes room for the next one. Where a step fails in one of eight runs, the rest
//! of the interval is taken run by run, so that each ends as it would alone. Results do not depend
//! on the number of threads: runs are grouped by index.

mod alone;
mod lanes;
mod standstill;

use super::outcome::{Ending, step_word};
use super::ranges::Ranges;
use super::section::Section;
use crate::Model;
use crate::progress::Progress;
use afterbay_core::{Grid, InputError, RunError, State, StateRef};
use afterbay_methods::registry::{Row, Run};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The runs of a group, which one thread takes.
pub(super) const GROUP: usize = 16;

/// One run.
pub(super) struct Member {
    /// The value of the parameter in which runs differ.
    pub(super) value: f64,
    pub(super) model: Model,
    pub(super) start: State<Vec<f64>>,
}

/// Receives the states of a run on the section.
pub(super) trait Watch: Send {
    /// Receives return number n, counted from 1, and the ranges of the motion since the return
    /// before. The time of the state is that since the start of the run; the motors of a drive are
    /// at the start of its period. `Break` ends the run.
    fn see(&mut self, n: u64, state: StateRef<'_, f64>, path: &Ranges) -> ControlFlow<()>;

    /// Receives the state after a step, if [`Watch::WANTS_STEPS`].
    fn step(&mut self, _state: StateRef<'_, f64>) {}

    /// Whether all steps are received. Runs are then taken one by one.
    const WANTS_STEPS: bool = false;
}

/// The properties that all runs of an ensemble share.
#[derive(Clone, Copy)]
pub(super) struct Ensemble<'a> {
    pub(super) row: &'static Row,
    /// The name of the parameter in which runs differ; empty if they differ in their starts only.
    pub(super) parameter: &'a str,
    pub(super) section: &'a Section,
    /// The step, nearly ([`Section::grid`]).
    pub(super) h: f64,
    pub(super) progress: &'a dyn Progress,
}

/// A run under way.
struct Job<W> {
    member: Member,
    run: Arc<Run<f64>>,
    /// The steps between two returns.
    grid: Grid<f64>,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
    state: State<Vec<f64>>,
    /// The time at the start of the interval, of which the state counts its own time.
    since: f64,
    /// The ranges since the last return.
    path: Ranges,
    returns: u64,
    watch: W,
    ending: Option<Ending>,
}

impl Ensemble<'_> {
    /// Runs each member until its watch ends it. A run that fails has its failure as its ending.
    ///
    /// # Errors
    /// Invalid input, such as a method that does not apply.
    pub(super) fn follow<W: Watch>(
        &self,
        members: Vec<(Member, W)>,
    ) -> Result<Vec<(W, Ending)>, InputError> {
        // Runs that differ in their starts only share one binding.
        let mut shared: Option<Arc<Run<f64>>> = None;
        let job = |(member, watch): (Member, W)| {
            let run = match shared.as_ref().filter(|_| self.parameter.is_empty()) {
                Some(run) => Arc::clone(run),
                None => Arc::new(member.model.bind(self.row)?),
            };
            shared = Some(Arc::clone(&run));
            let grid = self.section.grid_of(self.row, &member.model, self.h)?;
            let (mut state, dof) = (member.start.clone(), member.model.degrees());
            let (since, returns, ending) = (std::mem::take(&mut state.t), 0, None);
            let mut path = Ranges::nothing(dof);
            path.see(state.state_ref());
            Ok(Job { member, run, grid, dof, state, since, path, returns, watch, ending })
        };
        let mut jobs = members.into_iter().map(job).collect::<Result<Vec<_>, InputError>>()?;
        jobs.par_chunks_mut(GROUP).try_for_each(|group| {
            // Runs side by side take the same number of steps between two returns.
            for group in group.chunk_by_mut(|a, b| a.grid.steps == b.grid.steps) {
                if matches!(self.section, Section::Stroboscopic { .. }) && !W::WANTS_STEPS {
                    lanes::together(self, group)?;
                }
                for job in group.iter_mut().filter(|job| job.ending.is_none()) {
                    alone::run(self, job)?;
                }
                group.iter().for_each(|_| self.progress.advance());
            }
            Ok::<(), InputError>(())
        })?;
        let ended = |job: Job<W>| (job.watch, job.ending.unwrap_or_else(Ending::completed));
        Ok(jobs.into_iter().map(ended).collect())
    }
}

impl<W: Watch> Job<W> {
    /// Shows the state, which is on the section. The next interval begins there.
    fn arrive(&mut self, progress: &dyn Progress) {
        self.returns += 1;
        let t = self.since + self.state.t;
        let state = StateRef { t, ..self.state.state_ref() };
        self.path.see(state);
        let goes = self.watch.see(self.returns, state, &self.path);
        self.path.clear();
        self.path.see(state);
        if goes.is_break() {
            self.ending = Some(Ending::completed());
        } else if progress.stopped() {
            self.ending = Some(Ending::interrupted());
        }
    }

    /// Ends the run with the failure of a step.
    fn fail(&mut self, error: &RunError) {
        let t = self.since + error.t;
        let done = (t / self.grid.h).round() as u64;
        let error = RunError { step: done + 1, t, failure: error.failure };
        let failure = Some(error.to_string());
        self.ending = Some(Ending { outcome: step_word(&error.failure), failure });
    }
}
