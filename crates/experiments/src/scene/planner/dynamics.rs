//! Plans of the studies of driven and self-excited systems.

use super::budget::{BYTES, MOST_CELLS, MOST_OUTPUT, MOST_STEPS};
use super::{Planned, Planner};
use crate::claim::in_full;
use crate::scene::document::{SectionTable, Spread};
use crate::scene::problem::{SceneError, SceneProblem};
use afterbay_analysis::Model;
use afterbay_analysis::Observable;
use afterbay_analysis::study::basins::{Axis, Basins};
use afterbay_analysis::study::bifurcation::{self, Bifurcation};
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::poincare::{self, Poincare};
use afterbay_analysis::study::resonance::Resonance;
use afterbay_analysis::study::section::{Crossing, Direction, LEAST_STEPS, Section, is_multiple};
use afterbay_analysis::{Spacing, Variable};
use afterbay_methods::registry::Row;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use std::collections::HashSet;

/// The ratio of the shortest step of the methods to the step of the reference. A choice.
const FINER: f64 = 2.0;
/// The steps between two crossings of a section, for the budget. Their number is not known.
const STEPS_BETWEEN: f64 = 100.0;
/// Default numbers of states.
const POINCARE: [u64; 2] = [100, 1000];
const BIFURCATION: [u64; 2] = [200, 100];
const RESONANCE: [u64; 2] = [200, 4];
/// Default number of intervals of a run, and the interval where there is no drive.
const LONGEST: u64 = 1000;
const INTERVAL: f64 = 1.0;

/// The keys that the tables of these studies have in common.
pub(super) struct Common<'a> {
    pub(super) path: &'a str,
    pub(super) methods: Option<&'a Vec<String>>,
    pub(super) steps: Option<&'a Spread>,
    pub(super) section: Option<&'a SectionTable>,
    pub(super) interval: Option<f64>,
    pub(super) reference: Option<bool>,
}

impl<'a> Common<'a> {
    /// The keys of a table without a section and an interval.
    pub(super) fn new(
        path: &'a str,
        methods: &'a Option<Vec<String>>,
        steps: &'a Option<Spread>,
        reference: Option<bool>,
    ) -> Self {
        let (methods, steps) = (methods.as_ref(), steps.as_ref());
        Self { path, methods, steps, section: None, interval: None, reference }
    }
}

/// The methods of a study, their steps, the step of the reference if there is one, and the section.
pub(super) struct Settings {
    pub(super) methods: Vec<&'static Row>,
    pub(super) steps: Vec<f64>,
    pub(super) reference: Option<f64>,
    pub(super) section: Section,
}

