//! A run in legs. A run that was stopped continues at the end of its last leg.

use super::{Balance, Steps, TrajectoryRow};
use crate::progress::{Piece, Progress};
use crate::study::Problem;
use crate::study::outcome::Ending;
use crate::words::{Word, word as read_word};
use afterbay_core::{
    Grid, InputError, IntegrateError, RunError, STEPS_OF_BLOCK, State, StateRef, Tolerance,
};
use afterbay_methods::registry::{Part, Row};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// The steps of a leg, times degrees of freedom. A choice: a leg takes from a hundredth of a second
/// to some seconds, and what its start costs is small beside that.
const LEG: u64 = 1 << 20;
const _: () = assert!(LEG.is_multiple_of(STEPS_OF_BLOCK), "w then does not depend on the legs");

/// Receives the states that are kept. `Break` ends the run.
pub type Keep<'a> = &'a mut dyn FnMut(TrajectoryRow) -> ControlFlow<()>;

/// A run in legs. Each leg begins with a fresh workspace, so that its results are the same to the
/// bit in one command and in several.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Legs {
    /// Name of the method.
    #[serde(deserialize_with = "read_word")]
    pub method: Word,
    /// K and H of the states so far.
    pub balance: Balance,
    /// The ending of the run; `interrupted` while legs of it are left.
    pub ending: Ending,
    /// The steps of size h done.
    pub(in crate::study) done: u64,
    /// The state there; none once the run has ended.
    pub(in crate::study) state: Option<KeptState>,
    /// The states at given times so far.
    pub(super) samples: u64,
}

/// A state of a run, with the motors of a drive.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::study) struct KeptState {
    pub(in crate::study) q: Vec<f64>,
    pub(in crate::study) p: Vec<f64>,
    pub(in crate::study) w: Vec<f64>,
    /// The part of w below its rounding ([`Part::remainder`]).
    pub(in crate::study) remainder: Vec<f64>,
}

impl KeptState {
    /// A state whose w is rounded at each step.
    pub(in crate::study) fn of(State { q, p, w, .. }: State<Vec<f64>>) -> Self {
        let remainder = vec![0.0; w.len()];
        Self { q, p, w, remainder }
    }

    /// The state at a time.
    pub(in crate::study) fn at(self, t: f64) -> State<Vec<f64>> {
        State { q: self.q, p: self.p, w: self.w, t }
    }
}

impl Legs {
    /// A run before its first leg.
    ///
    /// # Errors
    /// A start that does not fit the system.
    pub fn new(problem: &Problem, row: &'static Row) -> Result<Self, IntegrateError> {
        let state = Some(KeptState::of(problem.start()?));
        let (balance, ending) = (Balance::default(), Ending::interrupted());
        Ok(Self { method: row.name, balance, ending, done: 0, state, samples: 0 })
    }

