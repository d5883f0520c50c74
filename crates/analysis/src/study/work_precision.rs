//! Work against precision: errors against time and evaluations.

use super::Problem;
use super::cell::{Cell, Study, compute_all};
use super::kept::LargestEnergy;
use super::outcome::{COMPLETED, Ending};
use super::watch::Watch;
use crate::progress::Progress;
use crate::words::{Word, word};
use crate::{Measured, Solution};
use afterbay_core::{
    Abilities, Effort, Grid, InputError, IntegrateError, State, StateRef, Statistics, Tolerance,
};
use afterbay_methods::registry::{Row, Setting};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A row of `work_precision.csv`. It holds three separate measures of a run: the error of (q, p),
/// the error of w, and the drift of K, which says nothing about the other two.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WorkRow {
    /// Name of the method.
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// The outcome of the run.
    #[serde(deserialize_with = "word")]
    pub outcome: Word,
    /// max(|Δq|, |Δp|) over the degrees of freedom at the end; none if the run did not reach it.
    pub error_qp: Option<f64>,
    /// max |Δw| at the end.
    pub error_w: Option<f64>,
    /// max |K - K0| over all steps done.
    pub k_drift: f64,
    /// Steps that violate passivity ([`Passive::violated`](afterbay_core::Passive::violated)); none
    /// where the system is not known to be passive.
    pub passivity_violations: Option<u64>,
    /// Wall-clock time of the run alone.
    pub seconds: Option<f64>,
    /// Steps done.
    pub steps: u64,
    /// Evaluations of the force.
    pub evaluations: Option<u64>,
    /// Iterations of a nonlinear solver.
    pub iterations: Option<u64>,
    /// The failure in words.
    pub failure: Option<String>,
    /// The doubt of q and p of the reference.
    pub doubt_qp: f64,
    /// The doubt of w of the reference.
    pub doubt_w: f64,
    /// The relative and absolute tolerance of q, p and w, where steps follow from it; `h` is then
    /// the mean step.
    pub tolerance: Option<f64>,
    /// max |K - K0| as a share of the largest energy of the run: the largest |H| + Σ |w_j| and
    /// T = ½ Σ |p_j ∂H/∂p_j|.
    #[serde(skip)]
    pub k_share: f64,
}

impl WorkRow {
    /// The error of (q, p) with its doubt.
    pub fn qp(&self) -> Option<Measured> {
        self.error_qp.map(|error| Measured { error, doubt: self.doubt_qp })
    }

    /// The error of w with its doubt.
    pub fn w(&self) -> Option<Measured> {
        self.error_w.map(|error| Measured { error, doubt: self.doubt_w })
    }

    /// The step or the tolerance, in words.
    pub fn setting(&self) -> String {
        setting_in_words(self.h, self.tolerance)
    }

    /// The ending of the run.
    pub fn ending(&self) -> Ending {
        Ending { outcome: self.outcome, failure: self.failure.clone() }
    }
}

/// The step of a run, or the tolerance from which its steps follow, in words.
pub(super) fn setting_in_words(h: f64, tolerance: Option<f64>) -> String {
    match tolerance {
        Some(tolerance) => format!("tolerance = {tolerance:e}"),
        None => format!("step = {h:?}"),
    }
}

/// The runs of a study of work against precision: each method at each step, and each method that
/// chooses its steps at each tolerance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runs<'a> {
    /// The methods that are run at steps.
    pub methods: &'a [&'static Row],
    /// The steps, in the unit of time of the problem. Each divides the end of time.
    pub steps: &'a [f64],
    /// The methods that are run at tolerances.
    pub adaptive: &'a [&'static Row],
    /// The relative tolerances ([`Tolerance::all`]).
    pub tolerances: &'a [f64],
}

/// A study of work against precision: runs at steps, and runs at tolerances. Errors are computed in
/// parallel, and times are measured one after another.
pub struct WorkPrecision<'a> {
    problem: &'a Problem,
    runs: Vec<(&'static Row, Setting<f64>)>,
}

/// The result of a cell of the study.
#[derive(Serialize, Deserialize)]
pub enum Part {
    /// The row of a run, without its time, and its [`WorkRow::k_share`].
    Errors(Box<WorkRow>, f64),
    /// The time of a run in seconds; none if it did not complete.
    Seconds(Option<f64>),
}

