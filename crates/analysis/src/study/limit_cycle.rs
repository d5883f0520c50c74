//! Limit cycles of a method: period, amplitude and Floquet multipliers, and their branches in a
//! parameter.
//!
//! A cycle is a solution of Φ_h^n(z) = z with T = n h (`limit_cycle/shooting.rs`), so that it is a
//! cycle of the method itself. If the system has a period P in t, T is a multiple of it, and each P
//! has a whole number of steps of nearly h. Otherwise T is unknown, n = round(T/h), and z lies in
//! the plane through the first guess normal to the motion there. The multipliers are the
//! eigenvalues of ∂Φ_h^n/∂z. If T is unknown, one of them is 1 but for the error of the
//! discretisation. Sources: R. Seydel, Practical Bifurcation and Stability Analysis (2010),
//! chapters 6 and 7; Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapter 10.
//!
//! The first guess is a state of a run after a transient (`limit_cycle/guess.rs`). Every reason for
//! which there is no cycle has a name ([`CycleFailure`]).

mod branch;
mod cycle;
mod event;
mod failure;
mod guess;
mod homoclinic;
mod multipliers;
mod scales;
mod shooting;
mod turns;

pub use branch::Branch;
pub use cycle::Cycle;
pub use event::Event;
pub use failure::CycleFailure;
pub use multipliers::Complex;

use super::dynamics::{Dynamics, PiecePlan};
use super::metric::Metric;
use super::outcome::Ending;
use super::section::Section;
use super::stability::MapError;
use super::{Problem, numbered};
use crate::Model;
use crate::progress::Progress;
use crate::words::by_name;
use afterbay_core::{Grid, InputError};
use afterbay_methods::registry::Row;
use guess::Guess;
use scales::scales_of;
use serde::{Deserialize, Serialize};
use shooting::{Condition, Image, SINGULAR, Shooting, Solved};

/// The least number of steps in a cycle. Two steps have no direction.
const FEWEST_STEPS: f64 = 3.0;
/// The most steps in a cycle, whose states are stored.
const MOST_STEPS: f64 = 1e6;
/// The extent of a cycle, relative to its size, below which it is a state at rest.
const AT_REST: f64 = 1e-6;
/// The distance below which a cycle repeats earlier, relative to its size.
const REPEATS: f64 = 1e-7;

/// The limit cycle of a problem.
#[derive(Clone, Debug)]
pub struct LimitCycle {
    /// The system, the initial state, and the end of time, which is not used.
    pub problem: Problem,
    /// The time of the run that leads to the first guess; without a drive the search for a return
    /// takes at most as long again.
    pub transient: f64,
    /// The number of periods in t of the system in the cycle [default: found].
    pub multiple: Option<u64>,
    /// The parameter in which the cycle is followed, if there is one.
    pub branch: Option<Branch>,
}

/// A cycle, and the bifurcation that it is, if it is one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The cycle.
    pub cycle: Cycle,
    /// The bifurcation.
    pub event: Option<Event>,
}

/// A row of `limit_cycle.csv`, under the [`columns`]. A run that fails has a last row without a
/// cycle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CycleRow {
    /// Name of the method, or "reference".
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// Name of the parameter, along a branch.
    pub parameter: Option<String>,
    /// Its value.
    pub value: Option<f64>,
    /// The period.
    pub period: Option<f64>,
    /// max |q_j| of each degree of freedom, without turns: [`Cycle::amplitude`].
    pub amplitude: Vec<Option<f64>>,
    /// Real and imaginary part of each multiplier, the largest first; none for those that are lost
    /// in the roundings of the largest.
    pub multipliers: Vec<Option<f64>>,
    /// The outcome of the run.
    pub outcome: &'static str,
    /// The bifurcation.
    pub event: Option<Event>,
}

/// The names of the columns: `method,h,parameter,value,period,amplitude_1..N,multiplier_1_re,
/// multiplier_1_im,..,outcome,event`.
pub fn columns(model: &Model) -> Vec<String> {
    let names = ["method", "h", "parameter", "value", "period"].map(String::from).into_iter();
    let n = model.degrees();
    let parts = |name: String| ["re", "im"].map(|part| format!("{name}_{part}"));
    let multipliers = numbered("multiplier_", 2 * n).flat_map(parts);
    let last = ["outcome", "event"].map(String::from);
    names.chain(numbered("amplitude_", n)).chain(multipliers).chain(last).collect()
}

