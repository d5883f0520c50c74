//! Plans from the tables of a scene.

mod budget;
mod dynamics;
mod events;
mod figures;
mod methods;
mod stability;
mod tangents;
mod values;

use super::document::{Document, RunTable, Spread};
use super::plan::{
    EnergyPlan, LocalOrderPlan, LongRunPlan, RunPlan, StepsPlan, Studies, WorkPrecisionPlan,
};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use crate::study::{Problem, local_order::LocalOrder, trajectory};
use afterbay_core::{Grid, InputError, Tolerance};
use afterbay_methods::registry::{self, ADAPTIVE, Row};
use budget::MOST_TOLERANCES;
use methods::Methods;
use values::entry;

/// Checks the tables of a scene and makes plans of them.
pub(super) struct Planner<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) document: &'a Document,
    pub(super) problem: &'a Problem,
    /// The number of steps of a run.
    pub(super) steps: u64,
    /// The number of points of the sweep, 1 without one.
    pub(super) points: usize,
}

/// The method that runs with the tolerance of [run] if no other is named.
const UNLESS_NAMED: &str = "adaptive-collocation";

type Planned<T> = Result<T, SceneError>;

impl Planner<'_> {
    pub(super) fn refuse<T>(&self, path: &str, problem: impl Into<SceneProblem>) -> Planned<T> {
        Err(SceneError { problem: problem.into(), span: self.source.span(path) })
    }

    /// Refuses with a path whose keys may contain dots.
    fn refuse_at<T>(&self, keys: &[&str], problem: SceneProblem) -> Planned<T> {
        Err(SceneError { problem, span: self.source.span_of(keys) })
    }

    fn within<T>(&self, path: &str, result: Result<T, InputError>) -> Planned<T> {
        result.or_else(|error| self.refuse(path, error))
    }

    pub(super) fn run(&self) -> Planned<Option<RunPlan>> {
        let Some(table) = &self.document.run else { return Ok(None) };
        let path = "run.methods";
        let Methods { fixed: methods, mut adaptive } = self.methods(path, &table.methods)?;
        if table.tolerance.is_none() {
            self.none_adaptive(path, &table.methods, &adaptive)?;
        } else if adaptive.is_empty() {
            adaptive.extend(registry::find(UNLESS_NAMED));
        }
        if !methods.is_empty() {
            self.step(None)?;
        }
        let every = self.every("run.every", table.every, self.steps)?;
        self.steps_fit("time.step", self.steps as f64 * methods.len() as f64)?;
        let columns = trajectory::columns(&self.problem.model).len();
        let count = methods.len() + adaptive.len();
        self.states_fit("run.every", self.steps / every, count * columns)?;
        if let Some(tolerance) = table.tolerance {
            self.within("run.tolerance", Tolerance::all(tolerance).check::<f64>())?;
        }
        let (tolerance, events) = (table.tolerance, self.events()?);
        let sample = self.sample(table, count * columns, !events.is_empty())?;
        Ok(Some(RunPlan { methods, adaptive, every, tolerance, sample, events }))
    }

    /// The spacing of the states that are kept.
    fn sample(&self, table: &RunTable, columns: usize, events: bool) -> Planned<Option<f64>> {
        let (Some(spacing), path) = (table.sample, "run.sample") else { return Ok(None) };
        let refuse = |why| self.refuse(path, SceneProblem::Misplaced { key: "sample", why });
        if table.every.is_some() {
            return refuse("`every` says which states are kept");
        }
        if events {
            return refuse("with events, `every` says which states are kept");
        }
        if !(spacing > 0.0 && spacing <= self.problem.end) {
            let (name, range) = ("sample", "positive, and at most the end of time");
            return self.refuse(path, SceneProblem::Range { name, value: spacing, range });
        }
        self.states_fit(path, (self.problem.end / spacing) as u64, columns)?;
        Ok(Some(spacing))
    }

    /// The step of a table, else that of the scene.
    fn step(&self, own: Option<f64>) -> Planned<f64> {
        match own.or(self.document.time.step) {
            Some(step) => Ok(step),
            None => self.refuse("time", SceneProblem::Missing { key: "step".into() }),
        }
    }

    pub(super) fn studies(&self) -> Planned<Studies> {
        let tables = &self.document.study;
        let mut studies = Studies::default();
        self.refuse_timed()?;
        if let Some(table) = &tables.local_order {
            let path = "study.local-order";
            let methods = self.fixed_methods(path, table.methods.as_ref())?;
            let steps = self.spread(&format!("{path}.steps"), &table.steps)?;
            let base = format!("{path}.base_step");
            let grid = self.base_grid(&base, table.base_step)?;
            for (i, &h) in steps.iter().enumerate() {
                let at = entry(path, &table.steps, i);
                match Grid::<f64>::new(table.base_step, h) {
                    Err(InputError::NotAMultiple { .. }) => {
                        let problem = SceneProblem::OffGrid { step: h, base: table.base_step };
                        return self.refuse(&at, problem);
                    }
                    grid => self.within(&at, grid.map(drop))?,
                }
            }
            self.steps_fit(&base, grid.steps as f64 * (methods.len() * steps.len()) as f64)?;
            // The exact solution is stored along the grid.
            self.table_fits(&base, grid.steps, 3 * self.problem.model.dof() + 1)?;
            studies.local_order = Some(LocalOrderPlan {
                methods,
                study: LocalOrder { base_step: table.base_step, steps },
            });
        }
        if let Some(table) = &tables.global_order {
            let path = "study.global-order";
            let methods = self.fixed_methods(path, table.methods.as_ref())?;
            let plan = self.at_steps(path, methods, &table.steps)?;
            if plan.steps.len() == 1 {
                return self.refuse(&format!("{path}.steps"), SceneProblem::OneStep);
            }
            studies.global_order = Some(plan);
        }
        if let Some(table) = &tables.energy {
            let path = "study.energy";
            let methods = self.fixed_methods(path, table.methods.as_ref())?;
            let step = self.step(table.step)?;
            let grid =
                self.within(&format!("{path}.step"), Grid::<f64>::new(step, self.problem.end))?;
            let every = self.every(&format!("{path}.every"), table.every, grid.steps)?;
            self.steps_fit(path, grid.steps as f64 * methods.len() as f64)?;
            let dof = self.problem.model.dof();
            self.table_fits(path, grid.steps / every, methods.len() * (8 + dof))?;
            // The exact solution is stored at every step.
            self.table_fits(path, grid.steps, 3 * dof + 1)?;
            studies.energy = Some(EnergyPlan { methods, step, every });
        }
        if let Some(table) = &tables.work_precision {
            let path = "study.work-precision";
            let (at, names) = self.names(path, table.methods.as_ref())?;
            let Methods { fixed, mut adaptive } = self.methods(&at, names)?;
            if table.tolerances.is_empty() && table.methods.is_some() {
                self.none_adaptive(&at, names, &adaptive)?;
            }
            if adaptive.is_empty() {
                adaptive.extend(ADAPTIVE);
            }
            let StepsPlan { methods, steps } = self.at_steps(path, fixed, &table.steps)?;
            let (tolerances, path) = (table.tolerances.clone(), format!("{path}.tolerances"));
            let size = (tolerances.len() as f64, MOST_TOLERANCES);
            self.budget(&path, "the number of tolerances", size, "give fewer of them")?;
            self.list(&path, &tolerances, |tolerance| Tolerance::all(tolerance).check::<f64>())?;
            studies.work_precision =
                Some(WorkPrecisionPlan { methods, adaptive, steps, tolerances });
        }
        if let Some(table) = &tables.long_run {
            let path = "study.long-run";
            let methods = self.fixed_methods(path, table.methods.as_ref())?;
            let step = self.step(table.step)?;
            self.within(&format!("{path}.step"), Grid::<f64>::of(step, table.count))?;
            if table.count == 0 {
                let range = "at least 1";
                return self.refuse(
                    &format!("{path}.count"),
                    SceneProblem::Range { name: "count", value: 0.0, range },
                );
            }
            self.steps_fit(&format!("{path}.count"), table.count as f64 * methods.len() as f64)?;
            studies.long_run = Some(LongRunPlan {
                methods,
                step,
                count: table.count,
                compensated: table.compensated,
            });
        }
        studies.stability = self.stability()?;
        studies.poincare = self.poincare()?;
        studies.bifurcation = self.bifurcation()?;
        studies.resonance = self.resonance()?;
        studies.basins = self.basins()?;
        studies.lyapunov = self.lyapunov()?;
        studies.limit_cycle = self.limit_cycle()?;
        Ok(studies)
    }

    /// Refuses the studies that take neither a drive nor a system that depends on the time.
    fn refuse_timed(&self) -> Planned<()> {
        let tables = &self.document.study;
        let given = [
            ("local-order", tables.local_order.is_some()),
            ("stability", tables.stability.is_some()),
            ("long-run", tables.long_run.is_some()),
        ];
        match given.into_iter().find(|x| x.1) {
            Some((key, _)) if !self.problem.model.motors().is_empty() => {
                let why = if self.problem.model.has_clock() {
                    "this study does not take a system that depends on t; global-order, energy and \
                     work-precision do, and so do the studies of attractors"
                } else {
                    "this study does not take a [drive]; global-order, energy and work-precision \
                     do, and so do the studies of attractors"
                };
                self.refuse(&format!("study.{key}"), SceneProblem::Misplaced { key, why })
            }
            _ => Ok(()),
        }
    }

    /// The grid of a study of local errors.
    fn base_grid(&self, path: &str, step: f64) -> Planned<Grid<f64>> {
        match Grid::<f64>::new(step, self.problem.end) {
            Err(InputError::NotAMultiple { end, h, nearest }) => {
                let name = "base_step";
                self.refuse(path, SceneProblem::Indivisible { name, end, h, nearest })
            }
            grid => self.within(path, grid),
        }
    }

    fn at_steps(
        &self,
        path: &str,
        methods: Vec<&'static Row>,
        steps: &Spread,
    ) -> Planned<StepsPlan> {
        let spread = self.spread(&format!("{path}.steps"), steps)?;
        let mut all = 0.0;
        for (i, &h) in spread.iter().enumerate() {
            let grid =
                self.within(&entry(path, steps, i), Grid::<f64>::new(h, self.problem.end))?;
            all += grid.steps as f64 * methods.len() as f64;
        }
        self.steps_fit(&format!("{path}.steps"), all)?;
        Ok(StepsPlan { methods, steps: spread })
    }
}
