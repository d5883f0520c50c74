//! The next leg of a run with events.

use super::function::Value;
use super::rebound::rebound;
use super::{Action, EventPlan, EventRow};
use crate::progress::{Piece, Progress};
use crate::study::Problem;
use crate::study::outcome::{Ending, INTERRUPTED};
use crate::study::trajectory::{Balance, Keep, KeptState, Legs, TrajectoryRow, of_run};
use crate::study::trajectory::{Steps, steps_of_leg};
use afterbay_core::{
    Abilities, Event, EventState, Grid, IntegrateError, RunError, StateRef, StepFailure, Tolerance,
    integrate_with_events,
};
use afterbay_methods::registry::Row;
use std::cell::Cell;
use std::ops::ControlFlow;

/// A run with events.
#[derive(Clone, Copy, Debug)]
pub struct EventRun<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// The method.
    pub row: &'static Row,
    /// The steps or the tolerance, and the states that are kept.
    pub steps: Steps,
    /// The events that are looked for.
    pub events: &'a [EventPlan],
}

/// Computes the next leg of a run, and appends the events that it finds.
///
/// # Errors
/// As for [`run`](super::run).
pub fn advance(
    legs: &mut Legs,
    EventRun { problem, row, steps: Steps { h, every, tolerance }, events }: EventRun<'_>,
    keep: Keep<'_>,
    found: &mut Vec<EventRow>,
    progress: &dyn Progress,
) -> Result<(), IntegrateError> {
    let Some(state) = legs.state.take() else { return Ok(()) };
    let (model, grid, begin) = (&problem.model, Grid::<f64>::new(h, problem.end)?, legs.done);
    let system = model.system::<f64>()?;
    let (bound, mut state) = (model.bind(row)?, state.at(begin as f64 * h));
    let functions = events.iter().map(|event| event.function.bind(model, &*system));
    let functions = functions.collect::<Result<Vec<_>, IntegrateError>>()?;
    let watched: Vec<_> = functions.iter().zip(events).map(|(f, event)| event.watch(f)).collect();
    let record =
        |n: u64, state: StateRef<'_, f64>| TrajectoryRow::of(row.name, n, state, &*system, model);
    let (record, system): (Record<'_>, _) = (&record, &*system);
    let last = Cell::new(f64::NEG_INFINITY);
    let mut events =
        Events { events, system, record, found, last: &last, stopped: false, failure: None };
    let span = Span { grid, begin, every, least: steps_of_leg(&state) };
    let kept = (begin > 0 && begin.is_multiple_of(every)).then_some(state.t);
    let (piece, done, last, leg_ends) = (Piece::new(progress), begin, &last, false);
    let (balance, dof) = (&mut legs.balance, model.degrees());
    let mut walk =
        Walk { span, record, keep, balance, system, dof, last, piece, done, kept, leg_ends };
    let mut happen = |i: usize, state: EventState<'_>| events.happen(i, state);
    let mut observe = |n: u64, state: StateRef<'_, f64>| walk.observe(n, state, progress);
    let rest = Grid { steps: grid.steps - begin, ..grid };
    let mut step = bound.stepper(tolerance.map(Tolerance::all), problem.end)?;
    let result =
        integrate_with_events(&mut *step, rest, &mut state, &watched, &mut happen, &mut observe);
    let Walk { keep, balance, piece, done, kept, leg_ends, .. } = walk;
    let failed = events
        .failure
        .take()
        .map(|(t, failure)| IntegrateError::from(RunError { step: done + 1 - begin, t, failure }));
    let result = failed.map_or(result, Err).map(drop).map_err(|error| of_run(begin, error));
    legs.done = done;
    legs.ending = Ending::of(&result, grid.steps, done);
    if let (Some(says), Some(i)) = (&mut legs.ending.failure, event_of(&result)) {
        // The events of a scene are known by their names, and sorted by them.
        *says += &format!(" (event {} is `{}`)", i + 1, events.events[i].name);
    }
    if leg_ends && result.is_ok() && !events.stopped {
        legs.state = Some(KeptState::of(state));
        return Ok(());
    }
    drop(piece);
    progress.advance();
    if let Err(IntegrateError::Input(error)) = result {
        return Err(error.into());
    }
    if kept != Some(state.t) {
        balance.see(system, state.state_ref(), dof);
        // The run is over, whether or not the row can be written.
        let _ = keep(record(done, state.state_ref()));
    }
    if events.stopped && legs.ending.outcome == INTERRUPTED {
        legs.ending = Ending::completed();
    }
    Ok(())
}

/// The event that a failure is about, from 0.
fn event_of(result: &Result<(), IntegrateError>) -> Option<usize> {
    let Err(IntegrateError::Run(RunError { failure, .. })) = result else { return None };
    match *failure {
        StepFailure::EventsAccumulate { event, .. } | StepFailure::LeftByEvent { event, .. } => {
            Some(event)
        }
        _ => None,
    }
}

impl EventPlan {
    /// The event, with its function bound to a system.
    fn watch<'a>(&self, function: &'a Value<'_>) -> Event<'a> {
        let is_wall = matches!(self.action, Action::Bounce(..));
        Event { function: &**function, direction: self.direction, is_wall }
    }
}

impl EventRow {
    /// The row of an event in a state.
    fn of(event: String, state: TrajectoryRow) -> Self {
        let TrajectoryRow { method, t, q, p, w, s, pumped, energy, total, .. } = state;
        Self { method, event, t, q, p, w, s, pumped, energy, total }
    }
}

/// Makes the row of a state after n steps.
type Record<'a> = &'a dyn Fn(u64, StateRef<'_, f64>) -> TrajectoryRow;

/// The events of a leg.
struct Events<'a> {
    events: &'a [EventPlan],
    system: &'a dyn Abilities<f64>,
    record: Record<'a>,
    found: &'a mut Vec<EventRow>,
    /// The time of the last event.
    last: &'a Cell<f64>,
    /// Whether an event has ended the run.
    stopped: bool,
    /// The time at which a bounce failed, and the reason.
    failure: Option<(f64, StepFailure)>,
}

impl Events<'_> {
    /// Records event i and takes its action.
    fn happen(&mut self, i: usize, state: EventState<'_>) -> ControlFlow<()> {
        let EventState { q, p, w, t } = state;
        let event = &self.events[i];
        self.last.set(t);
        let at = (self.record)(0, StateRef { q, p, w, t });
        self.found.push(EventRow::of(event.name.clone(), at));
        match event.action {
            Action::Record => ControlFlow::Continue(()),
            Action::Stop => {
                self.stopped = true;
                ControlFlow::Break(())
            }
            Action::Bounce(j, restitution) => {
                let before = self.system.energy(q, p);
                if let Err(failure) = rebound(self.system, q, p, j, restitution) {
                    self.failure = Some((t, failure));
                    return ControlFlow::Break(());
                }
                w[j] += before - self.system.energy(q, p);
                ControlFlow::Continue(())
            }
        }
    }
}

