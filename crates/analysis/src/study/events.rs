//! Runs with events: functions of the state whose zeros are recorded, end the run, or change the
//! state.

use super::outcome::{Ending, INTERRUPTED};
use super::trajectory::{Trajectory, TrajectoryRow};
use super::{PUMPED, Problem, numbered};
use crate::Model;
use crate::observable::Observable;
use crate::progress::{Piece, Progress};
use crate::scene::Variable;
use crate::words::{Word, word as read_word};
use afterbay_core::{
    Abilities, Direction, Event, EventState, Grid, IntegrateError, StateRef, System, Tolerance,
    integrate_with_events,
};
use afterbay_methods::registry::Row;
use afterbay_systems::{CustomFunction, FunctionDescription};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// An event of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct EventPlan {
    /// Its name.
    pub name: String,
    /// The function.
    pub function: Function,
    /// The direction in which the function crosses zero.
    pub direction: Direction,
    /// The action taken.
    pub action: Action,
}

/// A function of the state.
#[derive(Clone, Debug, PartialEq)]
pub enum Function {
    /// A quantity less a value.
    Quantity(Observable, f64),
    /// An expression in q1, .., p1, .., t and the parameters; with names of expressions in them.
    Expression(String, Vec<(String, String)>),
}

/// The action taken at an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// It is recorded.
    Record,
    /// The run ends.
    Stop,
    /// The momentum of a degree of freedom, counted from 0, is reversed and multiplied by the
    /// restitution. The energy lost is added to its reservoir, so that K is kept.
    Bounce(usize, f64),
}

/// A row of `events.csv`, under the [`columns`]. The state is that before a bounce.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EventRow {
    /// Name of the method.
    #[serde(deserialize_with = "read_word")]
    pub method: Word,
    /// Name of the event.
    pub event: String,
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Momenta.
    pub p: Vec<f64>,
    /// Reservoir.
    pub w: Vec<f64>,
    /// The energy supplied by a drive; empty without one.
    pub s: Vec<f64>,
    /// The energy s_t pumped by V(q, t); empty where V and D do not depend on t.
    pub pumped: Vec<f64>,
    /// H
    pub energy: f64,
    /// K = H + Σ w - Σ s - s_t
    pub total: f64,
}

/// The names of the columns: `method,event,t,q1..qN,p1..pN,w1..wN,H,K`, with s1..sN behind w where
/// there is a drive, and st behind them where V or D depends on t.
pub fn columns(model: &Model) -> Vec<String> {
    let parts = model.variables().iter().flat_map(|name| numbered(name, model.degrees()));
    let first = ["method", "event", "t"].map(String::from).into_iter();
    let pumped = model.has_clock().then(|| PUMPED.to_owned());
    first.chain(parts).chain(pumped).chain(["H".into(), "K".into()]).collect()
}

/// The steps of a run: of size h, and of a method with a tolerance the runs between them.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// The size of a step.
    pub h: f64,
    /// The number of steps between two states that are kept.
    pub every: u64,
    /// The tolerance of methods that choose their steps.
    pub tolerance: f64,
}

