//! Bifurcation diagrams: the states on a section, after a transient, against a parameter.

use super::attractor::{Attractor, Traits};
use super::dynamics::{Dynamics, PiecePlan};
use super::ensemble::{Ensemble, GROUP, Member, Watch};
use super::growing::GROWING;
use super::metric::Metric;
use super::outcome::Ending;
use super::ranges::Ranges;
use super::returns::Returns;
use super::section::Section;
use super::{Problem, numbered};
use crate::Model;
use crate::Spacing;
use crate::progress::Progress;
use crate::study::stability::MapError;
use afterbay_core::{State, StateRef};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// A bifurcation diagram of a problem.
#[derive(Clone, Debug)]
pub struct Bifurcation {
    /// The system and the initial state.
    pub problem: Problem,
    /// The section.
    pub section: Section,
    /// The name of the parameter that is varied.
    pub parameter: String,
    /// Its values.
    pub values: Vec<f64>,
    /// The spacing of the values.
    pub spacing: Spacing,
    /// Returns that are not kept.
    pub transient: u64,
    /// Returns that are kept of each value.
    pub points: u64,
    /// Whether a run begins where that of the value before ended, upwards and downwards. Otherwise
    /// each begins at the initial state.
    pub follow: bool,
}

/// The order in which the values of the parameter are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// Each from the initial state.
    Afresh,
    /// From the first value to the last, each from the state of the one before.
    Up,
    /// From the last value to the first.
    Down,
}

/// A row of `bifurcation.csv`, under the [`columns`]. A run that fails has a last row without a
/// point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BifurcationRow {
    /// Name of the method, or "reference".
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// Name of the parameter.
    pub parameter: String,
    /// Its value.
    pub value: f64,
    /// `afresh`, `up` or `down`.
    pub direction: Way,
    /// Coordinates. Those with a period lie within half of it from 0.
    pub q: Vec<Option<f64>>,
    /// Momenta.
    pub p: Vec<Option<f64>>,
    /// The outcome of the run: `completed`, `growing`, or its failure.
    pub outcome: &'static str,
}

/// The names of the columns: `method,h,parameter,value,direction,q1..qN,p1..pN,outcome`.
pub fn columns(model: &Model) -> Vec<String> {
    let names = ["method", "h", "parameter", "value", "direction"].map(String::from).into_iter();
    let n = model.degrees();
    names.chain(numbered("q", n)).chain(numbered("p", n)).chain(["outcome".into()]).collect()
}

/// The points of one value of the parameter.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Column {
    /// The value.
    pub value: f64,
    /// The step.
    pub h: f64,
    /// The order in which the values were taken.
    pub way: Way,
    /// The points (q, p).
    pub points: Vec<[Vec<f64>; 2]>,
    /// The outcome of the run. One that grows all along is `growing`.
    pub ending: Ending,
    /// Properties of the motion. The run is at rest if its settled motion is small compared with
    /// all of the motion since the initial state.
    traits: Traits,
    /// The distance of the points.
    metric: Metric,
}

impl Column {
    /// The attractor that the points show; none if the run did not reach its end.
    pub fn attractor(&self) -> Option<Attractor> {
        let points = self.points.iter().map(|point| point.concat()).collect();
        let attractor = Attractor::of(points, self.metric.clone())?.with(self.traits);
        self.ending.is_completed().then_some(attractor)
    }

    /// Whether the run has failed. One that grows or was interrupted has not.
    pub fn failed(&self) -> bool {
        !self.ending.is_completed() && !self.ending.is_interrupted() && !self.grows()
    }

    /// Whether the run grows all along, and shows no attractor.
    pub fn grows(&self) -> bool {
        self.ending.outcome == GROWING
    }
}

/// The diagram of a method and a step.
#[derive(Clone, Debug)]
pub struct Diagram {
    /// The method.
    pub row: &'static Row,
    /// The step, nearly: that of a column divides the interval of its section.
    pub h: f64,
    /// The columns in the order of the values, those downwards after those upwards.
    pub columns: Vec<Column>,
}

impl Diagram {
    /// The rows of the table.
    pub fn rows(&self, parameter: &str, dof: usize) -> impl Iterator<Item = BifurcationRow> {
        self.columns.iter().flat_map(move |column| {
            let has_points = column.ending.is_completed() || column.grows();
            let ending = (!has_points).then(|| [vec![None; dof], vec![None; dof]]);
            let some = |[q, p]: &[Vec<f64>; 2]| {
                [q, p].map(|part| part.iter().copied().map(Some).collect::<Vec<_>>())
            };
            let row = |[q, p]: [Vec<Option<f64>>; 2]| BifurcationRow {
                method: self.row.name,
                h: column.h,
                parameter: parameter.to_owned(),
                value: column.value,
                direction: column.way,
                q,
                p,
                outcome: column.ending.outcome,
            };
            column.points.iter().map(some).chain(ending).map(row).collect::<Vec<_>>()
        })
    }
}

impl Bifurcation {
    fn model(&self, value: f64) -> Result<Model, MapError> {
        Ok(self.problem.model.with(&self.parameter, value)?)
    }