impl<'a> WorkPrecision<'a> {
    /// The study of a problem by these runs.
    ///
    /// # Errors
    /// A step that does not divide the end of time.
    pub fn new(problem: &'a Problem, runs: Runs<'_>) -> Result<Self, InputError> {
        let Runs { methods, steps, adaptive, tolerances } = runs;
        let grids =
            steps.iter().map(|&h| Grid::new(h, problem.end)).collect::<Result<Vec<_>, _>>()?;
        let by_step = methods
            .iter()
            .flat_map(|&row| grids.iter().map(move |&grid| (row, Setting::Step(grid))));
        let within = |&tolerance: &f64| Setting::Tolerance(Tolerance::all(tolerance), problem.end);
        let by_tolerance =
            adaptive.iter().flat_map(|&row| tolerances.iter().map(move |x| (row, within(x))));
        Ok(Self { problem, runs: by_step.chain(by_tolerance).collect() })
    }

    /// The rows of the table, from the results of all cells.
    pub fn rows(parts: Vec<Part>) -> Vec<WorkRow> {
        let (mut rows, mut times) = (Vec::new(), Vec::new());
        for part in parts {
            match part {
                Part::Errors(row, k_share) => rows.push(WorkRow { k_share, ..*row }),
                Part::Seconds(seconds) => times.push(seconds),
            }
        }
        for (row, seconds) in rows.iter_mut().zip(times) {
            row.seconds = seconds.filter(|_| row.outcome == COMPLETED);
        }
        rows
    }
}

impl Study for WorkPrecision<'_> {
    type Shared = Solution<f64>;
    type Part = Part;
    type Error = IntegrateError;

    fn cells(&self) -> Vec<Cell> {
        let degrees = self.problem.model.degrees() as f64;
        let cell = |&(row, setting): &(&Row, Setting<f64>), timed: bool| {
            let (at, steps) = match setting {
                Setting::Step(grid) => (format!("h={:?}", grid.h), grid.steps as f64),
                Setting::Tolerance(tolerance, end) => {
                    let tolerance = tolerance.relative;
                    (format!("tolerance={tolerance:?}"), end * STEPS_IN_1 / tolerance.powf(0.125))
                }
            };
            let key = format!("{}/{at}{}", row.name, if timed { "/seconds" } else { "" });
            let repeats = if timed { f64::from(REPEATS) } else { 1.0 };
            Cell { timed, ..Cell::new(key, steps * degrees * repeats) }
        };
        let errors = self.runs.iter().map(|run| cell(run, false));
        errors.chain(self.runs.iter().map(|run| cell(run, true))).collect()
    }

    fn share(&self, progress: &dyn Progress) -> Result<Self::Shared, Self::Error> {
        self.problem.solution(self.problem.end, 1, progress)
    }

    fn compute(
        &self,
        exact: &Self::Shared,
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Part, IntegrateError> {
        let (row, setting) = self.runs[index % self.runs.len()];
        let part = if index < self.runs.len() {
            let row = errors(self.problem, row, setting, exact, progress)?;
            let k_share = row.k_share;
            Part::Errors(Box::new(row), k_share)
        } else {
            Part::Seconds(seconds(self.problem, row, setting, progress))
        };
        progress.advance();
        Ok(part)
    }
}

/// Computes the study, and returns a row for each run.
///
/// # Errors
/// Invalid input. The row of a run that fails contains its failure.
pub fn run(
    problem: &Problem,
    runs: Runs<'_>,
    progress: &dyn Progress,
) -> Result<Vec<WorkRow>, IntegrateError> {
    let study = WorkPrecision::new(problem, runs)?;
    Ok(WorkPrecision::rows(compute_all(&study, progress)?))
}

/// A run as observed at all its steps.
struct Observed {
    watch: Watch<Arc<dyn Abilities<f64>>>,
    largest: LargestEnergy,
}

impl Observed {
    /// The row of a run at a step or a tolerance, from its final state.
    fn row(
        self,
        method: &'static str,
        Ended { ending, h, tolerance, effort }: Ended,
        state: &State<Vec<f64>>,
        exact: &Solution<f64>,
    ) -> WorkRow {
        let errors = effort.map(|_| exact.errors(1, state.state_ref()));
        let doubt = exact.doubt_at(1);
        let Ending { outcome, failure } = ending;
        WorkRow {
            method,
            h,
            outcome,
            error_qp: errors.map(|[q, p, _]| q.larger(p).error),
            error_w: errors.map(|[.., w]| w.error),
            k_drift: self.watch.drift,
            passivity_violations: self.watch.violations(),
            seconds: None,
            steps: self.watch.steps,
            evaluations: effort.map(|effort| effort.evaluations),
            iterations: effort.map(|effort| effort.iterations),
            failure,
            doubt_qp: doubt.qp(),
            doubt_w: doubt.w,
            tolerance,
            k_share: self.largest.share(self.watch.drift),
        }
    }
}

