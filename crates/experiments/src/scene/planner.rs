//! Plans from the tables of a scene.

mod accuracy;
mod budget;
mod dynamics;
mod events;
mod figures;
mod methods;
mod stability;
mod tangents;
mod values;

use super::document::{Document, RunTable};
use super::plan::{RunPlan, Studies};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use afterbay_analysis::Model;
use afterbay_analysis::study::{Problem, trajectory};
use afterbay_core::{InputError, Tolerance};
use afterbay_methods::registry;
use budget::FEWER_STATES;
use methods::Methods;

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

/// The plans of a scene's runs and studies.
pub(super) struct Plans {
    pub(super) run: Option<RunPlan>,
    pub(super) studies: Studies,
    /// The error of a study that does not follow an event that changes the state.
    pub(super) changing: Option<SceneError>,
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

    /// Refuses a count of 0 of a table.
    pub(super) fn at_least_one(&self, path: &str, name: &'static str, count: u64) -> Planned<()> {
        if count > 0 {
            return Ok(());
        }
        let problem = SceneProblem::Range { name, value: 0.0, range: "at least 1" };
        self.refuse(&format!("{path}.{name}"), problem)
    }

    /// A number of a table that must be positive.
    fn positive(&self, path: &str, name: &'static str, value: f64) -> Planned<f64> {
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        let problem = SceneProblem::Range { name, value, range: "positive" };
        self.refuse(&format!("{path}.{name}"), problem)
    }

    /// The system with another value of a parameter.
    fn varied(&self, path: &str, name: &str, value: f64) -> Planned<Model> {
        self.problem.model.with(name, value).or_else(|error| self.refuse(path, error))
    }

    /// Refuses a tolerance that no run can meet, or that every run meets.
    fn tolerance(&self, path: &str, value: f64) -> Planned<()> {
        self.within(path, Tolerance::all(value).check::<f64>())?;
        if value < 1.0 {
            return Ok(());
        }
        self.refuse(path, SceneProblem::Range { name: "tolerance", value, range: "less than 1" })
    }

    /// The plans of [run] and of the studies.
    pub(super) fn plans(&self) -> Planned<Plans> {
        let (run, studies) = (self.run()?, self.studies()?);
        let changing = run.as_ref().and_then(|run| self.changing(&run.events));
        match changing {
            Some(error) if !studies.is_empty() => Err(error),
            changing => Ok(Plans { run, studies, changing }),
        }
    }

    fn run(&self) -> Planned<Option<RunPlan>> {
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
        self.states_fit("run.every", (self.steps / every, count * columns), FEWER_STATES)?;
        if let Some(tolerance) = table.tolerance {
            self.tolerance("run.tolerance", tolerance)?;
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
        let rows = trajectory::samples(self.problem.end, spacing);
        self.states_fit(path, (rows, columns), "take a larger `sample`")?;
        Ok(Some(spacing))
    }

    /// The step of a table, else that of the scene.
    fn step(&self, own: Option<f64>) -> Planned<f64> {
        match own.or(self.document.time.step) {
            Some(step) => Ok(step),
            None => self.refuse("time", SceneProblem::Missing { key: "step".into() }),
        }
    }

    fn studies(&self) -> Planned<Studies> {
        self.refuse_timed()?;
        Ok(Studies {
            local_order: self.local_order()?,
            global_order: self.global_order()?,
            energy: self.energy()?,
            work_precision: self.work_precision()?,
            long_run: self.long_run()?,
            stability: self.stability()?,
            poincare: self.poincare()?,
            bifurcation: self.bifurcation()?,
            resonance: self.resonance()?,
            basins: self.basins()?,
            lyapunov: self.lyapunov()?,
            limit_cycle: self.limit_cycle()?,
        })
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
}
