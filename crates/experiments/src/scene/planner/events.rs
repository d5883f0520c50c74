//! Plans of events.

use super::{Planned, Planner};
use crate::scene::document::{ActionName, EventTable, Expression};
use crate::scene::problem::{SceneError, SceneProblem};
use afterbay_analysis::Observable;
use afterbay_analysis::Variable;
use afterbay_analysis::study::events::{Action, EventPlan, Function};
use afterbay_analysis::study::section::Direction;
use afterbay_systems::CustomError;

impl Planner<'_> {
    /// The events of [run].
    pub(super) fn events(&self) -> Planned<Vec<EventPlan>> {
        let tables = self.document.run.iter().flat_map(|run| &run.events);
        tables.map(|(name, table)| self.event(name, table)).collect()
    }

    /// The error of a study, or of `pick`, that follows the motion without an event that changes
    /// the state; none if there is no such event.
    pub(in crate::scene) fn changing(&self, events: &[EventPlan]) -> Option<SceneError> {
        let changes = |event: &&EventPlan| matches!(event.action, Action::Bounce(..));
        let event = events.iter().find(changes)?.name.clone();
        let span = self.source.span_of(&["run", "events", &event, "action"]);
        Some(SceneError { problem: SceneProblem::Changes { event }, span })
    }

    fn event(&self, name: &str, table: &EventTable) -> Planned<EventPlan> {
        let path = format!("run.events.{name}");
        let function = match (&table.of, &table.when) {
            (Some(of), None) => self.quantity(&path, of, table.value.unwrap_or(0.0))?,
            (None, Some(when)) => {
                if table.value.is_some() {
                    let (key, why) = ("value", "`when` is compared with 0");
                    return self
                        .refuse(&format!("{path}.value"), SceneProblem::Misplaced { key, why });
                }
                self.expression(&path, when)?
            }
            (Some(_), Some(_)) => {
                let (key, why) = ("when", "`of` says when the event happens");
                return self.refuse(&format!("{path}.when"), SceneProblem::Misplaced { key, why });
            }
            (None, None) => {
                return self.refuse(&path, SceneProblem::Missing { key: "of".into() });
            }
        };
        let action = self.action(&path, table, &function)?;
        let direction = table.direction.unwrap_or(Direction::Both).of_core();
        Ok(EventPlan { name: name.to_owned(), function, direction, action })
    }

    fn quantity(&self, path: &str, of: &str, value: f64) -> Planned<Function> {
        let model = &self.problem.model;
        match Observable::parse(of, model) {
            Some(quantity) => Ok(Function::Quantity(quantity, value)),
            None if of.contains(['(', '*', '/', '^', '+', '-']) => {
                let (key, why) = ("of", "it names one quantity: an expression stands in `when`");
                self.refuse(&format!("{path}.of"), SceneProblem::Misplaced { key, why })
            }
            None => {
                let known = Observable::names(model);
                let (what, name) = ("quantity", of.to_owned());
                self.refuse(&format!("{path}.of"), SceneProblem::Unknown { what, name, known })
            }
        }
    }

    fn expression(&self, path: &str, when: &Expression) -> Planned<Function> {
        let of_drive = self.document.drive.iter().flat_map(|drive| &drive.parameters);
        let parameters = self.document.system.parameters.iter().chain(of_drive);
        let known: Vec<String> = self.problem.model.values().into_iter().map(|x| x.0).collect();
        let definitions = parameters.filter_map(|(name, value)| match value {
            Expression::Text(text) if !known.contains(name) => Some((name.clone(), text.clone())),
            _ => None,
        });
        let function = Function::Expression(when.text(), definitions.collect());
        let path = format!("{path}.when");
        match function.compiled(&self.problem.model) {
            Some(Err(CustomError::Expression { span, problem, .. })) => {
                let span = self.source.span_within(&path, &span);
                let problem = SceneProblem::Expression(problem);
                Err(SceneError { problem, span })
            }
            Some(Err(error)) => self.refuse(&path, SceneProblem::Custom(error)),
            _ => Ok(function),
        }
    }

    fn action(&self, path: &str, table: &EventTable, function: &Function) -> Planned<Action> {
        let restitution = table.restitution.unwrap_or(1.0);
        match table.action {
            ActionName::Bounce => {}
            _ if table.restitution.is_some() => {
                let (key, why) = ("restitution", "only action = \"bounce\" has one");
                return self
                    .refuse(&format!("{path}.restitution"), SceneProblem::Misplaced { key, why });
            }
            ActionName::Record => return Ok(Action::Record),
            ActionName::Stop => return Ok(Action::Stop),
        }
        if !(0.0..=1.0).contains(&restitution) {
            let (name, value, range) = ("restitution", restitution, "from 0 to 1");
            return self.refuse(
                &format!("{path}.restitution"),
                SceneProblem::Range { name, value, range },
            );
        }
        match function {
            Function::Quantity(Observable::Of(Variable::Q, j), _) => {
                Ok(Action::Bounce(*j, restitution))
            }
            _ => {
                let (key, why) =
                    ("action", "a bounce needs of = \"q1\", the coordinate that meets a wall");
                self.refuse(&format!("{path}.action"), SceneProblem::Misplaced { key, why })
            }
        }
    }
}