impl Planner<'_> {
    pub(super) fn poincare(&self) -> Planned<Option<DynamicsPlan<Poincare>>> {
        let Some(table) = &self.document.study.poincare else { return Ok(None) };
        let path = "study.poincare";
        let common = Common {
            section: table.section.as_ref(),
            interval: table.interval,
            ..Common::new(path, &table.methods, &table.steps, table.reference)
        };
        let Settings { methods, steps, reference, section } = self.settings(&common)?;
        let (at, given) = ((path, "points"), [table.transient, table.points]);
        let [transient, points] = self.returns(at, given, POINCARE)?;
        let starts = self.starts(path, table.starts.unwrap_or(1), table.spread)?;
        let problem = self.problem.clone();
        let runs = starts.len() as f64;
        let study = Poincare { problem, section, starts, transient, points };
        let plan = DynamicsPlan { methods, steps, reference, study };
        let model = &self.problem.model;
        self.effort(path, &plan, &plan.study.section, runs * (transient + points) as f64, model)?;
        let rows = plan.settings().count() as f64 * runs * points as f64;
        self.rows_fit(path, rows, poincare::columns(model).len())?;
        Ok(Some(plan))
    }

    pub(super) fn bifurcation(&self) -> Planned<Option<DynamicsPlan<Bifurcation>>> {
        let Some(table) = &self.document.study.bifurcation else { return Ok(None) };
        let path = "study.bifurcation";
        let common = Common {
            section: table.section.as_ref(),
            interval: table.interval,
            ..Common::new(path, &table.methods, &table.steps, table.reference)
        };
        let Settings { methods, steps, reference, section } = self.settings(&common)?;
        let named = format!("{path}.parameter");
        let values = self.parameter(&named, &table.parameter)?;
        let (at, given) = ((path, "points"), [table.transient, table.points]);
        let [transient, points] = self.returns(at, given, BIFURCATION)?;
        let (parameter, follow) = (table.parameter.name.clone(), table.follow);
        let spacing: Spacing = table.parameter.scale;
        let problem = self.problem.clone();
        let study =
            Bifurcation { problem, section, parameter, values, spacing, transient, points, follow };
        let plan = DynamicsPlan { methods, steps, reference, study };
        let ways = if follow { 2.0 } else { 1.0 };
        let returns = ways * (transient + points) as f64;
        for &value in &plan.study.values {
            let model = self.varied(&named, &plan.study.parameter, value)?;
            self.check_interval(path, &plan.study.section, &model)
                .map_err(|error| self.at_value(&named, &plan.study.parameter, value, error))?;
            let all = returns * plan.study.values.len() as f64;
            self.effort(path, &plan, &plan.study.section, all, &model)?;
        }
        let values = plan.study.values.len() as f64;
        let rows = plan.settings().count() as f64 * ways * values * points as f64;
        self.rows_fit(path, rows, bifurcation::columns(&self.problem.model).len())?;
        Ok(Some(plan))
    }

    /// An error at one value of the parameter of a study, which stands at `named`.
    fn at_value(&self, named: &str, name: &str, value: f64, error: SceneError) -> SceneError {
        let at = format!("{name} = {}", in_full(value));
        let problem = SceneProblem::AtPoint { at, problem: Box::new(error.problem) };
        SceneError { problem, span: self.source.span(named) }
    }

    pub(super) fn resonance(&self) -> Planned<Option<DynamicsPlan<Resonance>>> {
        let Some(table) = &self.document.study.resonance else { return Ok(None) };
        let path = "study.resonance";
        if self.problem.model.driven().is_empty() {
            let why = match self.document.drive {
                Some(_) => "every force in [drive] is 0",
                None => "the system has no drive: declare one in [drive]",
            };
            let key = "resonance";
            return self.refuse(path, SceneProblem::Misplaced { key, why });
        }
        let common = Common::new(path, &table.methods, &table.steps, table.reference);
        let Settings { methods, steps, reference, section } = self.settings(&common)?;
        let (named, name) = (format!("{path}.parameter"), table.parameter.name.clone());
        let values = self.parameter(&named, &table.parameter)?;
        let (at, given) = ((path, "periods"), [table.transient, table.periods]);
        let [transient, periods] = self.returns(at, given, RESONANCE)?;
        let (problem, spacing) = (self.problem.clone(), table.parameter.scale);
        let mut lengths = Vec::new();
        for &value in &values {
            let model = self.varied(&named, &name, value)?;
            self.check_interval(path, &section, &model)
                .map_err(|error| self.at_value(&named, &name, value, error))?;
            lengths.push(section.interval(&model));
        }
        if lengths.len() > 1 && lengths.iter().all(|length| *length == lengths[0]) {
            let why = "it does not change the period of the drive";
            return self.refuse(&format!("{named}.name"), SceneProblem::NotVaried { name, why });
        }
        let study = Resonance { problem, parameter: name, values, spacing, transient, periods };
        let plan = DynamicsPlan { methods, steps, reference, study };
        let returns = 2.0 * (transient + periods) as f64 * plan.study.values.len() as f64;
        self.effort(path, &plan, &section, returns, &self.problem.model)?;
        Ok(Some(plan))
    }

    pub(super) fn basins(&self) -> Planned<Option<DynamicsPlan<Basins>>> {
        let Some(table) = &self.document.study.basins else { return Ok(None) };
        let path = "study.basins";
        let model = &self.problem.model;
        let autonomous = model.dof() == model.degrees();
        let common = Common {
            interval: table.interval.or(autonomous.then_some(INTERVAL)),
            ..Common::new(path, &table.methods, &table.steps, table.reference)
        };
        let Settings { methods, steps, reference, section } = self.settings(&common)?;
        let grid = format!("{path}.grid");
        let axes = table.grid.iter().map(|(name, range)| {
            let path = format!("{grid}.{name}");
            let (variable, dof) = self.entry(&path, name)?;
            let ends = (range.from, range.to);
            let mut values =
                self.range(&path, ends, range.count, range.scale, f64::NEG_INFINITY)?;
            values.sort_by(f64::total_cmp);
            Ok(Axis { variable, dof, values })
        });
        let mut axes = axes.collect::<Planned<Vec<_>>>()?;
        // A coordinate is the horizontal axis, whatever the order of the names.
        axes.sort_by_key(|axis| axis.variable != Variable::Q);
        let Ok(axes) = <[Axis; 2]>::try_from(axes) else {
            return self.refuse(&grid, SceneProblem::TwoAxes);
        };
        let longest = table.longest.unwrap_or(LONGEST);
        self.at_least_one(path, "longest", longest)?;
        let cells = axes[0].values.len() as f64 * axes[1].values.len() as f64;
        let study = Basins { problem: self.problem.clone(), section, axes, longest };
        let plan = DynamicsPlan { methods, steps, reference, study };
        let all = cells * plan.settings().count() as f64;
        self.budget(path, "the number of cells", (all, MOST_CELLS), "give fewer values or steps")?;
        self.effort(path, &plan, &plan.study.section, cells * longest as f64, model)?;
        Ok(Some(plan))
    }

    pub(super) fn settings(&self, common: &Common<'_>) -> Planned<Settings> {
        let path = common.path;
        let methods = self.fixed_methods(path, common.methods)?;
        let mut steps = match common.steps {
            Some(steps) => self.spread(&format!("{path}.steps"), steps)?,
            None => vec![self.step(None)?],
        };
        let section = self.section(common)?;
        let model = &self.problem.model;
        self.check_interval(path, &section, model)?;
        // Two steps may become the same whole division of the interval.
        let mut seen = HashSet::new();
        steps
            .retain(|&h| section.grid(model, h).map_or(true, |grid| seen.insert(grid.h.to_bits())));
        let least = steps.iter().copied().fold(f64::INFINITY, f64::min) / FINER;
        let finest = section.interval(model).map_or(least, |all| least.min(all / LEAST_STEPS));
        let reference = common.reference.unwrap_or(true).then_some(finest);
        Ok(Settings { methods, steps, reference, section })
    }

    fn section(&self, common: &Common<'_>) -> Planned<Section> {
        let (path, model) = (common.path, &self.problem.model);
        match (common.section, common.interval) {
            (Some(_), Some(_)) => {
                let (key, why) = ("interval", "`section` says when a state is taken");
                self.refuse(&format!("{path}.interval"), SceneProblem::Misplaced { key, why })
            }
            (Some(table), None) => self.crossing(&format!("{path}.section"), table),
            (None, Some(interval)) => {
                let interval = Some(self.positive(path, "interval", interval)?);
                Ok(Section::Stroboscopic { interval })
            }
            (None, None) if model.dof() > model.degrees() => {
                Ok(Section::Stroboscopic { interval: None })
            }
            (None, None) => {
                let (variable, dof, value) = (Variable::P, 0, 0.0);
                let direction = Direction::Falling;
                Ok(Section::Crossing(Crossing { variable, dof, value, direction }))
            }
        }
    }

    fn crossing(&self, path: &str, table: &SectionTable) -> Planned<Section> {
        let SectionTable { of, value, direction } = table;
        let (value, direction) = (*value, *direction);
        if !value.is_finite() {
            return self.refuse(&format!("{path}.value"), SceneProblem::NotFinite { value });
        }
        let (variable, dof) = self.entry(&format!("{path}.of"), of)?;
        Ok(Section::Crossing(Crossing { variable, dof, value, direction }))
    }

    /// The coordinate or momentum of a name.
    fn entry(&self, path: &str, name: &str) -> Planned<(Variable, usize)> {
        match Observable::parse(name, &self.problem.model) {
            Some(Observable::Of(variable @ (Variable::Q | Variable::P), dof)) => {
                Ok((variable, dof))
            }
            _ => {
                let n = self.problem.model.degrees();
                let known = ["q", "p"].iter().flat_map(|x| (1..=n).map(move |j| format!("{x}{j}")));
                let (what, name) = ("coordinate or momentum", name.to_owned());
                let known = known.collect();
                self.refuse(path, SceneProblem::Unknown { what, name, known })
            }
        }
    }

    /// Checks that a stroboscopic section has an interval, after which the drive repeats.
    fn check_interval(&self, path: &str, section: &Section, model: &Model) -> Planned<()> {
        let Section::Stroboscopic { interval } = section else { return Ok(()) };
        if model.dof() == model.degrees() {
            return Ok(());
        }
        let Some(period) = model.drive_period() else {
            return self.refuse(path, SceneProblem::NoPeriod);
        };
        match interval {
            Some(interval) if !is_multiple(*interval, period) => {
                let problem = SceneProblem::OffPeriod { interval: *interval, period };
                self.refuse(&format!("{path}.interval"), problem)
            }
            _ => Ok(()),
        }
    }

    /// The numbers of states that are not kept, and that are kept.
    fn returns(
        &self,
        (path, name): (&str, &'static str),
        given: [Option<u64>; 2],
        unless: [u64; 2],
    ) -> Planned<[u64; 2]> {
        let [transient, points] = [0, 1].map(|k| given[k].unwrap_or(unless[k]));
        self.at_least_one(path, name, points)?;
        Ok([transient, points])
    }

    /// The initial states of runs: the scene's, and others around it.
    fn starts(&self, path: &str, count: u64, spread: Option<f64>) -> Planned<Vec<[Vec<f64>; 2]>> {
        const MOST: u64 = 100_000;
        if !(1..=MOST).contains(&count) {
            let (name, value, range) = ("starts", count as f64, "from 1 to 100000");
            return self
                .refuse(&format!("{path}.starts"), SceneProblem::Range { name, value, range });
        }
        let spread = match spread {
            Some(spread) => self.positive(path, "spread", spread)?,
            None if count > 1 => {
                return self.refuse(path, SceneProblem::Missing { key: "spread".into() });
            }
            None => 0.0,
        };
        let (q, p) = (&self.problem.q, &self.problem.p);
        let start = |i: u64| {
            // A stream of its own, so that a start is the same however many there are.
            let mut random = Pcg64::new(0, u128::from(i));
            let mut place = |x: &f64| {
                let share = (random.next_u64() >> 11) as f64 * 2f64.powi(-53);
                if i == 0 { *x } else { x + spread * (2.0 * share - 1.0) }
            };
            [q, p].map(|part| part.iter().map(&mut place).collect::<Vec<_>>())
        };
        Ok((0..count).map(start).collect())
    }

    /// Refuses more steps than the budget has.
    fn effort<S>(
        &self,
        path: &str,
        plan: &DynamicsPlan<S>,
        section: &Section,
        returns: f64,
        model: &Model,
    ) -> Planned<()> {
        let between = |h: f64| section.interval(model).map_or(STEPS_BETWEEN, |all| all / h);
        let steps: f64 = plan.settings().map(|(_, h)| between(h)).sum();
        let change = "take larger steps, fewer values or points, or shorter transients";
        let size = returns * steps * self.points as f64;
        self.budget(path, "the number of steps", (size, MOST_STEPS), change)
    }

    /// Refuses a table of too many bytes.
    fn rows_fit(&self, path: &str, rows: f64, columns: usize) -> Planned<()> {
        let size = rows * columns as f64 * BYTES * self.points as f64;
        let change = "take fewer points";
        self.budget(&format!("{path}.points"), "the output in bytes", (size, MOST_OUTPUT), change)
    }
}