/// Runs a method and looks for events in every step.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn run(
    problem: &Problem,
    row: &'static Row,
    Steps { h, every, tolerance }: Steps,
    events: &[EventPlan],
    progress: &dyn Progress,
) -> Result<(Trajectory, Vec<EventRow>), IntegrateError> {
    let (model, grid) = (&problem.model, Grid::<f64>::new(h, problem.end)?);
    let system = model.system::<f64>()?;
    let (bound, mut state) = (model.bind(row)?, problem.start()?);
    let mut step = bound.stepper(Tolerance::all(tolerance));
    let functions = events
        .iter()
        .map(|event| event.function.bind(model, &*system))
        .collect::<Result<Vec<_>, IntegrateError>>()?;
    let watched: Vec<Event<'_>> = functions
        .iter()
        .zip(events)
        .map(|(function, event)| Event { function: &**function, direction: event.direction })
        .collect();
    let record =
        |n: u64, state: StateRef<'_, f64>| TrajectoryRow::of(row.name, n, state, &*system, model);
    let (mut rows, mut found, mut done, mut stopped) = (Vec::new(), Vec::new(), 0, false);
    let mut happen = |i: usize, state: EventState<'_>| {
        let EventState { q, p, w, t } = state;
        let at = record(0, StateRef { q, p, w, t });
        found.push(EventRow {
            method: row.name,
            event: events[i].name.clone(),
            t,
            q: at.q,
            p: at.p,
            w: at.w,
            s: at.s,
            pumped: at.pumped,
            energy: at.energy,
            total: at.total,
        });
        match events[i].action {
            Action::Record => ControlFlow::Continue(()),
            Action::Stop => {
                stopped = true;
                ControlFlow::Break(())
            }
            Action::Bounce(j, restitution) => {
                let before = system.energy(q, p);
                p[j] *= -restitution;
                w[j] += before - system.energy(q, p);
                ControlFlow::Continue(())
            }
        }
    };
    let mut piece = Piece::new(progress);
    let mut observe = |n: u64, state: StateRef<'_, f64>| {
        done = n;
        piece.reach(n, grid.steps);
        if n.is_multiple_of(every) || n == grid.steps {
            rows.push(record(n, state));
        }
        if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let pair = (&watched[..], &mut happen as afterbay_core::Happen<'_>);
    let result = integrate_with_events(&mut *step, grid, &mut state, pair, &mut observe);
    drop(piece);
    progress.advance();
    if let Err(IntegrateError::Input(error)) = result {
        return Err(error.into());
    }
    if rows.last().is_none_or(|last| last.t < state.t) {
        rows.push(record(done, state.state_ref()));
    }
    let mut ending = Ending::of(&result, grid.steps, done);
    if stopped && ending.outcome == INTERRUPTED {
        ending = Ending::completed();
    }
    Ok((Trajectory { method: row.name, rows, ending }, found))
}

type Value<'a> = Box<dyn Fn(StateRef<'_, f64>) -> f64 + Sync + 'a>;

impl Function {
    /// The function for a model.
    fn bind<'a>(
        &self,
        model: &'a Model,
        system: &'a dyn Abilities<f64>,
    ) -> Result<Value<'a>, IntegrateError> {
        match self {
            Self::Quantity(quantity, value) => {
                let (quantity, value) = (*quantity, *value);
                Ok(Box::new(move |state| {
                    let n = model.degrees();
                    match quantity {
                        Observable::Time => state.t - value,
                        Observable::Of(Variable::Q, j) => state.q[j] - value,
                        Observable::Of(Variable::P, j) => state.p[j] - value,
                        Observable::Energy => {
                            state.energy(system) - state.p[n..].iter().sum::<f64>() - value
                        }
                        _ => {
                            let row = TrajectoryRow::of("", 0, state, system, model);
                            quantity.of(&row, &row).unwrap_or(f64::NAN) - value
                        }
                    }
                }))
            }
            Self::Expression(..) => {
                let (function, n) = (self.compiled(model), model.degrees());
                // The scene was checked with the same expression.
                let Some(Ok(function)) = function else {
                    return Ok(Box::new(|_| f64::NAN));
                };
                Ok(Box::new(move |state| function.value(&state.q[..n], &state.p[..n], state.t)))
            }
        }
    }

    /// The expression, compiled with the parameters of a model.
    pub(crate) fn compiled(
        &self,
        model: &Model,
    ) -> Option<Result<CustomFunction, afterbay_systems::CustomError>> {
        let Self::Expression(text, definitions) = self else { return None };
        let description = FunctionDescription {
            text: text.clone(),
            parameters: model.values(),
            definitions: definitions.clone(),
        };
        Some(CustomFunction::new(&description, model.degrees()))
    }
}