/// The row of one run without its time. The first two states of `exact` are the start and the end.
pub(super) fn errors(
    problem: &Problem,
    row: &'static Row,
    setting: Setting<f64>,
    exact: &Solution<f64>,
    progress: &dyn Progress,
) -> Result<WorkRow, IntegrateError> {
    let (method, mut state) = (problem.model.bind(row)?, problem.start()?);
    let system = problem.model.system::<f64>()?;
    let mut watch = Watch::new(system.clone(), &problem.model, state.state_ref())?;
    let mut largest = LargestEnergy::default();
    largest.see(&*system, state.state_ref());
    let result = method.run(setting, &mut state, 1, &mut |step, state| {
        watch.see(step, state);
        largest.see(&*system, state);
        progress.flow()
    });
    let ended = ended(&result, setting, watch.steps, &state, problem.end)?;
    Ok(Observed { watch, largest }.row(row.name, ended, &state, exact))
}

/// The end of a run at a step or a tolerance.
pub(super) struct Ended {
    pub(super) ending: Ending,
    /// The step, or the mean one if the steps follow from a tolerance.
    pub(super) h: f64,
    pub(super) tolerance: Option<f64>,
    /// The work of a run that has completed.
    pub(super) effort: Option<Effort>,
}

/// The end of a run of `steps` steps.
///
/// # Errors
/// Invalid input of a run by tolerance.
pub(super) fn ended(
    result: &Result<Statistics, IntegrateError>,
    setting: Setting<f64>,
    steps: u64,
    state: &State<Vec<f64>>,
    end: f64,
) -> Result<Ended, IntegrateError> {
    let (ending, h, tolerance) = match setting {
        Setting::Step(grid) => (Ending::of(result, grid.steps, steps), grid.h, None),
        Setting::Tolerance(tolerance, _) => {
            if let Err(IntegrateError::Input(error)) = result {
                return Err(error.clone().into());
            }
            let mean = if steps > 0 { state.t / steps as f64 } else { end };
            (Ending::of(result, 1, u64::from(state.t == end)), mean, Some(tolerance.relative))
        }
    };
    let effort = result.as_ref().ok().map(|statistics| statistics.effort);
    Ok(Ended { h, tolerance, effort: effort.filter(|_| ending.is_completed()), ending })
}

/// A guess of the steps in a unit of time at a tolerance of 1.
const STEPS_IN_1: f64 = 2.0;

/// The least total time of repeated runs. The fastest run counts, since disturbances only slow a
/// run.
const LONG_ENOUGH: Duration = Duration::from_millis(3);
/// The least number of repetitions.
const REPEATS: u32 = 3;

/// The number of checks whether to stop during a timed run.
const PAUSES: u64 = 256;

/// The time of a run; none if it fails or the user stops.
fn seconds(
    problem: &Problem,
    row: &Row,
    setting: Setting<f64>,
    progress: &dyn Progress,
) -> Option<f64> {
    let time = time(problem, row, setting, progress).ok()?;
    (!progress.stopped()).then_some(time.as_secs_f64())
}

/// The time of the fastest of several runs, or of those completed before the user asked to stop.
pub(super) fn time(
    problem: &Problem,
    row: &Row,
    setting: Setting<f64>,
    progress: &dyn Progress,
) -> Result<Duration, IntegrateError> {
    let method = problem.model.bind(row)?;
    let every = match setting {
        Setting::Step(grid) => (grid.steps / PAUSES).max(1),
        Setting::Tolerance(..) => 1,
    };
    let start = problem.start()?;
    let (mut best, mut all, mut repeats) = (Duration::MAX, Duration::ZERO, 0);
    let mut look = |_: u64, _: StateRef<'_, f64>| progress.flow();
    while (repeats < REPEATS || all < LONG_ENOUGH) && !progress.stopped() {
        let mut state = start.clone();
        let clock = Instant::now();
        method.run(setting, &mut state, every, &mut look)?;
        let elapsed = clock.elapsed();
        best = best.min(elapsed);
        all += elapsed;
        repeats += 1;
    }
    Ok(best)
}
