//! Trajectories.

mod balance;
mod legs;
mod samples;

pub use balance::Balance;
pub use legs::{Keep, Legs};
pub(super) use legs::{KeptState, of_run};
pub use samples::{dense, samples};

use super::outcome::Ending;
use super::{PUMPED, Problem, numbered};
use crate::finite_or_none;
use crate::progress::Progress;
use crate::solution::accounts;
use crate::words::{Word, word as read_word};
use crate::{Model, Variable};
use afterbay_core::{Abilities, Accounts, IntegrateError, State, StateRef};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// The steps of a run: of size h, and of a method with a tolerance the runs between them.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// The size of a step, in the unit of time of the problem.
    pub h: f64,
    /// The number of steps between two states that are kept.
    pub every: u64,
    /// The relative tolerance, for methods that choose their steps.
    pub tolerance: Option<f64>,
}

/// The steps of a leg that is computed step by step, times degrees of freedom. A choice: such a
/// step may be a run within a tolerance.
const SINGLE_STEPS: u64 = 1 << 16;

/// The number of steps of a leg that is computed step by step.
pub(super) fn steps_of_leg(state: &State<Vec<f64>>) -> u64 {
    (SINGLE_STEPS / state.q.len() as u64).max(1)
}

/// A row of `trajectory.csv`, under the [`columns`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrajectoryRow {
    /// Name of the method.
    #[serde(deserialize_with = "read_word")]
    pub method: Word,
    /// Steps done.
    pub step: u64,
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
    /// H; not finite, and an empty cell, where its terms overflow.
    #[serde(with = "finite_or_none")]
    pub energy: f64,
    /// K = H + Σ w - Σ s - s_t, as H.
    #[serde(with = "finite_or_none")]
    pub total: f64,
}

impl TrajectoryRow {
    /// A state of a run, without motors.
    pub(super) fn of(
        method: &'static str,
        step: u64,
        state: StateRef<'_, f64>,
        system: &dyn Abilities<f64>,
        model: &Model,
    ) -> Self {
        let n = model.degrees();
        let Accounts { w, s, pumped } = accounts(state, &model.motors());
        let supplied: f64 = state.p[n..].iter().sum();
        Self {
            method,
            step,
            t: state.t,
            q: state.q[..n].to_vec(),
            p: state.p[..n].to_vec(),
            w,
            s,
            pumped: pumped.into_iter().collect(),
            energy: state.energy(system) - supplied,
            total: state.total(system),
        }
    }

    /// The entries of a variable.
    pub fn entries(&self, variable: Variable) -> &[f64] {
        match variable {
            Variable::Q => &self.q,
            Variable::P => &self.p,
            Variable::W => &self.w,
            Variable::S => &self.s,
        }
    }

    /// Reads a line of the table, to the bit; `None` for one that does not have the columns of the
    /// model.
    pub fn read(method: &'static str, line: &str, model: &Model) -> Option<Self> {
        let mut cells = line.trim_end().split(',').skip(1);
        let step = cells.next()?.parse().ok()?;
        let cells: Vec<&str> = cells.collect();
        let energies = cells.len().checked_sub(2)?;
        // H and K are empty where they overflow.
        let number = |(i, cell): (usize, &&str)| match *cell {
            "" if i >= energies => Some(f64::NAN),
            cell => cell.parse().ok(),
        };
        let numbers: Vec<f64> = cells.iter().enumerate().map(number).collect::<Option<_>>()?;
        let (t, mut rest) = numbers.split_first()?;
        let mut part = |count: usize| {
            let (part, behind) = rest.split_at_checked(count)?;
            rest = behind;
            Some(part.to_vec())
        };
        let n = model.degrees();
        let (q, p, w) = (part(n)?, part(n)?, part(n)?);
        let s = part(if model.driven().is_empty() { 0 } else { n })?;
        let pumped = part(usize::from(model.has_clock()))?;
        let &[energy, total] = rest else { return None };
        Some(Self { method, step, t: *t, q, p, w, s, pumped, energy, total })
    }
}

/// The names of the columns: `method,step,t,q1..qN,p1..pN,w1..wN,H,K`, with s1..sN behind w where
/// there is a drive, and st behind them where V or D depends on t.
pub fn columns(model: &Model) -> Vec<String> {
    let names = |list: &[&str]| list.iter().map(ToString::to_string).collect::<Vec<_>>();
    let pumped = model.has_clock().then(|| PUMPED.to_owned());
    let parts = model.variables().iter().flat_map(|name| numbered(name, model.degrees()));
    names(&["method", "step", "t"])
        .into_iter()
        .chain(parts)
        .chain(pumped)
        .chain(names(&["H", "K"]))
        .collect()
}

/// One run.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Name of the method.
    pub method: Word,
    /// Every `every`-th state, and the last good one.
    pub rows: Vec<TrajectoryRow>,
    /// K and H of all states.
    pub balance: Balance,
    /// The ending of the run; `interrupted` while legs of it are left.
    pub ending: Ending,
}

impl Trajectory {
    /// A run whose states are all kept in memory. `advance` computes the next leg.
    pub(super) fn of_legs(
        mut legs: Legs,
        mut advance: impl FnMut(&mut Legs, Keep<'_>) -> Result<(), IntegrateError>,
    ) -> Result<Self, IntegrateError> {
        let mut rows = Vec::new();
        while !legs.has_ended() {
            advance(&mut legs, &mut |row| {
                rows.push(row);
                ControlFlow::Continue(())
            })?;
        }
        let Legs { method, balance, ending, .. } = legs;
        Ok(Self { method, rows, balance, ending })
    }
}

/// Runs each method with steps of size h and keeps every `every`-th state.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    h: f64,
    every: u64,
    progress: &dyn Progress,
) -> Result<Vec<Trajectory>, IntegrateError> {
    let steps = Steps { h, every, tolerance: None };
    let of_method = |row: &&'static Row| {
        Trajectory::of_legs(Legs::new(problem, row)?, |legs, keep| {
            legs.advance(problem, row, steps, keep, progress)
        })
    };
    methods.par_iter().map(of_method).collect()
}
