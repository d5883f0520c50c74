//! Resonance: amplitude and energy per period of the steady motion, against the frequency of the
//! drive.
//!
//! Each frequency begins where the one before ended, upwards and downwards, so that both branches
//! of a hysteresis are seen. In a steady motion the energy supplied in a period is the energy
//! dissipated. A motion that does not repeat over the measured periods is marked as unsteady.

use super::Problem;
use super::bifurcation::Way;
use super::dynamics::{Dynamics, PiecePlan};
use super::motion::Motion;
use super::numbered;
use super::outcome::Ending;
use super::section::{Section, nearest, point, rewind};
use super::stability::MapError;
use super::zero::{at_zero, copy};
use crate::Model;
use crate::Spacing;
use crate::progress::Progress;
use crate::solution::accounts;
use crate::words::{Word, word};
use afterbay_core::{Accounts, Grid, IntegrateError, State, StateRef, System};
use afterbay_methods::registry::{Row, Run};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// The word of a motion that does not repeat over the measured periods.
pub const UNSTEADY: &str = "unsteady";
/// The largest distance from the first to the last state of the measured periods of a steady
/// motion.
const STEADY: f64 = 1e-6;

/// A resonance curve of a problem.
#[derive(Clone, Debug)]
pub struct Resonance {
    /// The system and the initial state.
    pub problem: Problem,
    /// The name of the parameter that changes the period of the drive.
    pub parameter: String,
    /// Its values.
    pub values: Vec<f64>,
    /// The spacing of the values.
    pub spacing: Spacing,
    /// Periods before those that are measured.
    pub transient: u64,
    /// Periods that are measured.
    pub periods: u64,
}

/// A row of `resonance.csv`, under the [`columns`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResonanceRow {
    /// Name of the method, or "reference".
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// The angular frequency 2π/P of the drive with period P.
    pub frequency: f64,
    /// `up` or `down`: the order in which frequencies are taken.
    pub branch: Way,
    /// max |q_j| over the measured periods, one entry for each degree of freedom. The range
    /// of an angle is moved by whole turns, so that its amplitude is least.
    pub amplitude: Vec<Option<f64>>,
    /// The energy that the drive supplies in a period, the mean of the measured periods. It
    /// includes the energy that V(q, t) pumps.
    pub supplied: Option<f64>,
    /// The energy dissipated in a period.
    pub dissipated: Option<f64>,
    /// The value of the parameter.
    pub value: f64,
    /// `completed`, `unsteady`, or the failure.
    #[serde(deserialize_with = "word")]
    pub outcome: Word,
    /// The failure in words.
    #[serde(skip)]
    pub failure: Option<String>,
}

/// The names of the columns:
/// `method,h,frequency,branch,amplitude_1..amplitude_N,supplied,dissipated,value,outcome`.
pub fn columns(model: &Model) -> Vec<String> {
    let names = ["method", "h", "frequency", "branch"].map(String::from).into_iter();
    let last = ["supplied", "dissipated", "value", "outcome"].map(String::from);
    names.chain(numbered("amplitude_", model.degrees())).chain(last).collect()
}

impl Resonance {
    /// The section of one period.
    pub const SECTION: Section = Section::Stroboscopic { interval: None };

    /// The frequencies in one order. A run that fails has a row without amplitudes, and the next
    /// begins at the initial state.
    fn branch(
        &self,
        row: &'static Row,
        h: f64,
        way: Way,
        progress: &dyn Progress,
    ) -> Result<Vec<ResonanceRow>, MapError> {
        let mut values = self.values.clone();
        if way == Way::Down {
            values.reverse();
        }
        let mut state: State<Vec<f64>> = self.problem.start()?;
        let mut rows = Vec::new();
        for value in values {
            if progress.stopped() {
                break;
            }
            let model = self.problem.model.with(&self.parameter, value)?;
            let (run, grid) = (model.bind(row)?, Self::SECTION.grid(&model, h)?);
            let frequency = std::f64::consts::TAU / (grid.h * grid.steps as f64);
            let found = self.steady(&model, &run, grid, &mut state);
            if let Err(IntegrateError::Input(error)) = found {
                return Err(error.into());
            }
            let ending = match &found {
                Ok(steady) if steady.returned > STEADY => unsteady(),
                _ => Ending::of(&found, 0, 0),
            };
            let steady = found.ok();
            if steady.is_none() {
                state = self.problem.start()?;
            }
            rows.push(ResonanceRow {
                method: row.name,
                h: grid.h,
                frequency,
                branch: way,
                amplitude: match &steady {
                    Some(steady) => steady.amplitude.iter().copied().map(Some).collect(),
                    None => vec![None; model.degrees()],
                },
                supplied: steady.as_ref().map(|steady| steady.supplied),
                dissipated: steady.as_ref().map(|steady| steady.dissipated),
                value,
                outcome: ending.outcome,
                failure: ending.failure,
            });
            progress.advance();
        }
        if way == Way::Down {
            rows.reverse();
        }
        Ok(rows)
    }

