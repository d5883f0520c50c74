//! Global errors and empirical orders.

use super::cell::{Cell, Study, compute_all, reference_bytes};
use super::outcome::Ending;
use super::{Problem, VARIABLES};
use crate::progress::{Piece, Progress};
use crate::{Doubt, Measured, Solution};
use afterbay_core::{Grid, IntegrateError};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The largest error that may be rounding, relative to the largest value of the variable. A
/// choice, well above the roundings of a run.
pub const ROUNDING: f64 = 1e-11;

/// A row of `global_orders.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct GlobalRow {
    /// Name of the method.
    pub method: &'static str,
    /// q, p or w.
    pub variable: &'static str,
    /// The step.
    pub h: f64,
    /// max |x - x(t)| over the run and over the degrees of freedom; none if the run did not reach
    /// its end.
    pub error: Option<f64>,
    /// log(e/e')/log(h/h'), where h' and e' are the step and the error of the row before; none if
    /// one of the two errors is not resolved, or may be rounding ([`ROUNDING`]).
    pub order: Option<f64>,
    /// The largest doubt of the reference over the run.
    pub doubt: f64,
    /// The outcome of the run.
    pub outcome: &'static str,
    /// The failure, in words.
    pub failure: Option<String>,
}

impl GlobalRow {
    /// The rows of a method and a variable.
    pub fn of<'a>(
        rows: &'a [Self],
        method: &str,
        variable: &str,
    ) -> impl DoubleEndedIterator<Item = &'a Self> {
        rows.iter().filter(move |row| row.method == method && row.variable == variable)
    }

    /// The error with its doubt.
    pub fn measured(&self) -> Option<Measured> {
        self.error.map(|error| Measured { error, doubt: self.doubt })
    }
}

/// Global errors of each method at each of the `steps`, in the order given.
///
/// # Errors
/// Invalid input. A run that fails has no errors.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    steps: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<GlobalRow>, IntegrateError> {
    if steps.is_empty() {
        return Ok(Vec::new());
    }
    let study = GlobalOrder { problem, methods, steps: steps.to_vec() };
    Ok(study.rows(compute_all(&study, progress)?))
}

/// A study of global errors: a run for each method and step.
pub struct GlobalOrder<'a> {
    /// The system, the initial state and the end of time.
    pub problem: &'a Problem,
    /// The methods.
    pub methods: &'a [&'static Row],
    /// The steps. There is at least one.
    pub steps: Vec<f64>,
}

/// The references of a study: that of the finest step, and one for each step whose times are not
/// among those.
pub struct References {
    finest: f64,
    shared: Solution<f64>,
    own: Vec<Option<Solution<f64>>>,
}

