//! Figures of trajectories.

use super::{Planned, Planner};
use crate::scene::document::{FigureTable, Names};
use crate::scene::plan::{FigurePlan, RunPlan, Shown};
use crate::scene::problem::SceneProblem;
use afterbay_analysis::Observable;
use afterbay_analysis::Variable;

impl Planner<'_> {
    /// The figures of the scene in the order of the text.
    pub(in crate::scene) fn figures(&self, run: Option<&RunPlan>) -> Planned<Vec<FigurePlan>> {
        let mut tables: Vec<_> = self.document.figure.iter().collect();
        tables.sort_by_key(|(name, _)| self.source.span_of(&["figure", name]).start);
        tables.into_iter().map(|(name, table)| self.figure(name, table, run)).collect()
    }

    fn figure(
        &self,
        name: &str,
        table: &FigureTable,
        run: Option<&RunPlan>,
    ) -> Planned<FigurePlan> {
        let path = format!("figure.{name}");
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || name.len() > 100 || !name.chars().all(plain) {
            return self.refuse_at(&["figure", name], SceneProblem::FileName { name: name.into() });
        }
        let Some(run) = run else {
            let why = "figures show the trajectories of [run]";
            return self.refuse(&path, SceneProblem::Misplaced { key: "figure", why });
        };
        let shown = match (&table.y, table.map) {
            (None, None) => self.refuse(&path, SceneProblem::Missing { key: "y".into() }),
            (None, Some(variable)) => self.map(&path, table, variable),
            (Some(_), Some(_)) => {
                let why = "a figure shows either y or a map";
                let problem = SceneProblem::Misplaced { key: "map", why };
                self.refuse(&format!("{path}.map"), problem)
            }
            (Some(names), None) => self.curves(&path, table, names),
        }?;
        let methods = self.shown_methods(&format!("{path}.methods"), table, run)?;
        Ok(FigurePlan { name: name.into(), title: table.title.clone(), methods, shown })
    }

    fn map(&self, path: &str, table: &FigureTable, variable: Variable) -> Planned<Shown> {
        let why = "a map is over the degree of freedom and time";
        for (key, given) in [("x", table.x.is_some()), ("log", table.log)] {
            if given {
                let problem = SceneProblem::Misplaced { key, why };
                return self.refuse(&format!("{path}.{key}"), problem);
            }
        }
        let (letter, known) = (variable.letter(), self.problem.model.variables());
        if !known.contains(&letter) {
            let known = known.iter().map(ToString::to_string).collect();
            let problem = SceneProblem::Unknown { what: "variable", name: letter.into(), known };
            return self.refuse(&format!("{path}.map"), problem);
        }
        Ok(Shown::Map(variable))
    }

    fn curves(&self, path: &str, table: &FigureTable, names: &Names) -> Planned<Shown> {
        let x = match &table.x {
            None => Observable::Time,
            Some(name) => self.observable(&format!("{path}.x"), name)?,
        };
        let mut y = Vec::new();
        for (end, name) in names.each() {
            let at = format!("{path}.y{end}");
            let found = self.observable(&at, name)?;
            if y.contains(&found) {
                return self.refuse(&at, SceneProblem::Twice { name: name.into() });
            }
            y.push(found);
        }
        if y.is_empty() {
            let problem = SceneProblem::Empty { what: "quantity" };
            return self.refuse(&format!("{path}.y"), problem);
        }
        Ok(Shown::Curves { x, y, log: table.log })
    }

    fn observable(&self, path: &str, name: &str) -> Planned<Observable> {
        let model = &self.problem.model;
        let unknown = || SceneProblem::Unknown {
            what: "quantity",
            name: name.into(),
            known: Observable::names(model),
        };
        Observable::parse(name, model).map_or_else(|| self.refuse(path, unknown()), Ok)
    }

    /// The methods of a figure, which are of those of [run].
    fn shown_methods(
        &self,
        path: &str,
        table: &FigureTable,
        run: &RunPlan,
    ) -> Planned<Vec<&'static str>> {
        let all = run.names();
        let Some(names) = &table.methods else { return Ok(all) };
        let mut found = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let at = format!("{path}.{i}");
            let Some(known) = all.iter().find(|known| *known == name) else {
                let known = all.iter().map(ToString::to_string).collect();
                let name = name.clone();
                let problem = SceneProblem::Unknown { what: "method in [run] named", name, known };
                return self.refuse(&at, problem);
            };
            if found.contains(known) {
                return self.refuse(&at, SceneProblem::Twice { name: name.clone() });
            }
            found.push(*known);
        }
        if found.is_empty() {
            return self.refuse(path, SceneProblem::Empty { what: "method" });
        }
        Ok(found)
    }
}