/// The steps of a leg.
#[derive(Clone, Copy)]
struct Span {
    /// The steps of the whole run.
    grid: Grid<f64>,
    /// The number of steps before the leg.
    begin: u64,
    /// The number of steps between two states that are kept.
    every: u64,
    /// The least number of steps of the leg.
    least: u64,
}

/// The observer of a leg.
struct Walk<'a> {
    span: Span,
    record: Record<'a>,
    keep: Keep<'a>,
    balance: &'a mut Balance,
    system: &'a dyn Abilities<f64>,
    /// The number of degrees of freedom without clock and motors.
    dof: usize,
    /// The time of the last event.
    last: &'a Cell<f64>,
    piece: Piece<'a>,
    /// The number of steps since the start of the run.
    done: u64,
    /// The time of the last state that was kept.
    kept: Option<f64>,
    /// Whether the leg ends here and the run goes on.
    leg_ends: bool,
}

impl Walk<'_> {
    /// Receives the state after step n of the leg, and keeps it if it is one of those to keep.
    fn observe(
        &mut self,
        n: u64,
        state: StateRef<'_, f64>,
        progress: &dyn Progress,
    ) -> ControlFlow<()> {
        let Span { grid: Grid { h, steps: all }, begin, every, least } = self.span;
        self.done = begin + n;
        self.piece.report(self.done, all);
        self.balance.see(self.system, state, self.dof);
        let mut goes_on = true;
        let is_new = n > 0 || begin == 0;
        if is_new && (self.done.is_multiple_of(every) || self.done == all) {
            // The times are those of one grid, whatever the legs.
            let at = StateRef { t: self.done as f64 * h, ..state };
            goes_on = (self.keep)((self.record)(self.done, at)).is_continue();
            self.kept = Some(state.t);
        }
        goes_on = goes_on && !progress.stopped();
        // A new leg does not know on which side of zero an event has left its function.
        let is_clear = self.last.get() <= state.t - h;
        self.leg_ends = goes_on && n >= least && is_clear && self.done < all;
        if goes_on && !self.leg_ends { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}
