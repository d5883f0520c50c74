//! Local errors on a base grid, and the empirical order they show (paper, section 2).
//!
//! One step of size h is taken from every point `t_i = i h0` of the exact solution. The local error
//! is `T_i = [x(t_i + h) - x_1]/h`, the exact increment minus the numerical one. The order is the
//! slope of log statistic(T) against log h, with the statistic taken over the grid.
//!
//! Only steps whose statistic is at least ten times that of the roundings in T are used. The
//! roundings are the difference between the step in `f64` and the same step in [`Quad`] from the
//! same state, plus the rounding of the two states compared, both divided by h. They are estimated
//! at a sample of the grid and at the points with the largest T.

mod statistic;
mod table;

use super::cell::{Cell, Study, compute_all, map_cells, reference_bytes};
use super::{Problem, distance};
use crate::Solution;
use crate::progress::{Progress, Silent};
use crate::words::by_name;
use afterbay_core::{Grid, InputError, IntegrateError, Quad, Scalar, State, StateRef};
use afterbay_methods::moddg::steps::Equation;
use afterbay_methods::registry::{Number, Row, Run};
use afterbay_systems::catalog::Expandable;
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;

pub use statistic::{Statistic, Summary};
pub use table::{OrderRow, order, rows};

/// The number of grid points at which roundings are estimated, besides those with the largest T. A
/// choice.
const SAMPLES: usize = 48;

/// A scalar for local errors, in which methods run and solutions are expanded.
pub trait Working: Number + Expandable {}

impl<T: Number + Expandable> Working for T {}

/// The base grid and the steps taken from it.
#[derive(Clone, Debug, Serialize)]
pub struct LocalOrder {
    /// h0; each step is a whole multiple of it.
    pub base_step: f64,
    /// The steps h.
    pub steps: Vec<f64>,
}

/// The local errors of one method at one step size.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LocalErrors {
    /// The method.
    #[serde(with = "by_name")]
    pub method: &'static Row,
    /// The step.
    pub h: f64,
    /// |T| of q, p and w.
    pub variables: [Summary; 3],
    /// The number of grid points at which the step failed.
    pub failed: usize,
    /// The roundings in T of q, p and w.
    pub floors: [Summary; 3],
    /// The time of the grid point with the largest |T|, and its distance to the pole of δ, for each
    /// variable.
    pub worst: [(f64, Option<f64>); 3],
}

/// Local errors with |T| per grid point; `None` where the step failed.
pub type Trace = Vec<Option<[f64; 3]>>;

impl LocalOrder {
    /// The number of base steps in h.
    fn multiple(&self, h: f64) -> Result<usize, InputError> {
        Ok(Grid::<f64>::new(self.base_step, h)?.steps as usize)
    }

    /// Summaries of the local errors of each method at each step, computed in `T`.
    ///
    /// # Errors
    /// Invalid input, a method that does not apply, and a solution that ceases to be finite.
    pub fn run<T: Working>(
        &self,
        problem: &Problem,
        methods: &[&'static Row],
        progress: &dyn Progress,
    ) -> Result<Vec<LocalErrors>, IntegrateError> {
        compute_all(&self.of::<T>(problem, methods), progress)
    }

    /// The summaries of [`LocalOrder::run`] on each horizon [0, end], with each step taken once:
    /// the grid of a shorter horizon is the beginning of that of the longest. The end of the
    /// problem is not used.
    ///
    /// # Errors
    /// Those of [`LocalOrder::run`] on the longest horizon.
    pub fn run_on_horizons<T: Working>(
        &self,
        problem: &Problem,
        ends: &[f64],
        methods: &[&'static Row],
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<LocalErrors>>, IntegrateError> {
        let to = |end: f64| Problem { end, ..problem.clone() };
        let longest = to(ends.iter().copied().fold(0.0, f64::max));
        let study = self.of::<T>(&longest, methods);
        let (solution, cells) = (study.share(progress)?, study.cells());
        let all: Vec<usize> = (0..cells.len()).collect();
        let each = map_cells(&cells, &all, |index| {
            let (row, h) = study.cell(index);
            let trace = self.trace_along(&longest, &solution, row, h)?;
            let on = |&end: &f64| self.summarise(&to(end), &solution, row, h, &trace);
            let found = ends.iter().map(on).collect::<Result<Vec<_>, _>>();
            progress.advance();
            found
        })?;
        let on = |horizon: usize| each.iter().map(|found| found[horizon].clone()).collect();
        Ok((0..ends.len()).map(on).collect())
    }

    /// The study of methods on a problem, computed in `T`.
    pub fn of<'a, T: Working>(
        &'a self,
        problem: &'a Problem,
        methods: &'a [&'static Row],
    ) -> LocalOrders<'a, T> {
        LocalOrders { order: self, problem, methods, scalar: PhantomData }
    }

