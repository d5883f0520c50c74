//! Local errors on a base grid, and the empirical order they show (paper, section 2).
//!
//! From every point `t_i = i h0` of the exact solution one step of size h is taken, and
//! `T_i = [x(t_i + h) - x_1]/h`, the exact increment less the numerical one. The order is the slope of
//! log statistic(T) against log h, the statistic taken over the grid.

use super::{Problem, VARIABLES, distance};
use crate::Solution;
use crate::progress::{Progress, Silent};
use crate::statistics::{Fit, fit, median};
use afterbay_core::{Grid, InputError, IntegrateError, Scalar};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;

/// The base grid and the steps taken from it.
#[derive(Clone, Debug, Serialize)]
pub struct LocalOrder {
    /// h0; each step is a whole multiple of it.
    pub base_step: f64,
    /// The steps h.
    pub steps: Vec<f64>,
}

/// One number for all T_i.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The largest.
    Max,
    /// The middle one.
    Median,
    /// The root of the mean square.
    Rms,
}

impl Statistic {
    /// All three, as the tables have them.
    pub const ALL: [Self; 3] = [Self::Max, Self::Median, Self::Rms];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Max => "max",
            Self::Median => "median",
            Self::Rms => "rms",
        }
    }
}

/// |T| of one variable over the grid.
#[derive(Clone, Copy, Debug, Default)]
pub struct Summary {
    max: f64,
    median: f64,
    rms: f64,
    /// The grid point of the largest.
    worst: usize,
}

impl Summary {
    /// One of the three statistics.
    pub fn get(&self, statistic: Statistic) -> f64 {
        match statistic {
            Statistic::Max => self.max,
            Statistic::Median => self.median,
            Statistic::Rms => self.rms,
        }
    }
}

/// What one method does with one step size.
#[derive(Clone, Debug)]
pub struct LocalErrors {
    /// The method.
    pub method: &'static Row,
    /// The step.
    pub h: f64,
    /// |T| of q, p and w.
    pub variables: [Summary; 3],
    /// Grid points no step could be taken from.
    pub failed: usize,
    /// T below this is rounding.
    pub floor: f64,
    /// Time and distance to the pole of δ of the worst grid point of each variable.
    pub worst: [(f64, Option<f64>); 3],
}