impl Study for GlobalOrder<'_> {
    type Shared = References;
    type Part = Errors;
    type Error = IntegrateError;

    fn cells(&self) -> Vec<Cell> {
        let work = self.problem.model.degrees() as f64 * self.problem.end;
        let cell = |row: &&Row, h: &f64| Cell::new(format!("{}/h={h:?}", row.name), work / h);
        self.methods.iter().flat_map(|row| self.steps.iter().map(move |h| cell(row, h))).collect()
    }

    fn shared_bytes(&self) -> f64 {
        let finest = self.steps.iter().copied().fold(f64::INFINITY, f64::min);
        let apart = self.steps.iter().filter(|&&h| doublings(finest, h).is_none());
        let times: f64 = apart.chain([&finest]).map(|h| self.problem.end / h).sum();
        reference_bytes(self.problem.model.degrees(), times)
    }

    fn share(&self, progress: &dyn Progress) -> Result<References, IntegrateError> {
        let Self { problem, steps, .. } = self;
        let finest = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let shared = solution(problem, finest, progress)?;
        let own = steps
            .par_iter()
            .map(|&h| {
                doublings(finest, h).is_none().then(|| solution(problem, h, progress)).transpose()
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(References { finest, shared, own })
    }

    fn compute(
        &self,
        References { finest, shared, own }: &References,
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Errors, IntegrateError> {
        let (row, at) = (self.methods[index / self.steps.len()], index % self.steps.len());
        let h = self.steps[at];
        let (solution, stride) = match &own[at] {
            Some(own) => (own, 1),
            None => (shared, doublings(*finest, h).unwrap_or(1)),
        };
        let errors = largest_error(self.problem, row, h, solution, stride, progress);
        progress.advance();
        errors
    }
}

impl GlobalOrder<'_> {
    /// The rows of the table, from the results of all cells.
    pub fn rows(&self, errors: Vec<Errors>) -> Vec<GlobalRow> {
        let Self { methods, steps, .. } = self;
        let mut rows = Vec::new();
        for (method, errors) in methods.iter().zip(errors.chunks(steps.len().max(1))) {
            for (variable, name) in VARIABLES.into_iter().enumerate() {
                let mut before: Option<(f64, Measured)> = None;
                for (&h, Errors { errors, doubts, roundings, ending }) in steps.iter().zip(errors) {
                    let error = errors.map(|errors| errors[variable]);
                    let Ending { outcome, failure } = ending.clone();
                    let tells = |of: Measured| of.is_resolved() && of.error > roundings[variable];
                    let pair = before.zip(error).filter(|&((_, a), b)| tells(a) && tells(b));
                    let order = pair.map(|((h0, a), b)| (b.error / a.error).ln() / (h / h0).ln());
                    rows.push(GlobalRow {
                        method: method.name,
                        variable: name,
                        h,
                        error: error.map(|error| error.error),
                        order: order.filter(|order| order.is_finite()),
                        doubt: doubts[variable],
                        outcome,
                        failure,
                    });
                    before = error.map(|error| (h, error));
                }
            }
        }
        rows
    }
}

fn solution(
    problem: &Problem,
    h: f64,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    problem.solution(h, Grid::<f64>::new(h, problem.end)?.steps as usize, progress)
}

/// The ratio h/finest if it is a power of two to the bit, so that the times of h are among those of
/// the finest step and one solution serves both.
fn doublings(finest: f64, h: f64) -> Option<usize> {
    let ratio = h / finest;
    let whole = ratio.fract() == 0.0 && ratio * finest == h && ratio < 1e9;
    (whole && (ratio as usize).is_power_of_two()).then_some(ratio as usize)
}

/// The errors of one run.
#[derive(Serialize, Deserialize)]
pub struct Errors {
    /// The largest errors of q, p and w; none if the run did not reach its end.
    errors: Option<[Measured; 3]>,
    /// The largest doubts of q, p and w.
    doubts: [f64; 3],
    /// The largest errors of q, p and w that may be rounding.
    roundings: [f64; 3],
    ending: Ending,
}

/// The largest errors over a run. Step n of the run corresponds to state n `stride` of the
/// solution.
fn largest_error(
    problem: &Problem,
    row: &Row,
    h: f64,
    solution: &Solution<f64>,
    stride: usize,
    progress: &dyn Progress,
) -> Result<Errors, IntegrateError> {
    let method = problem.model.bind(row)?;
    let mut state = problem.start()?;
    let (grid, mut largest, mut done) =
        (Grid::<f64>::new(h, problem.end)?, [Measured::default(); 3], 0);
    let mut piece = Piece::new(progress);
    let result = method.run(grid, &mut state, 1, &mut |step, state| {
        done = step;
        piece.report(step, grid.steps);
        let errors = solution.errors(stride * step as usize, state);
        largest.iter_mut().zip(errors).for_each(|(largest, now)| *largest = largest.larger(now));
        progress.flow()
    });
    let ending = Ending::of(&result, grid.steps, done);
    let Doubt { q, p, w } = solution.doubt();
    let errors = ending.is_completed().then_some(largest);
    let doubts = [q, p, w];
    let roundings = solution.sizes().map(|size| ROUNDING * size);
    Ok(Errors { errors, doubts, roundings, ending })
}