    /// Whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.state.is_none()
    }

    /// The steps of size h done.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Computes the next leg: with steps of size h, or within the tolerance of a method that
    /// chooses its steps. Every `every`-th state of the grid of h is kept.
    ///
    /// # Errors
    /// Invalid input. The trajectory of a run that fails ends with its last good state.
    pub fn advance(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        Steps { h, every, tolerance }: Steps,
        keep: Keep<'_>,
        progress: &dyn Progress,
    ) -> Result<(), IntegrateError> {
        let Some(KeptState { q, p, w, mut remainder }) = self.state.take() else { return Ok(()) };
        let (grid, every) = (Grid::<f64>::new(h, problem.end)?, every.max(1));
        let steps = LEG / q.len() as u64;
        let mut state = State { q, p, w, t: self.done as f64 * h };
        let until = |steps| grid.steps.min(self.done.saturating_add(steps));
        let (result, end) = if row.is_adaptive() {
            let end = until((steps / every).max(1).saturating_mul(every));
            let leg = LegSteps { grid, every, end, tolerance };
            (self.within(problem, row, leg, &mut state, keep, progress)?, end)
        } else {
            // Whole blocks of steps, so that w does not depend on the legs.
            let end = until((steps / STEPS_OF_BLOCK).max(1) * STEPS_OF_BLOCK);
            let leg = LegSteps { grid, every, end, tolerance };
            let state = WithRemainder { state: &mut state, remainder: &mut remainder };
            (self.by_steps(problem, row, leg, state, keep, progress)?, end)
        };
        self.ending = Ending::of(&result, grid.steps, self.done);
        if result.is_ok() && self.done == end && end < grid.steps {
            let State { q, p, w, .. } = state;
            self.state = Some(KeptState { q, p, w, remainder });
        } else {
            progress.advance();
        }
        Ok(())
    }

    /// A leg of a method with a fixed step.
    fn by_steps(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        LegSteps { grid, every, end, .. }: LegSteps,
        WithRemainder { state, remainder }: WithRemainder<'_>,
        keep: Keep<'_>,
        progress: &dyn Progress,
    ) -> Result<Result<(), IntegrateError>, IntegrateError> {
        let system = problem.model.system::<f64>()?;
        let begin = self.done;
        let mut record = |step: u64, state: StateRef<'_, f64>| {
            // The times are those of one grid, whatever the legs.
            let state = StateRef { t: step as f64 * grid.h, ..state };
            keep(TrajectoryRow::of(row.name, step, state, &*system, &problem.model))
        };
        let (mut done, mut recorded, mut piece) = (begin, begin, Piece::new(progress));
        let mut stopped = false;
        let (n, balance) = (problem.model.degrees(), &mut self.balance);
        let rest = Grid { steps: end - begin, ..grid };
        let part = Part { grid: rest, first: 0, stride: 1, remainder };
        let result = problem.model.bind(row)?.run_part(part, state, &mut |step, state| {
            done = begin + step;
            piece.report(done, grid.steps);
            balance.see(&*system, state, n);
            if done % every == 0 && (done > begin || begin == 0) {
                stopped = record(done, state).is_break();
                recorded = done;
            }
            stopped |= progress.stopped();
            if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let result = result.map(drop).map_err(|error| of_run(begin, error));
        self.done = match &result {
            Ok(()) if stopped => done,
            Ok(()) => end,
            Err(IntegrateError::Run(error)) => error.step - 1,
            Err(IntegrateError::Input(_) | IntegrateError::Interrupted) => begin,
        };
        let ends = result.is_err() || self.done < end || end == grid.steps;
        if ends && self.done != recorded {
            // The run is over, whether or not the row can be written.
            let _ = record(self.done, state.state_ref());
        }
        Ok(result)
    }

    /// A leg of a method that chooses its steps. It keeps the states at the times of every
    /// `every`-th step of size h, where K is exact too. The balance is that of these states.
    fn within(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        LegSteps { grid, every, end, tolerance }: LegSteps,
        state: &mut State<Vec<f64>>,
        keep: Keep<'_>,
        progress: &dyn Progress,
    ) -> Result<Result<(), IntegrateError>, IntegrateError> {
        let why = "it takes a tolerance, not a step";
        let tolerance = tolerance.ok_or(InputError::Unsupported { method: row.name, why })?;
        let system = problem.model.system::<f64>()?;
        let begin = self.done;
        let last = (!end.is_multiple_of(every)).then_some(end);
        let steps: Vec<u64> =
            (begin / every..=end / every).map(|n| n * every).chain(last).collect();
        let times: Vec<f64> = steps.iter().map(|&step| step as f64 * grid.h).collect();
        let (run, mut piece) = (problem.model.bind(row)?, Piece::new(progress));
        let (n, balance, mut done) = (problem.model.degrees(), &mut self.balance, begin);
        let mut look = |i: u64, state: StateRef<'_, f64>| {
            done = steps.get(i as usize).copied().unwrap_or(end);
            piece.report(done, grid.steps);
            balance.see(&*system, state, n);
            let kept = match done > begin || begin == 0 {
                true => keep(TrajectoryRow::of(row.name, done, state, &*system, &problem.model)),
                false => ControlFlow::Continue(()),
            };
            if kept.is_break() { kept } else { progress.flow() }
        };
        let mut stops = || progress.stopped();
        let all = Tolerance::all(tolerance);
        let result = run.sample(&all, &times, state, &mut look, &mut stops);
        self.done = done;
        if result.is_err() && state.t > done as f64 * grid.h {
            // The last good state. The run is over, whether or not the row can be written.
            let state = state.state_ref();
            balance.see(&*system, state, n);
            let _ = keep(TrajectoryRow::of(row.name, done, state, &*system, &problem.model));
        }
        match result {
            Err(IntegrateError::Input(error)) => Err(error.into()),
            result => Ok(result.map(drop)),
        }
    }
}

/// The error of a leg that begins after `begin` steps. Its step is counted from the start of the
/// run.
pub(in crate::study) fn of_run(begin: u64, error: IntegrateError) -> IntegrateError {
    match error {
        IntegrateError::Run(RunError { step, t, failure }) => {
            RunError { step: begin + step, t, failure }.into()
        }
        error => error,
    }
}

/// The steps of a leg: up to `end` on the grid of the run.
#[derive(Clone, Copy)]
struct LegSteps {
    grid: Grid<f64>,
    every: u64,
    end: u64,
    /// The relative tolerance, for a method that chooses its steps.
    tolerance: Option<f64>,
}

/// A state, and the part of w below its rounding ([`Part::remainder`]).
struct WithRemainder<'a> {
    state: &'a mut State<Vec<f64>>,
    remainder: &'a mut [f64],
}
