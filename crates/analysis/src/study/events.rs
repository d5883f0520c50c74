//! Runs with events: functions of the state whose zeros are recorded, end the run, or change the
//! state.

mod function;

pub use function::Function;

use super::outcome::{Ending, INTERRUPTED};
use super::trajectory::{Keep, KeptState, Legs, Trajectory, TrajectoryRow};
use super::{PUMPED, Problem, numbered};
use crate::Model;
use crate::progress::{Piece, Progress};
use crate::words::{Word, word as read_word};
use afterbay_core::{
    Direction, Event, EventState, Grid, IntegrateError, RunError, StateRef, System, Tolerance,
    integrate_with_events,
};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};
use std::cell::Cell;
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

/// The steps of a leg that is computed step by step, times degrees of freedom. A choice: such a
/// step may be a run within a tolerance.
pub(super) const SINGLE_STEPS: u64 = 1 << 16;

/// Runs a method and looks for events in every step.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn run(
    problem: &Problem,
    row: &'static Row,
    steps: Steps,
    events: &[EventPlan],
    progress: &dyn Progress,
) -> Result<(Trajectory, Vec<EventRow>), IntegrateError> {
    let mut found = Vec::new();
    let run = Trajectory::of_legs(Legs::new(problem, row)?, |legs, keep| {
        advance(legs, (problem, row), (steps, events), (keep, &mut found), progress)
    })?;
    Ok((run, found))
}

/// Computes the next leg of a run, and appends the events that it finds.
///
/// # Errors
/// As for [`run`].
pub fn advance(
    legs: &mut Legs,
    (problem, row): (&Problem, &'static Row),
    (Steps { h, every, tolerance }, events): (Steps, &[EventPlan]),
    (keep, found): (Keep<'_>, &mut Vec<EventRow>),
    progress: &dyn Progress,
) -> Result<(), IntegrateError> {
    let Some(state) = legs.state.take() else { return Ok(()) };
    let (model, grid, begin) = (&problem.model, Grid::<f64>::new(h, problem.end)?, legs.done);
    let system = model.system::<f64>()?;
    let (bound, mut state) = (model.bind(row)?, state.at(begin as f64 * h));
    let mut step = bound.stepper(Tolerance::all(tolerance));
    let functions = events
        .iter()
        .map(|event| event.function.bind(model, &*system))
        .collect::<Result<Vec<_>, IntegrateError>>()?;
    let watched: Vec<Event<'_>> = functions
        .iter()
        .zip(events)
        .map(|(function, event)| Event {
            function: &**function,
            direction: event.direction,
            is_wall: matches!(event.action, Action::Bounce(..)),
        })
        .collect();
    let record =
        |n: u64, state: StateRef<'_, f64>| TrajectoryRow::of(row.name, n, state, &*system, model);
    let (mut stopped, happened) = (false, Cell::new(f64::NEG_INFINITY));
    let mut happen = |i: usize, state: EventState<'_>| {
        let EventState { q, p, w, t } = state;
        happened.set(t);
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
    let (mut piece, leg) = (Piece::new(progress), (SINGLE_STEPS / state.q.len() as u64).max(1));
    let (mut done, mut leg_ends) = (begin, false);
    // The time of the last state that was kept.
    let mut kept = if begin > 0 && begin.is_multiple_of(every) { state.t } else { f64::NAN };
    let mut observe = |n: u64, state: StateRef<'_, f64>| {
        done = begin + n;
        piece.reach(done, grid.steps);
        let mut goes_on = true;
        if (n > 0 || begin == 0) && (done.is_multiple_of(every) || done == grid.steps) {
            // The times are those of one grid, whatever the legs.
            goes_on = keep(record(done, StateRef { t: done as f64 * h, ..state })).is_continue();
            kept = state.t;
        }
        goes_on = goes_on && !progress.stopped();
        // A new leg does not know on which side of zero an event has left its function.
        leg_ends = goes_on && n >= leg && happened.get() <= state.t - h && done < grid.steps;
        if goes_on && !leg_ends { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let rest = Grid { steps: grid.steps - begin, ..grid };
    let pair = (&watched[..], &mut happen as afterbay_core::Happen<'_>);
    let result = integrate_with_events(&mut *step, rest, &mut state, pair, &mut observe);
    let result = result.map(drop).map_err(|error| match error {
        IntegrateError::Run(RunError { step, t, failure }) => {
            RunError { step: begin + step, t, failure }.into()
        }
        error => error,
    });
    legs.done = done;
    legs.ending = Ending::of(&result, grid.steps, done);
    if leg_ends && result.is_ok() && !stopped {
        legs.state = Some(KeptState::of(state));
        return Ok(());
    }
    drop(piece);
    progress.advance();
    if let Err(IntegrateError::Input(error)) = result {
        return Err(error.into());
    }
    if kept != state.t {
        // The run is over, whether or not the row can be written.
        let _ = keep(record(done, state.state_ref()));
    }
    if stopped && legs.ending.outcome == INTERRUPTED {
        legs.ending = Ending::completed();
    }
    Ok(())
}
