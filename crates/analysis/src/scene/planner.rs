//! Plans from the tables of a scene.

mod budget;
mod dynamics;
mod events;
mod figures;
mod tangents;
mod values;

use super::document::{Document, Expression, ParameterTable, RunTable, Spacing, Spread};
use super::plan::{
    EnergyPlan, LocalOrderPlan, LongRunPlan, RunPlan, StabilityPlan, StepsPlan, Studies,
    WorkPrecisionPlan,
};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use crate::Model;
use crate::study::{Problem, local_order::LocalOrder, stability, trajectory};
use afterbay_core::{Grid, InputError, Tolerance};
use afterbay_methods::registry::{self, ADAPTIVE, METHODS, Row};
use budget::{MOST_CELLS, MOST_TOLERANCES};
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
        self.table_fits("run.every", self.steps / every, count * columns)?;
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
        self.table_fits(path, (self.problem.end / spacing) as u64, columns)?;
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

    fn stability(&self) -> Planned<Option<StabilityPlan>> {
        let Some(table) = &self.document.study.stability else { return Ok(None) };
        let path = "study.stability";
        let methods = self.fixed_methods(path, table.methods.as_ref())?;
        let mut steps = self.spread(&format!("{path}.steps"), &table.steps)?;
        let varied = &table.parameter;
        let mut values = self.parameter(&format!("{path}.parameter"), varied)?;
        steps.sort_by(f64::total_cmp);
        values.sort_by(f64::total_cmp);
        let cells = (steps.len() * values.len() * methods.len()) as f64;
        self.budget(
            path,
            "the number of cells",
            (cells, MOST_CELLS),
            "give fewer steps or values",
        )?;
        let end = table.end.unwrap_or(self.problem.end);
        if end <= 0.0 {
            return self.refuse(&format!("{path}.end"), InputError::End { end });
        }
        if let Some(finest) = steps.first() {
            let (size, change) = ((end / finest).ceil(), "take larger steps or an earlier end");
            self.budget(
                path,
                "the number of steps of a cell",
                (size, stability::MOST_STEPS),
                change,
            )?;
        }
        let all: f64 = steps.iter().map(|h| (end / h).ceil()).sum::<f64>()
            * (values.len() * methods.len()) as f64;
        self.steps_fit(path, all)?;
        let (parameter, spacing) = (varied.name.clone(), varied.scale);
        let step_spacing = match &table.steps {
            Spread::List(_) => Spacing::Log,
            Spread::Range(range) => range.scale,
        };
        Ok(Some(StabilityPlan { methods, steps, step_spacing, parameter, values, spacing, end }))
    }

    /// The values of a varied parameter, at each of which the system is valid.
    fn parameter(&self, named: &str, varied: &ParameterTable) -> Planned<Vec<f64>> {
        let ends = (varied.from, varied.to);
        let values = self.range(named, ends, varied.count, varied.scale, f64::NEG_INFINITY)?;
        let known = self.problem.model.parameters();
        if !known.contains(&varied.name.as_str()) {
            let known = known.into_iter().map(str::to_owned).collect();
            let problem =
                SceneProblem::Unknown { what: "parameter", name: varied.name.clone(), known };
            return self.refuse(&format!("{named}.name"), problem);
        }
        if let Some(other) = self.computed_from(&varied.name) {
            let problem = SceneProblem::Computed { name: varied.name.clone(), other };
            return self.refuse(&format!("{named}.name"), problem);
        }
        for value in &values {
            let model = self
                .problem
                .model
                .with(&varied.name, *value)
                .or_else(|error| self.refuse(named, error))?;
            self.within(named, model.system::<f64>().map(drop))?;
            if model.dof() != self.problem.model.dof() {
                let why =
                    "it changes the number of degrees of freedom, and with it the initial state";
                return self
                    .refuse(&format!("{named}.name"), SceneProblem::Misplaced { key: "n", why });
            }
        }
        Ok(values)
    }

    /// A parameter of a built-in system that is computed from this one when the scene is read. In a
    /// system of expressions it follows.
    fn computed_from(&self, name: &str) -> Option<String> {
        if matches!(self.problem.model, Model::Custom(_)) {
            return None;
        }
        let mentions = |text: &str| {
            text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(|word| word == name)
        };
        self.document.system.parameters.iter().find_map(|(other, value)| match value {
            Expression::Text(text) if mentions(text) => Some(other.clone()),
            _ => None,
        })
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

    /// The names of the methods of a study, which are those of [run] unless it has its own, and the
    /// path of their list.
    fn names<'n>(
        &'n self,
        path: &str,
        own: Option<&'n Vec<String>>,
    ) -> Planned<(String, &'n [String])> {
        match (own, &self.document.run) {
            (Some(names), _) => Ok((format!("{path}.methods"), names)),
            (None, Some(run)) => Ok(("run.methods".into(), &run.methods)),
            (None, None) => self.refuse(path, SceneProblem::NoMethods),
        }
    }

    /// The methods of a study at given steps. Methods of [run] that choose their steps are left
    /// out.
    fn fixed_methods(&self, path: &str, own: Option<&Vec<String>>) -> Planned<Vec<&'static Row>> {
        let (at, names) = self.names(path, own)?;
        let Methods { fixed, adaptive } = self.methods(&at, names)?;
        if own.is_some() {
            self.none_adaptive(&at, names, &adaptive)?;
        }
        if fixed.is_empty() { self.refuse(path, SceneProblem::NoMethods) } else { Ok(fixed) }
    }

    /// Refuses a method that chooses its steps where there is no tolerance.
    fn none_adaptive(&self, path: &str, names: &[String], found: &[&'static Row]) -> Planned<()> {
        let Some(row) = found.first() else { return Ok(()) };
        let at = names.iter().position(|name| name == row.name).unwrap_or(0);
        self.refuse(&format!("{path}.{at}"), SceneProblem::Adaptive { name: row.name })
    }

    /// Refuses names of no method, all at once.
    fn known(&self, path: &str, names: &[String]) -> Planned<()> {
        let is_unknown = |name: &&String| registry::find(name).is_none();
        let unknown: Vec<String> = names.iter().filter(is_unknown).cloned().collect();
        let Some(first) = names.iter().position(|name| is_unknown(&name)) else { return Ok(()) };
        let names_of_all = METHODS.iter().map(|row| row.name.to_owned());
        let known = names_of_all.filter(|name| !name.ends_with("-printed")).collect();
        let problem = match &unknown[..] {
            [name] => SceneProblem::Unknown { what: "method", name: name.clone(), known },
            _ => SceneProblem::UnknownMethods { names: unknown, known },
        };
        self.refuse(&format!("{path}.{first}"), problem)
    }

    /// Refuses a method that does not apply to the system, and names those that do.
    fn applies(&self, path: &str, row: &'static Row) -> Planned<()> {
        let model = &self.problem.model;
        match model.bind(row) {
            Err(error @ InputError::Unsupported { .. }) => {
                let others = METHODS.iter().filter(|row| model.bind(row).is_ok());
                let others = others.map(|row| row.name).collect();
                self.refuse(path, SceneProblem::Unsupported { error, others })
            }
            bound => self.within(path, bound.map(drop)),
        }
    }

    /// The rows of the named methods, if all apply.
    fn methods(&self, path: &str, names: &[String]) -> Planned<Methods> {
        self.known(path, names)?;
        let mut found = Methods { fixed: Vec::new(), adaptive: Vec::new() };
        for (i, name) in names.iter().enumerate() {
            let path = format!("{path}.{i}");
            let Some(row) = registry::find(name) else { continue };
            let rows = if row.is_adaptive() { &mut found.adaptive } else { &mut found.fixed };
            if rows.iter().any(|other| other.name == row.name) {
                return self.refuse(&path, SceneProblem::Twice { name: name.clone() });
            }
            rows.push(row);
            self.applies(&path, row)?;
        }
        if names.is_empty() {
            self.refuse(path, SceneProblem::Empty { what: "method" })
        } else {
            Ok(found)
        }
    }
}

/// Methods of a scene.
struct Methods {
    /// Those that take a step.
    fixed: Vec<&'static Row>,
    /// Those that choose their steps.
    adaptive: Vec<&'static Row>,
}