    fn afresh(
        &self,
        row: &'static Row,
        h: f64,
        values: &[f64],
        progress: &dyn Progress,
    ) -> Result<Vec<Column>, MapError> {
        let member = |&value: &f64| {
            let model = self.model(value)?;
            let periods = model.periods();
            let start = self.problem.start()?;
            Ok((Member { value, model, start }, self.trace(periods)))
        };
        let members = values.iter().map(member).collect::<Result<Vec<_>, MapError>>()?;
        let ended = self.ensemble(row, h, progress).follow(members)?;
        let column = |((trace, ending), &value): ((Trace, Ending), &f64)| {
            let h = self.section.grid_of(row, &self.model(value)?, h)?.h;
            let traits = trace.returns.traits(trace.returns.run());
            Ok(trace.column([value, h], Way::Afresh, ending, traits))
        };
        ended.into_iter().zip(values).map(column).collect()
    }

    /// One value after another. After a run that fails, grows or comes to rest, the next begins at
    /// the initial state. A decay goes on from value to value, so that the motion since the last
    /// such start decides whether a run rests.
    fn followed(
        &self,
        row: &'static Row,
        h: f64,
        way: Way,
        progress: &dyn Progress,
    ) -> Result<Vec<Column>, MapError> {
        let ensemble = self.ensemble(row, h, progress);
        let mut values = self.values.clone();
        if way == Way::Down {
            values.reverse();
        }
        let mut start = self.problem.start()?;
        let (mut columns, mut whole) = (Vec::new(), Ranges::nothing(self.problem.model.degrees()));
        for value in values {
            let model = self.model(value)?;
            let step = self.section.grid_of(row, &model, h)?.h;
            let trace = self.trace(model.periods());
            let member = Member { value, model, start };
            let Some((trace, ending)) = ensemble.follow(vec![(member, trace)])?.pop() else {
                break;
            };
            let (fresh, state) = (self.problem.start()?, trace.state.clone());
            whole.join(trace.returns.run());
            let traits = trace.returns.traits(&whole);
            let column = trace.column([value, step], way, ending, traits);
            start = match state {
                Some(state) if column.ending.is_completed() && !traits.rests => {
                    State { w: fresh.w, t: fresh.t, ..state }
                }
                _ => {
                    whole.clear();
                    fresh
                }
            };
            columns.push(column);
            if progress.stopped() {
                break;
            }
        }
        if way == Way::Down {
            columns.reverse();
        }
        Ok(columns)
    }

    fn ensemble<'a>(
        &'a self,
        row: &'static Row,
        h: f64,
        progress: &'a dyn Progress,
    ) -> Ensemble<'a> {
        Ensemble { row, parameter: &self.parameter, section: &self.section, h, progress }
    }

    fn trace(&self, periods: Vec<Option<f64>>) -> Trace {
        let returns = Returns::new(periods, self.transient, self.points);
        Trace { follow: self.follow, returns, points: Vec::new(), state: None }
    }
}

impl Dynamics for Bifurcation {
    type Piece = Vec<Column>;
    type Found = Diagram;

    /// Runs side by side, or the values one after another upwards and downwards.
    fn pieces(&self) -> Vec<PiecePlan> {
        let interval = self.section.interval(&self.problem.model).unwrap_or(1.0);
        let time = interval * (self.transient + self.points) as f64;
        let of = |key, runs| PiecePlan { key, time: time * runs as f64, runs };
        if self.follow {
            return ["/up", "/down"].map(|way| of(way.into(), self.values.len())).into();
        }
        let group = |first: usize| {
            let end = self.values.len().min(first + GROUP);
            of(format!("/values={}-{end}", first + 1), end - first)
        };
        (0..self.values.len()).step_by(GROUP).map(group).collect()
    }

    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        piece: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Column>, MapError> {
        match (self.follow, piece) {
            (true, 0) => self.followed(row, h, Way::Up, progress),
            (true, _) => self.followed(row, h, Way::Down, progress),
            (false, _) => {
                let values = self.values.chunks(GROUP).nth(piece).unwrap_or_default();
                self.afresh(row, h, values, progress)
            }
        }
    }

    fn join(&self, row: &'static Row, h: f64, pieces: Vec<Vec<Column>>) -> Diagram {
        Diagram { row, h, columns: pieces.into_iter().flatten().collect() }
    }
}

/// The points of one run so far.
struct Trace {
    follow: bool,
    returns: Returns,
    points: Vec<[Vec<f64>; 2]>,
    /// The last state.
    state: Option<State<Vec<f64>>>,
}

impl Trace {
    /// The points of a run that has ended.
    fn column(self, [value, h]: [f64; 2], way: Way, ending: Ending, traits: Traits) -> Column {
        let Self { returns, points, .. } = self;
        let (ending, metric) = (returns.ending(ending), returns.metric());
        Column { value, h, way, points, ending, traits, metric }
    }
}

impl Watch for Trace {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>, path: &Ranges) -> ControlFlow<()> {
        self.points.extend(self.returns.see(n, state, path));
        let go_on = self.returns.go_on(n);
        if self.follow && go_on.is_break() {
            self.state = Some(section_start(state, self.returns.dof()));
        }
        go_on
    }
}

/// A start from a state on the section: the motors of a drive stand at the start of its period and
/// have supplied nothing.
fn section_start(state: StateRef<'_, f64>, dof: usize) -> State<Vec<f64>> {
    let motors = |part: &[f64]| {
        let mut part = part.to_vec();
        part[dof..].fill(0.0);
        part
    };
    State { q: motors(state.q), p: motors(state.p), w: state.w.to_vec(), t: 0.0 }
}
