//! Plans of the studies of tangent vectors: Lyapunov exponents, and cycles with their multipliers.

use super::dynamics::{Common, Settings};
use super::{Planned, Planner};
use crate::scene::problem::SceneProblem;
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::limit_cycle::{Branch, LimitCycle};
use afterbay_analysis::study::lyapunov::{self, Lyapunov};

/// The default number of rows of each method.
const ROWS: u64 = 50;
/// The most rows of each method.
const MOST_ROWS: u64 = 10_000;
/// The cost of a step in 106 bits, in steps.
const QUAD: f64 = 10.0;

impl Planner<'_> {
    pub(super) fn lyapunov(&self) -> Planned<Option<DynamicsPlan<Lyapunov>>> {
        let Some(table) = &self.document.study.lyapunov else { return Ok(None) };
        let path = "study.lyapunov";
        let common = Common::new(path, &table.methods, &table.steps, table.reference);
        let Settings { methods, steps, reference, .. } = self.settings(&common)?;
        let transient = self.duration(path, "transient", table.transient)?;
        let time = self.duration(path, "time", table.time)?;
        let (rows, problem) = (table.rows.unwrap_or(ROWS), self.problem.clone());
        let longest = steps.iter().copied().fold(0.0, f64::max);
        if !(1..=MOST_ROWS).contains(&rows) || time / (rows as f64) < longest {
            let range = "from 1 to 10000, with a step between two rows";
            let problem = SceneProblem::Range { name: "rows", value: rows as f64, range };
            return self.refuse(&format!("{path}.rows"), problem);
        }
        let model = &self.problem.model;
        let study = Lyapunov { problem, transient, time, rows };
        let plan = DynamicsPlan { methods, steps, reference, study };
        let derivative = QUAD * (2 * model.degrees() + 1) as f64;
        let of_one = |h: f64| (transient + derivative * time) / h;
        self.steps_fit(path, plan.settings().map(|(_, h)| of_one(h)).sum())?;
        let all = plan.settings().count() as u64 * rows;
        self.table_fits(&format!("{path}.rows"), all, lyapunov::columns(model).len())?;
        Ok(Some(plan))
    }

    pub(super) fn limit_cycle(&self) -> Planned<Option<DynamicsPlan<LimitCycle>>> {
        let Some(table) = &self.document.study.limit_cycle else { return Ok(None) };
        let path = "study.limit-cycle";
        let common = Common::new(path, &table.methods, &table.steps, table.reference);
        let Settings { methods, steps, reference, .. } = self.settings(&common)?;
        let transient = self.duration(path, "transient", table.transient)?;
        let (key, at) = ("periods", format!("{path}.periods"));
        match table.periods {
            Some(_) if self.problem.model.motors().is_empty() => {
                let why = "the system does not depend on the time: declare a drive in [drive]";
                return self.refuse(&at, SceneProblem::Misplaced { key, why });
            }
            Some(count) => self.at_least_one(path, key, count)?,
            None => {}
        }
        let branch = match &table.parameter {
            None => None,
            Some(of) => {
                let at = format!("{path}.parameter");
                for value in [of.from, of.to] {
                    self.varied(&at, &of.name, value)?;
                }
                if of.from == of.to {
                    let range = "another value than `from`";
                    let problem = SceneProblem::Range { name: "to", value: of.to, range };
                    return self.refuse(&format!("{at}.to"), problem);
                }
                let (parameter, doublings) = (of.name.clone(), of.doublings);
                Some(Branch { parameter, from: of.from, to: of.to, doublings })
            }
        };
        let (problem, multiple) = (self.problem.clone(), table.periods);
        let study = LimitCycle { problem, transient, multiple, branch };
        let plan = DynamicsPlan { methods, steps, reference, study };
        self.steps_fit(path, plan.settings().map(|(_, h)| 2.0 * transient / h).sum())?;
        Ok(Some(plan))
    }

    /// A time of a table, else the end of time of the scene.
    fn duration(&self, path: &str, name: &'static str, given: Option<f64>) -> Planned<f64> {
        self.positive(path, name, given.unwrap_or(self.problem.end))
    }
}