/// The cycles of a method and a step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cycles {
    /// The method.
    #[serde(with = "by_name")]
    pub row: &'static Row,
    /// The step, nearly: that of a cycle divides its period.
    pub h: f64,
    /// The cycles, in the order of the branch.
    pub points: Vec<Point>,
    /// The outcome of the run.
    pub ending: Ending,
}

impl Cycles {
    /// The rows of the table.
    pub fn rows(&self, parameter: Option<&str>, dof: usize) -> Vec<CycleRow> {
        let blank = CycleRow {
            method: self.row.name,
            h: self.h,
            parameter: parameter.map(String::from),
            value: None,
            period: None,
            amplitude: vec![None; dof],
            multipliers: vec![None; 4 * dof],
            outcome: self.ending.outcome,
            event: None,
        };
        let parts = |of: Option<Complex>| of.map_or([None; 2], |parts| parts.map(Some));
        let row = |Point { cycle, event }: &Point| CycleRow {
            h: cycle.h,
            value: cycle.value,
            period: Some(cycle.period),
            amplitude: cycle.amplitude.iter().copied().map(Some).collect(),
            multipliers: cycle.multipliers.iter().flat_map(|&of| parts(cycle.known(of))).collect(),
            event: *event,
            ..blank.clone()
        };
        let failed = (!self.ending.is_completed()).then(|| blank.clone());
        self.points.iter().map(row).chain(failed).collect()
    }

    /// The bifurcations of one kind, in the order of the branch.
    pub fn events(&self, event: Event) -> impl Iterator<Item = &Cycle> {
        let is_one = move |point: &&Point| point.event == Some(event);
        self.points.iter().filter(is_one).map(|point| &point.cycle)
    }
}

impl Dynamics for LimitCycle {
    type Piece = Cycles;
    type Found = Cycles;

    /// One piece: a branch is followed from cycle to cycle.
    fn pieces(&self) -> Vec<PiecePlan> {
        vec![PiecePlan { key: String::new(), time: self.transient, runs: 1 }]
    }

    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        _piece: usize,
        progress: &dyn Progress,
    ) -> Result<Cycles, MapError> {
        let found = self.cycles(row, h, progress)?;
        progress.advance();
        Ok(found)
    }

    fn join(&self, row: &'static Row, h: f64, pieces: Vec<Cycles>) -> Cycles {
        let none = Cycles { row, h, points: Vec::new(), ending: Ending::interrupted() };
        pieces.into_iter().next().unwrap_or(none)
    }
}

impl LimitCycle {
    /// The cycle of a method with steps of nearly h, or its branch.
    ///
    /// # Errors
    /// Invalid input. A run that finds no cycle has the reason as its ending, and keeps the cycles
    /// that it found before.
    fn cycles(
        &self,
        row: &'static Row,
        h: f64,
        progress: &dyn Progress,
    ) -> Result<Cycles, MapError> {
        Grid::<f64>::of(h, 1)?;
        let mut points = Vec::new();
        let ending = match self.points(row, h, progress, &mut points) {
            Ok(()) => Ending::completed(),
            Err(failure) => failure.ending()?,
        };
        Ok(Cycles { row, h, points, ending })
    }

    fn points(
        &self,
        row: &'static Row,
        h: f64,
        progress: &dyn Progress,
        points: &mut Vec<Point>,
    ) -> Result<(), CycleFailure> {
        let Some(branch) = &self.branch else {
            let (shooting, Solved { x, image, .. }) = self.find(&self.problem, row, h, progress)?;
            points.push(Point { cycle: Cycle::of(&shooting, &x, &image)?, event: None });
            return Ok(());
        };
        let model = self.problem.model.with(&branch.parameter, branch.from)?;
        let problem = Problem { model, ..self.problem.clone() };
        let (shooting, solved) = self.find(&problem, row, h, progress)?;
        branch.follow(shooting, solved, h, points)
    }

