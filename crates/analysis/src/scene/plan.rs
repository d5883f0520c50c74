//! What a scene asks for, checked: methods that exist and apply, steps that lead to the end,
//! nothing larger than the budget.

use super::document::{Document, Spacing, Spread};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use crate::study::{Problem, local_order::LocalOrder, stability, trajectory};
use afterbay_core::{Grid, InputError, Tolerance};
use afterbay_methods::registry::{self, FIXED, Row};
use std::collections::HashSet;

/// The most steps of a run, and of all runs of a study.
const MOST_STEPS: f64 = 1e11;
/// The most bytes of a table.
const MOST_OUTPUT: f64 = 1e9;
/// Bytes of a number in a table, its separator included.
const BYTES: f64 = 20.0;
/// States kept where a scene does not say how many.
const KEPT: u64 = 10_000;
/// The most values of a spread, and the most cells of a map.
const MOST_VALUES: u64 = 100_000;
const MOST_CELLS: f64 = 1e6;
/// The most tolerances: each is a run of an unknown number of steps.
const MOST_TOLERANCES: f64 = 1000.0;

/// Trajectories.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// Every so many steps a state is kept.
    pub every: u64,
    /// What adaptive collocation is to meet.
    pub tolerance: Option<f64>,
}

/// The studies a scene declares.
#[derive(Clone, Debug, Default)]
pub struct Studies {
    /// Local errors and orders.
    pub local_order: Option<LocalOrderPlan>,
    /// Global errors and orders.
    pub global_order: Option<StepsPlan>,
    /// The energy books.
    pub energy: Option<EnergyPlan>,
    /// Work against precision.
    pub work_precision: Option<WorkPrecisionPlan>,
    /// Stability.
    pub stability: Option<StabilityPlan>,
    /// Growth of the deviation of K.
    pub long_run: Option<LongRunPlan>,
}

impl Studies {
    /// Is there none?
    pub fn is_empty(&self) -> bool {
        let Self { local_order, global_order, energy, work_precision, stability, long_run } = self;
        local_order.is_none()
            && global_order.is_none()
            && energy.is_none()
            && work_precision.is_none()
            && stability.is_none()
            && long_run.is_none()
    }
}

/// Local errors and orders.
#[derive(Clone, Debug)]
pub struct LocalOrderPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The base grid and the steps.
    pub study: LocalOrder,
}

/// Methods at steps.
#[derive(Clone, Debug)]
pub struct StepsPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, in the order of the scene.
    pub steps: Vec<f64>,
}

/// Work against precision.
#[derive(Clone, Debug)]
pub struct WorkPrecisionPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, in the order of the scene.
    pub steps: Vec<f64>,
    /// What adaptive collocation is to meet.
    pub tolerances: Vec<f64>,
}

/// The energy books.
#[derive(Clone, Debug)]
pub struct EnergyPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The step.
    pub step: f64,
    /// Every so many steps a row is kept.
    pub every: u64,
}

/// A map of stability.
#[derive(Clone, Debug)]
pub struct StabilityPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps, ascending.
    pub steps: Vec<f64>,
    /// How they are spaced; a list counts as spaced by ratios.
    pub step_spacing: Spacing,
    /// The parameter that is varied.
    pub parameter: String,
    /// Its values, ascending.
    pub values: Vec<f64>,
    /// How they are spaced.
    pub spacing: Spacing,
    /// The time of a run.
    pub end: f64,
}

/// Growth of the deviation of K.
#[derive(Clone, Debug)]
pub struct LongRunPlan {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The step.
    pub step: f64,
    /// The number of steps.
    pub count: u64,
    /// Are they also run with roundings that do not add up?
    pub compensated: bool,
}

/// Makes plans of tables.
pub(super) struct Planner<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) document: &'a Document,
    pub(super) problem: &'a Problem,
    /// The steps of a run.
    pub(super) steps: u64,
}

type Planned<T> = Result<T, SceneError>;

