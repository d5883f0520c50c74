//! Plans of the studies of errors, of energies and of cost.

use super::budget::{MOST_OUTPUT, MOST_TOLERANCES};
use super::methods::Methods;
use super::values::entry;
use super::{Planned, Planner};
use crate::scene::document::Spread;
use crate::scene::plan::{EnergyPlan, LocalOrderPlan, LongRunPlan, StepsPlan, WorkPrecisionPlan};
use crate::scene::problem::SceneProblem;
use afterbay_analysis::study::cell::Study;
use afterbay_analysis::study::global_order::GlobalOrder;
use afterbay_analysis::study::local_order::LocalOrder;
use afterbay_core::{Grid, InputError};
use afterbay_methods::registry::{ADAPTIVE, Row};

impl Planner<'_> {
    pub(super) fn local_order(&self) -> Planned<Option<LocalOrderPlan>> {
        let Some(table) = &self.document.study.local_order else { return Ok(None) };
        let (path, base_step) = ("study.local-order", table.base_step);
        let methods = self.fixed_methods(path, table.methods.as_ref())?;
        let steps = self.spread(&format!("{path}.steps"), &table.steps)?;
        let base = format!("{path}.base_step");
        let grid = self.base_grid(&base, base_step)?;
        for (i, &h) in steps.iter().enumerate() {
            let at = entry(path, &table.steps, i);
            match Grid::<f64>::new(base_step, h) {
                Err(InputError::NotAMultiple { .. }) => {
                    return self.refuse(&at, SceneProblem::OffGrid { step: h, base: base_step });
                }
                grid => self.within(&at, grid.map(drop))?,
            }
        }
        self.steps_fit(&base, grid.steps as f64 * (methods.len() * steps.len()) as f64)?;
        // The exact solution is stored along the grid.
        self.table_fits(&base, grid.steps, 3 * self.problem.model.dof() + 1)?;
        if steps.len() == 1 {
            return self.refuse(&format!("{path}.steps"), SceneProblem::OneStep);
        }
        Ok(Some(LocalOrderPlan { methods, study: LocalOrder { base_step, steps } }))
    }

    pub(super) fn global_order(&self) -> Planned<Option<StepsPlan>> {
        let Some(table) = &self.document.study.global_order else { return Ok(None) };
        let path = "study.global-order";
        let methods = self.fixed_methods(path, table.methods.as_ref())?;
        let plan = self.at_steps(path, methods, &table.steps)?;
        if plan.steps.len() == 1 {
            return self.refuse(&format!("{path}.steps"), SceneProblem::OneStep);
        }
        let (problem, StepsPlan { methods, steps }) = (self.problem, &plan);
        let reference = GlobalOrder { problem, methods, steps: steps.clone() }.shared_bytes();
        self.budget(
            &format!("{path}.steps"),
            "the reference in bytes",
            (reference, MOST_OUTPUT),
            "take larger steps, or steps each twice the one before",
        )?;
        Ok(Some(plan))
    }

    pub(super) fn energy(&self) -> Planned<Option<EnergyPlan>> {
        let Some(table) = &self.document.study.energy else { return Ok(None) };
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
        Ok(Some(EnergyPlan { methods, step, every }))
    }

    pub(super) fn work_precision(&self) -> Planned<Option<WorkPrecisionPlan>> {
        let Some(table) = &self.document.study.work_precision else { return Ok(None) };
        let path = "study.work-precision";
        // With tolerances, methods need not be named.
        let named = match &self.document.run {
            None if table.tolerances.is_some() && table.methods.is_none() => None,
            _ => Some(self.names(path, table.methods.as_ref())?),
        };
        let found = named.as_ref().map(|(at, names)| self.methods(at, names)).transpose()?;
        let Methods { fixed, mut adaptive } = found.unwrap_or_default();
        if table.tolerances.as_ref().is_some_and(Vec::is_empty) {
            let path = format!("{path}.tolerances");
            return self.refuse(&path, SceneProblem::Empty { what: "tolerance" });
        }
        if table.tolerances.is_none() {
            if let Some((at, names)) = named.filter(|_| table.methods.is_some() || fixed.is_empty())
            {
                self.none_adaptive(&at, names, &adaptive)?;
            }
            adaptive.clear();
        } else if adaptive.is_empty() {
            adaptive.extend(ADAPTIVE);
        }
        let StepsPlan { methods, steps } = match &table.steps {
            _ if fixed.is_empty() && adaptive.is_empty() => {
                return self.refuse(path, SceneProblem::NoMethods);
            }
            Some(_) if fixed.is_empty() => {
                let (key, why) = ("steps", "the methods choose their steps");
                let problem = SceneProblem::Misplaced { key, why };
                return self.refuse(&format!("{path}.steps"), problem);
            }
            Some(steps) => self.at_steps(path, fixed, steps)?,
            None if fixed.is_empty() => StepsPlan { methods: fixed, steps: Vec::new() },
            None => return self.refuse(path, SceneProblem::Missing { key: "steps".into() }),
        };
        let (tolerances, path) =
            (table.tolerances.clone().unwrap_or_default(), format!("{path}.tolerances"));
        let size = (tolerances.len() as f64, MOST_TOLERANCES);
        self.budget(&path, "the number of tolerances", size, "give fewer of them")?;
        for (i, &tolerance) in tolerances.iter().enumerate() {
            self.tolerance(&format!("{path}.{i}"), tolerance)?;
        }
        self.list(&path, &tolerances, |_| Ok(()))?;
        Ok(Some(WorkPrecisionPlan { methods, adaptive, steps, tolerances }))
    }

    pub(super) fn long_run(&self) -> Planned<Option<LongRunPlan>> {
        let Some(table) = &self.document.study.long_run else { return Ok(None) };
        let (path, count) = ("study.long-run", table.count);
        let methods = self.fixed_methods(path, table.methods.as_ref())?;
        let step = self.step(table.step)?;
        self.within(&format!("{path}.step"), Grid::<f64>::of(step, count))?;
        let at = format!("{path}.count");
        self.at_least_one(path, "count", count)?;
        self.steps_fit(&at, count as f64 * methods.len() as f64)?;
        let compensates = |row: &&Row| self.problem.model.bind_compensated::<f64>(row).is_ok();
        if table.compensated && !methods.iter().any(compensates) {
            let (key, why) = ("compensated", "none of the methods compensates roundings");
            let problem = SceneProblem::Misplaced { key, why };
            return self.refuse(&format!("{path}.compensated"), problem);
        }
        Ok(Some(LongRunPlan { methods, step, count, compensated: table.compensated }))
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
