//! Poincaré sections: the states of runs at every return to a section, after a transient.

use super::attractor::{Attractor, Traits};
use super::dynamics::{Dynamics, PiecePlan};
use super::ensemble::{Ensemble, GROUP, Member, Watch};
use super::metric::Metric;
use super::outcome::Ending;
use super::ranges::Ranges;
use super::returns::Returns;
use super::section::Section;
use super::stability::MapError;
use super::{Problem, numbered};
use crate::Model;
use crate::progress::Progress;
use crate::words::{Word, word};
use afterbay_core::{InputError, StateRef};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// A Poincaré section of a problem.
#[derive(Clone, Debug)]
pub struct Poincare {
    /// The system and the end of time, which is not used.
    pub problem: Problem,
    /// The section.
    pub section: Section,
    /// The initial states (q, p) of the runs.
    pub starts: Vec<[Vec<f64>; 2]>,
    /// Returns that are not kept.
    pub transient: u64,
    /// Returns that are kept of each run.
    pub points: u64,
}

/// A row of `poincare.csv`, under the [`columns`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoincareRow {
    /// Name of the method, or "reference".
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// Time.
    pub t: f64,
    /// Coordinates. Those with a period lie within half of it from 0.
    pub q: Vec<f64>,
    /// Momenta.
    pub p: Vec<f64>,
    /// The number of the start, counted from 1.
    pub start: usize,
}

/// The names of the columns: `method,h,t,q1..qN,p1..pN,start`.
pub fn columns(model: &Model) -> Vec<String> {
    let names = ["method", "h", "t"].map(String::from).into_iter();
    let n = model.degrees();
    names.chain(numbered("q", n)).chain(numbered("p", n)).chain(["start".into()]).collect()
}

/// The points of a method and a step.
#[derive(Clone, Debug)]
pub struct Portrait {
    /// The method.
    pub row: &'static Row,
    /// The step.
    pub h: f64,
    /// The points of each start, one start after another.
    pub rows: Vec<PoincareRow>,
    /// The outcome of the run from each start. One that grows all along is `growing`.
    pub endings: Vec<Ending>,
    /// The distance of the points from each start, and further properties of the motion.
    motions: Vec<(Metric, Traits)>,
}

impl Portrait {
    /// The attractor that the run from each start shows; none if it did not reach its end.
    pub fn attractors(&self) -> Vec<Option<Attractor>> {
        let of_start = |(start, (metric, traits)): (usize, &(Metric, Traits))| {
            let rows = self.rows.iter().filter(|row| row.start == start + 1);
            let points = rows.map(|row| [&row.q[..], &row.p].concat()).collect();
            let attractor = Attractor::of(points, metric.clone())?.with(*traits);
            self.endings[start].is_completed().then_some(attractor)
        };
        self.motions.iter().enumerate().map(of_start).collect()
    }
}

impl Dynamics for Poincare {
    type Piece = (f64, Vec<Trail>);
    type Found = Portrait;

    /// Runs side by side.
    fn pieces(&self) -> Vec<PiecePlan> {
        let interval = self.section.interval(&self.problem.model).unwrap_or(1.0);
        let time = interval * (self.transient + self.points) as f64;
        let group = |first: usize| {
            let end = self.starts.len().min(first + GROUP);
            let runs = end - first;
            let key = format!("/starts={}-{end}", first + 1);
            PiecePlan { key, time: time * runs as f64, runs }
        };
        (0..self.starts.len()).step_by(GROUP).map(group).collect()
    }

    /// The step, and the points of each run.
    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        piece: usize,
        progress: &dyn Progress,
    ) -> Result<Self::Piece, MapError> {
        let Self { problem, section, transient, points, .. } = self;
        let (model, h_near) = (&problem.model, h);
        let h = section.grid(model, h_near)?.h;
        let starts = self.starts.iter().enumerate().skip(piece * GROUP).take(GROUP);
        let members = starts.map(|(start, [q, p])| {
            let problem = Problem { q: q.clone(), p: p.clone(), ..problem.clone() };
            let member = Member { value: 0.0, model: model.clone(), start: problem.start()? };
            let blank = PoincareRow {
                method: row.name,
                h,
                t: 0.0,
                q: Vec::new(),
                p: Vec::new(),
                start: start + 1,
            };
            let returns = Returns::new(model.periods(), *transient, *points);
            Ok((member, Trace { returns, blank, rows: Vec::new() }))
        });
        let members = members.collect::<Result<Vec<_>, InputError>>()?;
        let ensemble = Ensemble { row, parameter: "", section, h: h_near, progress };
        let trail = |(trace, ending): (Trace, Ending)| Trail {
            ending: trace.returns.ending(ending),
            motion: (trace.returns.metric(), trace.returns.traits(trace.returns.run())),
            rows: trace.rows,
        };
        Ok((h, ensemble.follow(members)?.into_iter().map(trail).collect()))
    }

    fn join(&self, row: &'static Row, h: f64, pieces: Vec<Self::Piece>) -> Portrait {
        let h = pieces.first().map_or(h, |piece| piece.0);
        let (mut rows, mut endings, mut motions) = (Vec::new(), Vec::new(), Vec::new());
        for trail in pieces.into_iter().flat_map(|piece| piece.1) {
            rows.extend(trail.rows);
            endings.push(trail.ending);
            motions.push(trail.motion);
        }
        Portrait { row, h, rows, endings, motions }
    }
}

/// The points of the run from one start, its outcome, and the properties of its motion.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Trail {
    rows: Vec<PoincareRow>,
    ending: Ending,
    motion: (Metric, Traits),
}

/// The points of one run so far.
struct Trace {
    returns: Returns,
    blank: PoincareRow,
    rows: Vec<PoincareRow>,
}

impl Watch for Trace {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>, path: &Ranges) -> ControlFlow<()> {
        if let Some([q, p]) = self.returns.see(n, state, path) {
            self.rows.push(PoincareRow { t: state.t, q, p, ..self.blank.clone() });
        }
        self.returns.go_on(n)
    }
}
