//! Runs with events: functions of the state whose zeros are recorded, end the run, or change the
//! state.

mod function;
mod leg;
mod rebound;

pub use function::Function;
pub use leg::{EventRun, advance};

use super::trajectory::{Legs, Steps, Trajectory};
use super::{PUMPED, Problem, numbered};
use crate::Model;
use crate::progress::Progress;
use crate::words::{Word, word as read_word};
use afterbay_core::{Direction, IntegrateError};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};

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
    /// The velocity ∂H/∂p_j of a degree of freedom, counted from 0, is reversed and multiplied by
    /// the restitution. The energy lost is added to its reservoir, so that K is kept.
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
        advance(legs, EventRun { problem, row, steps, events }, keep, &mut found, progress)
    })?;
    Ok((run, found))
}