impl Planner<'_> {
    fn refuse<T>(&self, path: &str, problem: impl Into<SceneProblem>) -> Planned<T> {
        Err(SceneError { problem: problem.into(), span: self.source.span(path) })
    }

    fn within<T>(&self, path: &str, result: Result<T, InputError>) -> Planned<T> {
        result.or_else(|error| self.refuse(path, error))
    }

    fn budget(
        &self,
        path: &str,
        what: &'static str,
        (size, limit): (f64, f64),
        change: &'static str,
    ) -> Planned<()> {
        if size <= limit {
            return Ok(());
        }
        self.refuse(path, SceneProblem::Budget { what, size, limit, change })
    }

    pub(super) fn run(&self) -> Planned<Option<RunPlan>> {
        let Some(table) = &self.document.run else { return Ok(None) };
        let methods = self.methods("run.methods", &table.methods)?;
        let every = self.every("run.every", table.every, self.steps)?;
        self.steps_fit("time.step", self.steps as f64 * methods.len() as f64)?;
        let columns = trajectory::columns(self.problem.model.dof()).len();
        self.table_fits("run.every", self.steps / every, methods.len() * columns)?;
        if let Some(tolerance) = table.tolerance {
            self.within("run.tolerance", Tolerance::all(tolerance).check::<f64>())?;
        }
        Ok(Some(RunPlan { methods, every, tolerance: table.tolerance }))
    }

    pub(super) fn studies(&self) -> Planned<Studies> {
        let tables = &self.document.study;
        let mut studies = Studies::default();
        if let Some(table) = &tables.local_order {
            let path = "study.local-order";
            let methods = self.own_methods(path, table.methods.as_ref())?;
            let steps = self.spread(&format!("{path}.steps"), &table.steps)?;
            let base = format!("{path}.base_step");
            let grid = self.within(&base, Grid::<f64>::new(table.base_step, self.problem.end))?;
            for (i, &h) in steps.iter().enumerate() {
                self.within(
                    &self.entry(path, &table.steps, i),
                    Grid::<f64>::new(table.base_step, h),
                )?;
            }
            self.steps_fit(&base, grid.steps as f64 * (methods.len() * steps.len()) as f64)?;
            // The exact solution is kept along the grid.
            self.table_fits(&base, grid.steps, 3 * self.problem.model.dof() + 1)?;
            studies.local_order = Some(LocalOrderPlan {
                methods,
                study: LocalOrder { base_step: table.base_step, steps },
            });
        }
        if let Some(table) = &tables.global_order {
            let plan = self.at_steps("study.global-order", table.methods.as_ref(), &table.steps)?;
            studies.global_order = Some(plan);
        }
        if let Some(table) = &tables.energy {
            let path = "study.energy";
            let methods = self.own_methods(path, table.methods.as_ref())?;
            let step = table.step.unwrap_or(self.document.time.step);
            let grid =
                self.within(&format!("{path}.step"), Grid::<f64>::new(step, self.problem.end))?;
            let every = self.every(&format!("{path}.every"), table.every, grid.steps)?;
            self.steps_fit(path, grid.steps as f64 * methods.len() as f64)?;
            let dof = self.problem.model.dof();
            self.table_fits(path, grid.steps / every, methods.len() * (8 + dof))?;
            // The exact solution is kept at every step.
            self.table_fits(path, grid.steps, 3 * dof + 1)?;
            studies.energy = Some(EnergyPlan { methods, step, every });
        }
        if let Some(table) = &tables.work_precision {
            let path = "study.work-precision";
            let StepsPlan { methods, steps } =
                self.at_steps(path, table.methods.as_ref(), &table.steps)?;
            let (tolerances, path) = (table.tolerances.clone(), format!("{path}.tolerances"));
            let size = (tolerances.len() as f64, MOST_TOLERANCES);
            self.budget(&path, "the number of tolerances", size, "give fewer of them")?;
            self.list(&path, &tolerances, |tolerance| Tolerance::all(tolerance).check::<f64>())?;
            studies.work_precision = Some(WorkPrecisionPlan { methods, steps, tolerances });
        }
        if let Some(table) = &tables.long_run {
            let path = "study.long-run";
            let methods = self.own_methods(path, table.methods.as_ref())?;
            let step = table.step.unwrap_or(self.document.time.step);
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
        Ok(studies)
    }

    fn stability(&self) -> Planned<Option<StabilityPlan>> {
        let Some(table) = &self.document.study.stability else { return Ok(None) };
        let path = "study.stability";
        let methods = self.own_methods(path, table.methods.as_ref())?;
        let mut steps = self.spread(&format!("{path}.steps"), &table.steps)?;
        let (varied, named) = (&table.parameter, format!("{path}.parameter"));
        let mut values = self.range(
            &named,
            (varied.from, varied.to),
            varied.count,
            varied.scale,
            f64::NEG_INFINITY,
        )?;
        steps.sort_by(f64::total_cmp);
        values.sort_by(f64::total_cmp);
        let known = self.problem.model.parameters();
        if !known.contains(&varied.name.as_str()) {
            let known = known.into_iter().map(str::to_owned).collect();
            let problem =
                SceneProblem::Unknown { what: "parameter", name: varied.name.clone(), known };
            return self.refuse(&format!("{named}.name"), problem);
        }
        let cells = (steps.len() * values.len() * methods.len()) as f64;
        self.budget(
            path,
            "the number of cells",
            (cells, MOST_CELLS),
            "give fewer steps or values",
        )?;
        for value in &values {
            let model = self
                .problem
                .model
                .with(&varied.name, *value)
                .or_else(|error| self.refuse(&named, error))?;
            self.within(&named, model.system::<f64>().map(drop))?;
            if model.dof() != self.problem.model.dof() {
                let why =
                    "it changes the number of degrees of freedom, and with it the initial state";
                return self
                    .refuse(&format!("{named}.name"), SceneProblem::Misplaced { key: "n", why });
            }
        }
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

    fn at_steps(
        &self,
        path: &str,
        methods: Option<&Vec<String>>,
        steps: &Spread,
    ) -> Planned<StepsPlan> {
        let methods = self.own_methods(path, methods)?;
        let spread = self.spread(&format!("{path}.steps"), steps)?;
        let mut all = 0.0;
        for (i, &h) in spread.iter().enumerate() {
            let grid =
                self.within(&self.entry(path, steps, i), Grid::<f64>::new(h, self.problem.end))?;
            all += grid.steps as f64 * methods.len() as f64;
        }
        self.steps_fit(&format!("{path}.steps"), all)?;
        Ok(StepsPlan { methods, steps: spread })
    }

    /// The path of a step in a spread.
    fn entry(&self, path: &str, steps: &Spread, i: usize) -> String {
        match steps {
            Spread::List(_) => format!("{path}.steps.{i}"),
            Spread::Range(_) => format!("{path}.steps"),
        }
    }

    fn own_methods(&self, path: &str, own: Option<&Vec<String>>) -> Planned<Vec<&'static Row>> {
        match (own, &self.document.run) {
            (Some(names), _) => self.methods(&format!("{path}.methods"), names),
            (None, Some(run)) => self.methods("run.methods", &run.methods),
            (None, None) => self.refuse(path, SceneProblem::NoMethods),
        }
    }

    /// The rows of methods that apply.
    fn methods(&self, path: &str, names: &[String]) -> Planned<Vec<&'static Row>> {
        let mut rows: Vec<&'static Row> = Vec::with_capacity(names.len());
        for (i, name) in names.iter().enumerate() {
            let path = format!("{path}.{i}");
            let Some(row) = registry::find(name) else {
                let known = FIXED.iter().map(|row| row.name.to_owned()).collect();
                return self.refuse(
                    &path,
                    SceneProblem::Unknown { what: "method", name: name.clone(), known },
                );
            };
            if row.is_adaptive() {
                return self.refuse(&path, SceneProblem::Adaptive { name: row.name });
            }
            if rows.iter().any(|other| other.name == row.name) {
                return self.refuse(&path, SceneProblem::Twice { name: name.clone() });
            }
            self.within(&path, self.problem.model.bind(row).map(drop))?;
            rows.push(row);
        }
        if rows.is_empty() {
            self.refuse(path, SceneProblem::Empty { what: "method" })
        } else {
            Ok(rows)
        }
    }

    /// The values of a spread of steps.
    fn spread(&self, path: &str, spread: &Spread) -> Planned<Vec<f64>> {
        match spread {
            Spread::List(list) if list.is_empty() => {
                self.refuse(path, SceneProblem::Empty { what: "step" })
            }
            Spread::List(list) => {
                self.list(path, list, |h| Grid::<f64>::of(h, 1).map(drop))?;
                Ok(list.clone())
            }
            Spread::Range(range) => {
                self.range(path, (range.from, range.to), range.count, range.scale, 0.0)
            }
        }
    }

    /// Every value is what it has to be, and there once.
    fn list(
        &self,
        path: &str,
        list: &[f64],
        check: impl Fn(f64) -> Result<(), InputError>,
    ) -> Planned<()> {
        let mut seen = HashSet::new();
        for (i, &x) in list.iter().enumerate() {
            let path = format!("{path}.{i}");
            self.within(&path, check(x))?;
            if !seen.insert(x.to_bits()) {
                return self.refuse(&path, SceneProblem::Twice { name: x.to_string() });
            }
        }
        Ok(())
    }

    /// `count` values from `from` to `to`, all of them above `above`.
    fn range(
        &self,
        path: &str,
        (from, to): (f64, f64),
        count: u64,
        scale: Spacing,
        above: f64,
    ) -> Planned<Vec<f64>> {
        let refuse = |key: &'static str, value: f64, range: &'static str| {
            self.refuse(&format!("{path}.{key}"), SceneProblem::Range { name: key, value, range })
        };
        if !(1..=MOST_VALUES).contains(&count) {
            return refuse("count", count as f64, "from 1 to 100000");
        }
        if count > 1 && from == to {
            return refuse("to", to, "another value than `from`, where there is more than one");
        }
        for (key, value) in [("from", from), ("to", to)] {
            if scale == Spacing::Log && value <= 0.0 {
                return refuse(key, value, "positive where the scale is \"log\"");
            }
            if value <= above {
                return refuse(key, value, "positive");
            }
        }
        let share = |i: u64| if count > 1 { i as f64 / (count - 1) as f64 } else { 0.0 };
        let at = |i: u64| match scale {
            // The ends are what the scene says, to the bit.
            _ if i == 0 => from,
            _ if i + 1 == count => to,
            Spacing::Log => from * (to / from).powf(share(i)),
            Spacing::Linear => from + (to - from) * share(i),
        };
        Ok((0..count).map(at).collect())
    }

    fn every(&self, path: &str, every: Option<u64>, steps: u64) -> Planned<u64> {
        match every {
            Some(0) => self.refuse(
                path,
                SceneProblem::Range { name: "every", value: 0.0, range: "at least 1" },
            ),
            Some(every) => Ok(every),
            None => Ok(steps.div_ceil(KEPT).max(1)),
        }
    }

    fn steps_fit(&self, path: &str, steps: f64) -> Planned<()> {
        self.budget(
            path,
            "the number of steps",
            (steps, MOST_STEPS),
            "take larger steps, fewer of them, or an earlier end",
        )
    }

    fn table_fits(&self, path: &str, rows: u64, numbers: usize) -> Planned<()> {
        let size = (rows as f64 + 1.0) * numbers as f64 * BYTES;
        self.budget(
            path,
            "the output in bytes",
            (size, MOST_OUTPUT),
            "keep fewer states with `every`, or take larger steps",
        )
    }
}