    /// |T| at every grid point for one method and step, computed in `T`.
    ///
    /// # Errors
    /// Those of [`LocalOrder::run`].
    pub fn trace<T: Working>(
        &self,
        problem: &Problem,
        row: &Row,
        h: f64,
    ) -> Result<Trace, IntegrateError> {
        let alone = Self { steps: vec![h], ..self.clone() };
        alone.trace_along(problem, &alone.solution::<T>(problem, &Silent)?, row, h)
    }

    fn solution<T: Working>(
        &self,
        problem: &Problem,
        progress: &dyn Progress,
    ) -> Result<Solution<T>, IntegrateError> {
        let grid = Grid::<T>::new(self.base_step, problem.end)?;
        let beyond = self.steps.iter().map(|&h| self.multiple(h)).collect::<Result<Vec<_>, _>>()?;
        let count = grid.steps as usize + beyond.into_iter().max().unwrap_or(0);
        problem.model.solution(&problem.start()?, grid.h, count, progress)
    }

    fn trace_along<T: Working>(
        &self,
        problem: &Problem,
        solution: &Solution<T>,
        row: &Row,
        h: f64,
    ) -> Result<Trace, IntegrateError> {
        let method = problem.model.bind_in::<T>(row)?;
        let multiple = self.multiple(h)?;
        let points = self.points(problem)?;
        // h is computed as in the exact solution, so that both agree to the last bit of `T`.
        let h = T::from_f64(self.base_step) * T::from_f64(multiple as f64);
        let mut state = problem.start()?;
        let mut errors = |i: usize| {
            let (from, to) = (solution.at(i), solution.at(i + multiple));
            for (part, from) in
                [(&mut state.q, from.q), (&mut state.p, from.p), (&mut state.w, from.w)]
            {
                part.copy_from_slice(from);
            }
            method.step(h, &mut state).ok()?;
            Some(distance(to, state.state_ref()).map(|off| (off / h).to_f64()))
        };
        Ok((0..points).map(&mut errors).collect())
    }

    /// The number of points of the base grid, from 0 to the end.
    fn points(&self, problem: &Problem) -> Result<usize, InputError> {
        Ok(Grid::<f64>::new(self.base_step, problem.end)?.steps as usize + 1)
    }

    /// The summary of a trace that reaches the end of the problem, or farther.
    fn summarise<T: Working>(
        &self,
        problem: &Problem,
        solution: &Solution<T>,
        row: &'static Row,
        h: f64,
        trace: &[Option<[f64; 3]>],
    ) -> Result<LocalErrors, IntegrateError> {
        let system = problem.model.system::<T>()?.order_raising();
        let trace = &trace[..self.points(problem)?];
        let variables: [Summary; 3] = std::array::from_fn(|variable| {
            let sizes = trace.iter().enumerate();
            Summary::of(sizes.filter_map(|(i, errors)| Some((i, errors.as_ref()?[variable]))))
        });
        let floors = self.floors(problem, solution, row, h, variables.map(|of| of.worst))?;
        let worst = variables.map(|summary: Summary| {
            let state = solution.at(summary.worst);
            let distance = |equation: Equation| {
                Some(
                    equation
                        .denominator(&**system.as_ref()?, *state.q.first()?, *state.p.first()?)
                        .abs()
                        .to_f64(),
                )
            };
            let nearest =
                row.poles().iter().filter_map(|&equation| distance(equation)).reduce(f64::min);
            (summary.worst as f64 * self.base_step, nearest)
        });
        let failed = trace.iter().filter(|errors| errors.is_none()).count();
        Ok(LocalErrors { method: row, h, variables, failed, floors, worst })
    }