    /// The cycle near the end of the transient.
    fn find<'a>(
        &self,
        problem: &'a Problem,
        row: &'static Row,
        h: f64,
        progress: &'a dyn Progress,
    ) -> Result<(Shooting<'a>, Solved), CycleFailure> {
        let found = guess::guess(problem, row, h, self.transient, self.multiple, progress)?;
        let Guess { z, period, multiple } = found;
        let model = &problem.model;
        let mut x = z;
        x.extend(multiple.is_none().then_some(period));
        let scales = vec![1.0; x.len()];
        let mut shooting =
            Shooting { model, row, parameter: None, multiple, steps: 1, scales, progress };
        loop {
            shooting.steps = steps(row, model, h, shooting.multiple, period)?;
            let Image { path, residual, monodromy, .. } = shooting.image(&x)?;
            shooting.scales = scales_of(&path, &residual, &monodromy, &x);
            let phase = multiple.is_none().then(|| phase(&shooting, &path, &x));
            let solved = shooting.solve(x, phase.as_slice())?;
            if solved.ratio <= SINGULAR {
                return Err(CycleFailure::NotIsolated { ratio: solved.ratio });
            }
            if shooting.free() {
                at_rest(&shooting, &solved)?;
                let fewer = turns::fewer(&shooting, &solved, h)?;
                return Ok(fewer.unwrap_or((shooting, solved)));
            }
            let Some(part) = earlier(&shooting, &solved) else { return Ok((shooting, solved)) };
            shooting.multiple = Some(part);
            x = solved.x;
        }
    }
}

/// n for a cycle with steps of nearly h.
fn steps(
    row: &Row,
    model: &Model,
    h: f64,
    multiple: Option<u64>,
    period: f64,
) -> Result<u64, InputError> {
    let steps = match multiple {
        Some(multiple) => {
            let each = Section::Stroboscopic { interval: None }.grid_of(row, model, h)?.steps;
            multiple as f64 * each as f64
        }
        None => (period / h).round().max(FEWEST_STEPS),
    };
    if steps > MOST_STEPS {
        return Err(InputError::Budget { steps, limit: MOST_STEPS });
    }
    Ok(steps as u64)
}

/// The condition that z stays in the plane through the start of a path, normal to its first step.
fn phase(shooting: &Shooting<'_>, path: &[Vec<f64>], x: &[f64]) -> Condition {
    let mut normal = vec![0.0; x.len()];
    for (i, normal) in normal.iter_mut().enumerate().take(shooting.size()) {
        *normal = (path[1][i] - path[0][i]) / shooting.scales[i];
    }
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    normal.iter_mut().for_each(|x| *x /= length);
    Condition { normal, at: x.to_vec() }
}

/// The distance of states in the scales, less the whole turns of angles.
fn metric(shooting: &Shooting<'_>) -> Metric {
    Metric::with_units(&shooting.model.periods(), shooting.scales.clone())
}

/// Refuses a solution that stays where it is.
fn at_rest(shooting: &Shooting<'_>, solved: &Solved) -> Result<(), CycleFailure> {
    let path = &solved.image.path;
    let metric = metric(shooting);
    let extent = path.iter().map(|z| metric.distance(&path[0], z)).fold(0.0, f64::max);
    if extent > AT_REST {
        return Ok(());
    }
    let (q, p) = path[0].split_at(shooting.size() / 2);
    Err(CycleFailure::AtRest { q: q.to_vec(), p: p.to_vec() })
}

/// The number of periods in t after which a cycle repeats, if this is less than its multiple.
fn earlier(shooting: &Shooting<'_>, solved: &Solved) -> Option<u64> {
    let (multiple, path) = (shooting.multiple?, &solved.image.path);
    let (each, metric) = (shooting.steps / multiple, metric(shooting));
    let repeats = |&part: &u64| {
        multiple.is_multiple_of(part)
            && metric.distance(&path[0], &path[(part * each) as usize]) <= REPEATS
    };
    (1..multiple).find(repeats)
}
