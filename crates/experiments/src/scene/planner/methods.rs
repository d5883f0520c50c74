//! The methods of a scene and of its studies.

use super::{Planned, Planner};
use crate::scene::problem::SceneProblem;
use afterbay_core::InputError;
use afterbay_methods::registry::{self, METHODS, Row};

impl Planner<'_> {
    /// The names of the methods of a study, which are those of [run] unless it has its own, and the
    /// path of their list.
    pub(super) fn names<'n>(
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
    pub(super) fn fixed_methods(
        &self,
        path: &str,
        own: Option<&Vec<String>>,
    ) -> Planned<Vec<&'static Row>> {
        let (at, names) = self.names(path, own)?;
        let Methods { fixed, adaptive } = self.methods(&at, names)?;
        let unfit = adaptive.first().filter(|_| own.is_some() || fixed.is_empty());
        if let Some(row) = unfit {
            let problem = SceneProblem::ChoosesSteps { name: row.name };
            return self.refuse(&entry_of(&at, names, row), problem);
        }
        if fixed.is_empty() { self.refuse(path, SceneProblem::NoMethods) } else { Ok(fixed) }
    }

    /// Refuses a method that chooses its steps where there is no tolerance.
    pub(super) fn none_adaptive(
        &self,
        path: &str,
        names: &[String],
        found: &[&'static Row],
    ) -> Planned<()> {
        let Some(row) = found.first() else { return Ok(()) };
        self.refuse(&entry_of(path, names, row), SceneProblem::Adaptive { name: row.name })
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
    pub(super) fn methods(&self, path: &str, names: &[String]) -> Planned<Methods> {
        self.known(path, names)?;
        let mut found = Methods::default();
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
#[derive(Default)]
pub(super) struct Methods {
    /// The methods with a fixed step.
    pub(super) fixed: Vec<&'static Row>,
    /// The methods that choose their steps.
    pub(super) adaptive: Vec<&'static Row>,
}

/// The path of the entry of a method in a list.
fn entry_of(path: &str, names: &[String], row: &Row) -> String {
    let at = names.iter().position(|name| name == row.name).unwrap_or(0);
    format!("{path}.{at}")
}