    /// The statistics of the roundings in T, at a sample of the grid and at the points given.
    fn floors<T: Working>(
        &self,
        problem: &Problem,
        solution: &Solution<T>,
        row: &Row,
        h: f64,
        worst: [usize; 3],
    ) -> Result<[Summary; 3], IntegrateError> {
        let multiple = self.multiple(h)?;
        let points = self.points(problem)?;
        let h = T::from_f64(self.base_step) * T::from_f64(multiple as f64);
        let exact = problem.model.bind_in::<Quad>(row)?;
        let method = problem.model.bind_in::<T>(row)?;
        let mut seen: [Vec<(usize, f64)>; 3] = Default::default();
        let sample = (0..points).step_by(points.div_ceil(SAMPLES)).chain(worst);
        for i in sample {
            let ends = [solution.at(i), solution.at(i + multiple)];
            let sizes = |of: fn(StateRef<'_, T>) -> &[T]| {
                ends.iter()
                    .flat_map(|&end| of(end))
                    .fold(0.0, |most: f64, x| most.max(x.to_f64().abs()))
            };
            // Two states are compared, each of them rounded.
            let mut rounding = [sizes(|of| of.q), sizes(|of| of.p), sizes(|of| of.w)]
                .map(|size| 2.0 * T::EPSILON * size);
            // Nothing is more accurate than `Quad`, so that a few roundings are assumed.
            if T::IS_EXTENDED {
                rounding = rounding.map(|rounding| 4.0 * rounding);
            } else if let Some(lost) = lost(&method, &exact, h, ends[0]) {
                rounding = [0, 1, 2].map(|variable| rounding[variable] + lost[variable]);
            }
            seen.iter_mut()
                .zip(rounding)
                .for_each(|(seen, size)| seen.push((i, size / h.to_f64())));
        }
        Ok(seen.map(|seen| Summary::of(seen.into_iter())))
    }
}

/// A study of local errors, computed in `T`: a walk along the base grid for each method and step.
pub struct LocalOrders<'a, T> {
    order: &'a LocalOrder,
    problem: &'a Problem,
    methods: &'a [&'static Row],
    scalar: PhantomData<T>,
}

impl<T: Working> LocalOrders<'_, T> {
    /// The method and the step of a cell.
    fn cell(&self, index: usize) -> (&'static Row, f64) {
        let steps = &self.order.steps;
        (self.methods[index / steps.len()], steps[index % steps.len()])
    }
}

impl<T: Working> Study for LocalOrders<'_, T> {
    type Shared = Solution<T>;
    type Part = LocalErrors;
    type Error = IntegrateError;

    fn cells(&self) -> Vec<Cell> {
        let cost = self.problem.model.degrees() as f64 * self.problem.end / self.order.base_step;
        let cell = |row: &&Row, h: &f64| Cell::new(format!("{}/h={h:?}", row.name), cost);
        let steps = &self.order.steps;
        self.methods.iter().flat_map(|row| steps.iter().map(move |h| cell(row, h))).collect()
    }

    fn shared_bytes(&self) -> f64 {
        let times = self.problem.end / self.order.base_step;
        reference_bytes(self.problem.model.degrees(), times)
    }

    fn share(&self, progress: &dyn Progress) -> Result<Solution<T>, IntegrateError> {
        self.order.solution::<T>(self.problem, progress)
    }

    fn compute(
        &self,
        solution: &Solution<T>,
        index: usize,
        progress: &dyn Progress,
    ) -> Result<LocalErrors, IntegrateError> {
        let Self { order, problem, .. } = *self;
        let (row, h) = self.cell(index);
        let trace = order.trace_along(problem, solution, row, h)?;
        let errors = order.summarise(problem, solution, row, h, &trace);
        progress.advance();
        errors
    }
}

/// The rounding error of a step: its difference from the same step in `Quad`. None if either fails.
fn lost<T: Scalar>(
    method: &Run<T>,
    exact: &Run<Quad>,
    h: T,
    from: StateRef<'_, T>,
) -> Option<[f64; 3]> {
    let same = |part: &[T]| part.to_vec();
    let lift = |part: &[T]| part.iter().map(|x| Quad::from_f64(x.to_f64())).collect::<Vec<_>>();
    let mut rounded = State { q: same(from.q), p: same(from.p), w: same(from.w), t: from.t };
    let t = Quad::from_f64(from.t.to_f64());
    let mut state = State { q: lift(from.q), p: lift(from.p), w: lift(from.w), t };
    method.step(h, &mut rounded).ok()?;
    exact.step(Quad::from_f64(h.to_f64()), &mut state).ok()?;
    let found = State { q: lift(&rounded.q), p: lift(&rounded.p), w: lift(&rounded.w), t };
    Some(distance(found.state_ref(), state.state_ref()).map(Scalar::to_f64))
}
