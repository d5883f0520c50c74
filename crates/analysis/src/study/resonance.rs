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
use super::outcome::{AT_REST, Ending};
use super::ranges::Ranges;
use super::section::{Section, nearest, point, rewind};
use super::stability::MapError;
use super::zero::{at_zero_in_part, copy, step_part};
use crate::Spacing;
use crate::progress::Progress;
use crate::solution::accounts;
use crate::words::{Word, word};
use crate::{Model, ModelError};
use afterbay_core::{Accounts, Grid, IntegrateError, State, StateRef, System};
use afterbay_methods::registry::{Row, Run};
use serde::{Deserialize, Serialize};

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

    /// The values, from the end of their range where the frequency of the drive is lower.
    fn rising_values(&self) -> Result<Vec<f64>, ModelError> {
        let mut values = self.values.clone();
        if let [first, .., last] = self.values[..] {
            let interval = |value| {
                let model = self.problem.model.with(&self.parameter, value)?;
                Ok::<_, ModelError>(Self::SECTION.interval(&model).unwrap_or(f64::INFINITY))
            };
            if interval(first)? < interval(last)? {
                values.reverse();
            }
        }
        Ok(values)
    }

    /// The frequencies in one order. A run that fails has a row without amplitudes, and the next
    /// begins at the initial state.
    fn branch(
        &self,
        row: &'static Row,
        h: f64,
        way: Way,
        progress: &dyn Progress,
    ) -> Result<Vec<ResonanceRow>, MapError> {
        let mut values = self.rising_values()?;
        if way == Way::Down {
            values.reverse();
        }
        let mut state: State<Vec<f64>> = self.problem.start()?;
        let mut rows = Vec::new();
        // A decay goes on from value to value.
        let mut since_start = Ranges::nothing(self.problem.model.degrees());
        for value in values {
            let model = self.problem.model.with(&self.parameter, value)?;
            let (run, grid) = (model.bind(row)?, Self::SECTION.grid_of(row, &model, h)?);
            let frequency = std::f64::consts::TAU / (grid.h * grid.steps as f64);
            let found = self.steady(&model, &run, grid, &mut state, progress);
            match found {
                Err(IntegrateError::Interrupted) => break,
                Err(IntegrateError::Input(error)) => return Err(error.into()),
                Err(IntegrateError::Run(_)) | Ok(_) => {}
            }
            if let Ok(steady) = &found {
                since_start.join(steady.motion.run());
            }
            let ending = match &found {
                Ok(steady) if steady.motion.is_rounding_beside(&since_start) => ended(AT_REST),
                Ok(steady) if steady.returned > STEADY => ended(UNSTEADY),
                _ => Ending::of(&found, 0, 0),
            };
            let steady = found.ok();
            if steady.is_none() || ending.outcome == AT_REST {
                state = self.problem.start()?;
                since_start.clear();
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
        progress: &dyn Progress,
    ) -> Result<Steady, IntegrateError> {
        let (dof, angles) = (model.degrees(), model.periods());
        // A period begins where the last one ended, less the whole turns of angles.
        let begin_anew = |state: &mut State<Vec<f64>>, from: &[f64]| {
            rewind(&mut state.q, &mut state.t, dof);
            for ((q, from), period) in state.q[..dof].iter_mut().zip(from).zip(&angles) {
                *q = period.map_or(*q, |period| from + nearest(*q - from, period));
            }
        };
        let go_on = || if progress.stopped() { Err(IntegrateError::Interrupted) } else { Ok(()) };
        let mut motion = Motion::new(dof);
        for _ in 0..self.transient {
            let from = state.q[..dof].to_vec();
            run.run(grid, state, 1, &mut |_, now| {
                motion.see(now);
                progress.flow()
            })?;
            go_on()?;
            begin_anew(state, &from);
        }
        motion.settle();
        // The accounts begin anew, so that what a period adds is not rounded to their sum.
        state.p[dof..].fill(0.0);
        state.w.fill(0.0);
        let system = model.system::<f64>()?;
        let start = point(&angles, dof, state.state_ref());
        for _ in 0..self.periods {
            let from = state.q[..dof].to_vec();
            let mut turns = Turns::new(&*system, grid, state);
            run.run(grid, state, 1, &mut |step, now| {
                motion.see(now);
                if step > 0 {
                    turns.see(run, grid.h, now, &mut motion);
                }
                progress.flow()
            })?;
            go_on()?;
            begin_anew(state, &from);
        }
        let Accounts { w, s, pumped } = accounts(state.state_ref(), &model.motors());
        let gained: Vec<f64> = s.into_iter().chain(pumped).collect();
        let mean = |all: &[f64]| all.iter().sum::<f64>() / self.periods as f64;
        let end = point(&angles, dof, state.state_ref());
        let amplitude =
            |(j, period): (usize, &Option<f64>)| largest(motion.settled().bounds(j), *period);
        let amplitude = angles.iter().enumerate().map(amplitude).collect();
        let returned = motion.own_metric(&angles).distance(&start.concat(), &end.concat());
        let (supplied, dissipated) = (mean(&gained), mean(&w));
        Ok(Steady { amplitude, supplied, dissipated, returned, motion })
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

/// The ending of a run whose motion is not steady.
fn ended(outcome: Word) -> Ending {
    Ending { outcome, failure: None }
}

/// The measures of a steady motion.
struct Steady {
    amplitude: Vec<f64>,
    supplied: f64,
    dissipated: f64,
    /// The distance from the first state of the measured periods to the last.
    returned: f64,
    /// With the states at which coordinates turn back.
    motion: Motion,
}

/// The least number of states in a period between which turns are looked for. A choice.
const LOOKS: f64 = 32.0;

/// Looks for the states at which a coordinate turns back, where its velocity changes sign. Long
/// steps are looked at in parts.
struct Turns<'a> {
    system: &'a dyn System<f64>,
    /// The number of parts of a step.
    parts: u32,
    /// The start of the step.
    start: State<Vec<f64>>,
    velocity: Vec<f64>,
}

impl<'a> Turns<'a> {
    fn new(system: &'a dyn System<f64>, grid: Grid<f64>, start: &State<Vec<f64>>) -> Self {
        let parts = (LOOKS / grid.steps as f64).ceil() as u32;
        Self { system, parts, start: start.clone(), velocity: velocity(system, start.state_ref()) }
    }

    /// Adds the states between the last one and this one to the motion.
    fn see(&mut self, run: &Run<f64>, h: f64, now: StateRef<'_, f64>, motion: &mut Motion) {
        let mut end = self.start.clone();
        copy(now, &mut end);
        let share = |k: u32| f64::from(k) / f64::from(self.parts);
        let inner: Vec<_> = (1..self.parts)
            .map(share)
            .filter_map(|at| Some((at, step_part(run, at * h, &self.start)?)))
            .collect();
        let mut before = (0.0, &self.start);
        for (at, after) in inner.iter().map(|(at, state)| (*at, state)).chain([(1.0, &end)]) {
            motion.see(after.state_ref());
            let velocities = velocity(self.system, after.state_ref());
            let turns = |&j: &usize| self.velocity[j] * velocities[j] < 0.0;
            for j in (0..velocities.len()).filter(turns) {
                let distance = |state: StateRef<'_, f64>| velocity(self.system, state)[j];
                let ends = [before, (at, after)];
                motion.see(at_zero_in_part(run, h, distance, &self.start, ends).state_ref());
            }
            (before, self.velocity) = ((at, after), velocities);
        }
        self.start = end;
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
