//! The map of stability, and the values of a varied parameter.

use super::budget::MOST_CELLS;
use super::{Planned, Planner};
use crate::scene::document::{Expression, ParameterTable, Spread};
use crate::scene::plan::StabilityPlan;
use crate::scene::problem::SceneProblem;
use afterbay_analysis::Model;
use afterbay_analysis::Spacing;
use afterbay_analysis::study::stability;
use afterbay_core::InputError;

impl Planner<'_> {
    pub(super) fn stability(&self) -> Planned<Option<StabilityPlan>> {
        let Some(table) = &self.document.study.stability else { return Ok(None) };
        let path = "study.stability";
        let methods = self.fixed_methods(path, table.methods.as_ref())?;
        let mut steps = self.spread(&format!("{path}.steps"), &table.steps)?;
        let varied = &table.parameter;
        let values = self.parameter(&format!("{path}.parameter"), varied)?;
        steps.sort_by(f64::total_cmp);
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

    /// The values of a varied parameter in ascending order, at each of which the system is valid.
    /// Upwards means from the least value to the largest, also if `from` is the largest.
    pub(super) fn parameter(&self, named: &str, varied: &ParameterTable) -> Planned<Vec<f64>> {
        let ends = (varied.from, varied.to);
        let mut values = self.range(named, ends, varied.count, varied.scale, f64::NEG_INFINITY)?;
        values.sort_by(f64::total_cmp);
        let known = self.problem.model.parameters();
        if !known.contains(&varied.name.as_str()) {
            self.not_computed(&format!("{named}.name"), &varied.name)?;
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
            let model = self.varied(named, &varied.name, *value)?;
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

    /// Refuses to vary a parameter that is an expression in others.
    pub(in crate::scene) fn not_computed(&self, path: &str, name: &str) -> Planned<()> {
        let of_drive = self.document.drive.as_ref().and_then(|drive| drive.parameters.get(name));
        match of_drive.or(self.document.system.parameters.get(name)) {
            Some(Expression::Text(_)) => {
                let why = "it is computed from other parameters";
                self.refuse(path, SceneProblem::NotVaried { name: name.into(), why })
            }
            _ => Ok(()),
        }
    }

    /// A parameter of a built-in system that is computed from this one when the scene is read. In a
    /// system of expressions, and in a drive, it follows.
    fn computed_from(&self, name: &str) -> Option<String> {
        let model = match &self.problem.model {
            Model::Driven(model, _) => model,
            model => model,
        };
        if matches!(model, Model::Custom(_)) {
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
}