    /// Measures the motion from `state` after the transient. `state` is then at its end.
    fn steady(
        &self,
        model: &Model,
        run: &Run<f64>,
        grid: Grid<f64>,
        state: &mut State<Vec<f64>>,
    ) -> Result<Steady, IntegrateError> {
        let (dof, angles) = (model.degrees(), model.periods());
        // A period begins where the last one ended, less the whole turns of angles.
        let begin_anew = |state: &mut State<Vec<f64>>, from: &[f64]| {
            rewind(&mut state.q, &mut state.t, dof);
            for ((q, from), period) in state.q[..dof].iter_mut().zip(from).zip(&angles) {
                *q = period.map_or(*q, |period| from + nearest(*q - from, period));
            }
        };
        let mut motion = Motion::new(dof);
        for _ in 0..self.transient {
            let from = state.q[..dof].to_vec();
            run.run(grid, state, 1, &mut |_, now| {
                motion.see(now);
                ControlFlow::Continue(())
            })?;
            begin_anew(state, &from);
        }
        motion.settle();
        // The accounts begin anew, so that what a period adds is not rounded to their sum.
        state.p[dof..].fill(0.0);
        state.w.fill(0.0);
        let system = model.system::<f64>()?;
        let start = point(&angles, dof, state.state_ref());
        let mut range: Vec<[f64; 2]> = state.q[..dof].iter().map(|&q| [q, q]).collect();
        for _ in 0..self.periods {
            let from = state.q[..dof].to_vec();
            let mut turns = Turns::new(&*system, state);
            run.run(grid, state, 1, &mut |step, now| {
                motion.see(now);
                if step > 0 {
                    turns.see(run, grid.h, now, &mut range);
                }
                ControlFlow::Continue(())
            })?;
            begin_anew(state, &from);
        }
        let Accounts { w, s, pumped } = accounts(state.state_ref(), &model.motors());
        let gained: Vec<f64> = s.into_iter().chain(pumped).collect();
        let mean = |all: &[f64]| all.iter().sum::<f64>() / self.periods as f64;
        let end = point(&angles, dof, state.state_ref());
        let amplitude = range.iter().zip(&angles).map(|(range, period)| largest(*range, *period));
        let amplitude = amplitude.collect();
        let returned = motion.metric(&angles).distance(&start.concat(), &end.concat());
        Ok(Steady { amplitude, supplied: mean(&gained), dissipated: mean(&w), returned })
    }
}

impl Dynamics for Resonance {
    /// The rows, each with its failure, which no table contains.
    type Piece = Vec<(ResonanceRow, Option<String>)>;
    type Found = Vec<ResonanceRow>;

    /// The frequencies one after another, upwards and downwards.
    fn pieces(&self) -> Vec<PiecePlan> {
        let interval = Self::SECTION.interval(&self.problem.model).unwrap_or(1.0);
        let runs = self.values.len();
        let time = interval * (self.transient + self.periods) as f64 * runs as f64;
        ["/up", "/down"].map(|way| PiecePlan { key: way.to_owned(), time, runs }).into()
    }

    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        piece: usize,
        progress: &dyn Progress,
    ) -> Result<Self::Piece, MapError> {
        let way = if piece == 0 { Way::Up } else { Way::Down };
        let apart = |row: ResonanceRow| (row.clone(), row.failure);
        Ok(self.branch(row, h, way, progress)?.into_iter().map(apart).collect())
    }

    fn join(&self, _row: &'static Row, _h: f64, pieces: Vec<Self::Piece>) -> Vec<ResonanceRow> {
        let with = |(row, failure)| ResonanceRow { failure, ..row };
        pieces.into_iter().flatten().map(with).collect()
    }
}

/// The ending of a run whose motion does not repeat.
fn unsteady() -> Ending {
    Ending { outcome: UNSTEADY, failure: None }
}

/// The measures of a steady motion.
struct Steady {
    amplitude: Vec<f64>,
    supplied: f64,
    dissipated: f64,
    /// The distance from the first state of the measured periods to the last.
    returned: f64,
}

/// Looks for the states at which a coordinate turns back, where its velocity changes sign.
struct Turns<'a> {
    system: &'a dyn System<f64>,
    before: State<Vec<f64>>,
    velocity: Vec<f64>,
}

impl<'a> Turns<'a> {
    fn new(system: &'a dyn System<f64>, state: &State<Vec<f64>>) -> Self {
        let velocity = velocity(system, state.state_ref());
        Self { system, before: state.clone(), velocity }
    }

    /// Extends the ranges of the coordinates to those between the last state and this one.
    fn see(&mut self, run: &Run<f64>, h: f64, now: StateRef<'_, f64>, range: &mut [[f64; 2]]) {
        let after = velocity(self.system, now);
        for (j, [least, most]) in range.iter_mut().enumerate() {
            let mut extend = |q: f64| (*least, *most) = (least.min(q), most.max(q));
            extend(now.q[j]);
            if self.velocity[j] * after[j] < 0.0 {
                let distance = |state: StateRef<'_, f64>| velocity(self.system, state)[j];
                extend(at_zero(run, h, distance, &self.before, now).q[j]);
            }
        }
        copy(now, &mut self.before);
        self.velocity = after;
    }
}

/// The largest |q| of a range. The range of an angle is moved by whole turns, so that this is
/// least.
fn largest([least, most]: [f64; 2], period: Option<f64>) -> f64 {
    let middle = least.midpoint(most);
    let turns = period.map_or(0.0, |period| middle - nearest(middle, period));
    (least - turns).abs().max((most - turns).abs())
}

/// ∂H/∂p
fn velocity(system: &dyn System<f64>, state: StateRef<'_, f64>) -> Vec<f64> {
    let [mut hq, mut v] = [(); 2].map(|()| vec![0.0; state.q.len()]);
    system.gradient(state.q, state.p, &mut hq, &mut v);
    v
}