/// A row of `local_orders.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct OrderRow {
    /// Name of the method.
    pub method: &'static str,
    /// q, p or w.
    pub variable: &'static str,
    /// max, median or rms.
    pub statistic: &'static str,
    /// The slope; none if fewer than two steps stand above rounding.
    pub order: Option<f64>,
    /// Lower end of its 95 % confidence interval.
    pub ci_low: Option<f64>,
    /// Upper end.
    pub ci_high: Option<f64>,
    /// Steps above the rounding floor.
    pub points: usize,
    /// What the paper prints.
    pub printed: Option<f64>,
    /// Time of the worst grid point at the largest step.
    pub worst_t: f64,
    /// Its distance to the nearest pole: |p/m| for δ(q), |V' + D| for δ(p).
    pub pole_distance: Option<f64>,
    /// Grid points that failed, over all steps.
    pub failed: usize,
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
    /// Those of the input, and of a solution that leaves the numbers. A method that does not apply is an error too.
    pub fn run<T: Scalar>(
        &self,
        problem: &Problem,
        methods: &[&'static Row],
        progress: &dyn Progress,
    ) -> Result<Vec<LocalErrors>, IntegrateError> {
        let solution = self.solution::<T>(problem, progress)?;
        let tasks: Vec<_> =
            methods.iter().flat_map(|&row| self.steps.iter().map(move |&h| (row, h))).collect();
        tasks
            .into_par_iter()
            .map(|(row, h)| {
                let trace = self.trace_along(problem, &solution, row, h)?;
                let errors = self.summarise(problem, &solution, row, h, &trace);
                progress.advance();
                errors
            })
            .collect()
    }

    /// |T| at every grid point for one method and step, computed in `T`.
    ///
    /// # Errors
    /// As for [`LocalOrder::run`].
    pub fn trace<T: Scalar>(&self, problem: &Problem, row: &Row, h: f64) -> Result<Trace, IntegrateError> {
        let alone = Self { steps: vec![h], ..self.clone() };
        alone.trace_along(problem, &alone.solution::<T>(problem, &Silent)?, row, h)
    }

    fn solution<T: Scalar>(
        &self,
        problem: &Problem,
        progress: &dyn Progress,
    ) -> Result<Solution<T>, IntegrateError> {
        let grid = Grid::<T>::new(self.base_step, problem.end)?;
        let beyond = self.steps.iter().map(|&h| self.multiple(h)).collect::<Result<Vec<_>, _>>()?;
        let count = grid.steps as usize + beyond.into_iter().max().unwrap_or(0);
        let subject = problem.model.subject::<T>()?;
        subject.solution(&problem.start()?, grid.h, count, progress)
    }

    fn trace_along<T: Scalar>(
        &self,
        problem: &Problem,
        solution: &Solution<T>,
        row: &Row,
        h: f64,
    ) -> Result<Trace, IntegrateError> {
        let method = problem.model.subject::<T>()?.bind(row)?;
        let multiple = self.multiple(h)?;
        let points = Grid::<T>::new(self.base_step, problem.end)?.steps as usize + 1;
        // h as the exact solution counts it, so that both steps are the same to the last bit of `T`.
        let h = T::from_f64(self.base_step) * T::from_f64(multiple as f64);
        let mut state = problem.start()?;
        let mut errors = |i: usize| {
            let (from, to) = (solution.at(i), solution.at(i + multiple));
            for (part, from) in [(&mut state.q, from.q), (&mut state.p, from.p), (&mut state.w, from.w)] {
                part.copy_from_slice(from);
            }
            method.step(h, &mut state).ok()?;
            Some(distance(to, state.view()).map(|off| (off / h).to_f64()))
        };
        Ok((0..points).map(&mut errors).collect())
    }

    fn summarise<T: Scalar>(
        &self,
        problem: &Problem,
        solution: &Solution<T>,
        row: &'static Row,
        h: f64,
        trace: &Trace,
    ) -> Result<LocalErrors, IntegrateError> {
        let subject = problem.model.subject::<T>()?;
        let numbers = solution.states().flat_map(|state| [state.q, state.p, state.w]).flatten();
        let largest = numbers.fold(0.0, |max: f64, x| max.max(x.abs().to_f64()));
        let variables = std::array::from_fn(|variable| {
            let mut sizes = Vec::with_capacity(trace.len());
            let (mut worst, mut max, mut squares) = (0, 0.0, 0.0);
            for (i, errors) in trace.iter().enumerate() {
                let Some(errors) = errors else { continue };
                let size = errors[variable];
                if size > max {
                    (worst, max) = (i, size);
                }
                squares += size * size;
                sizes.push(size);
            }
            let rms = (squares / sizes.len().max(1) as f64).sqrt();
            Summary { max, median: median(&mut sizes), rms, worst }
        });
        let worst = variables.map(|summary: Summary| {
            let state = solution.at(summary.worst);
            let distance = |equation| Some(subject.denominator(equation, state.q, state.p)?.abs().to_f64());
            let nearest = row.poles().iter().filter_map(|&equation| distance(equation)).reduce(f64::min);
            (summary.worst as f64 * self.base_step, nearest)
        });
        let failed = trace.iter().filter(|errors| errors.is_none()).count();
        // A few roundings of the largest number, divided by h as T is.
        let floor = 8.0 * T::EPSILON * largest / h;
        Ok(LocalErrors { method: row, h, variables, failed, floor, worst })
    }
}

/// The slope of log statistic against log h for one method and variable, points at the rounding floor left out.
pub fn order(errors: &[&LocalErrors], variable: usize, statistic: Statistic) -> Option<Fit> {
    let points: Vec<_> = errors
        .iter()
        .map(|errors| (errors.h, errors.variables[variable].get(statistic), errors.floor))
        .filter(|&(_, size, floor)| size > floor)
        .map(|(h, size, _)| (h.ln(), size.ln()))
        .collect();
    fit(&points)
}

/// The rows of the table, methods in the order they were run. `printed` knows what the paper prints.
pub fn rows(errors: &[LocalErrors], printed: impl Fn(&str, &str, Statistic) -> Option<f64>) -> Vec<OrderRow> {
    let mut rows = Vec::new();
    for group in errors.chunk_by(|a, b| a.method.name == b.method.name) {
        let Some(widest) = group.iter().max_by(|a, b| a.h.total_cmp(&b.h)) else { continue };
        let group: Vec<_> = group.iter().collect();
        for (variable, name) in VARIABLES.into_iter().enumerate() {
            for statistic in Statistic::ALL {
                let fit = order(&group, variable, statistic);
                let margin = fit.and_then(|fit| fit.margin);
                let slope = fit.map(|fit| fit.slope);
                let (worst_t, pole_distance) = widest.worst[variable];
                rows.push(OrderRow {
                    method: widest.method.name,
                    variable: name,
                    statistic: statistic.name(),
                    order: slope,
                    ci_low: slope.zip(margin).map(|(slope, margin)| slope - margin),
                    ci_high: slope.zip(margin).map(|(slope, margin)| slope + margin),
                    points: fit.map_or(0, |fit| fit.points),
                    printed: printed(widest.method.name, name, statistic),
                    worst_t,
                    pole_distance,
                    failed: group.iter().map(|errors| errors.failed).sum(),
                });
            }
        }
    }
    rows
}
