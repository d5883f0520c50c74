//! Basins of attraction: the attractor that each of a grid of initial states reaches.
//!
//! No attractor is known beforehand. A run that has settled shows one: the states that repeat on
//! the section, or, if none repeats, the boxes that a long run visits. The other runs are compared
//! with the attractors found so far, and the first one that reaches none of them is followed until
//! it shows a new one (in the spirit of Datseris and Wagemakers 2022, with runs side by side).
//! Without a drive the boxes are those of its whole path, since the interval of the section has
//! nothing to do with the motion. A rest or a cycle from which small displacements grow is no
//! attractor: the run lies on a boundary.

mod distribution;
mod known;
mod map;
mod path;
mod repels;

use super::dynamics::Dynamics;
use super::ensemble::{Ensemble, GROUP, Member, Watch};
use super::outcome::{COMPLETED, Ending};
use super::section::{Section, point};
use super::stability::MapError;
use super::{Problem, numbered};
use crate::Model;
use crate::Variable;
use crate::progress::Progress;
use afterbay_core::{InputError, StateRef};
use afterbay_methods::registry::Row;
pub use known::Known;
use known::{Found, Nearby, Shown, same};
pub use map::{BasinMap, Cell};
use path::Path;
use serde::Serialize;
use std::ops::ControlFlow;

/// The most attractors that are told apart. Where there are more, as in a system without friction,
/// the other runs are unsettled.
const MOST_ATTRACTORS: usize = 24;
/// The most new attractors that are looked for between two comparisons of all runs.
const NEW_AT_ONCE: usize = 8;
/// The runs that look for attractors before all others, in each direction of the grid.
const SAMPLES: usize = 6;
/// The runs that are followed at once where those before have shown nothing new. It bounds the
/// states that are stored.
const TOGETHER: usize = 4 * GROUP;

/// The basins of a problem.
#[derive(Clone, Debug)]
pub struct Basins {
    /// The system, and the initial state of what the grid does not vary.
    pub problem: Problem,
    /// The stroboscopic section.
    pub section: Section,
    /// The two axes of the grid.
    pub axes: [Axis; 2],
    /// The returns to the section within which a run is compared with the attractors beside others.
    /// One that has reached none of them is followed until it shows a new one, for at most 4000
    /// returns more.
    pub longest: u64,
}

/// An axis of the grid: an entry of the initial state and its values.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Q or P.
    pub variable: Variable,
    /// The degree of freedom, counted from 0.
    pub dof: usize,
    /// The values, ascending.
    pub values: Vec<f64>,
}

/// A row of `basins.csv`, under the [`columns`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BasinRow {
    /// Name of the method, or "reference".
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// The initial coordinates.
    pub q: Vec<f64>,
    /// The initial momenta.
    pub p: Vec<f64>,
    /// The number of the attractor, counted from 1; 0 if the run reaches none.
    pub attractor: usize,
    /// Returns until the attractor was known.
    pub periods: u64,
    /// The outcome of the run: `completed`, `unsettled`, `unstable`, or its failure.
    pub outcome: &'static str,
}

/// The names of the columns: `method,h,q1..qN,p1..pN,attractor,periods,outcome`.
pub fn columns(model: &Model) -> Vec<String> {
    let n = model.degrees();
    let last = ["attractor", "periods", "outcome"].map(String::from);
    let first = ["method", "h"].map(String::from).into_iter();
    first.chain(numbered("q", n)).chain(numbered("p", n)).chain(last).collect()
}

/// The outcome of a run that reaches no attractor in time.
pub const UNSETTLED: &str = "unsettled";
/// The outcome of a run that comes to an equilibrium or a cycle that does not attract.
pub const UNSTABLE: &str = "unstable";

impl Basins {
    /// The map of a method with steps of nearly h.
    ///
    /// # Errors
    /// Invalid input, such as a method that does not apply.
    pub fn run(
        &self,
        row: &'static Row,
        h_near: f64,
        progress: &dyn Progress,
    ) -> Result<BasinMap, InputError> {
        let h = self.section.grid(&self.problem.model, h_near)?.h;
        let size = self.axes[0].values.len() * self.axes[1].values.len();
        let mut map = BasinMap { row, h, attractors: Vec::new(), cells: Vec::new() };
        let mut cells: Vec<Option<Cell>> = vec![None; size];
        let ensemble = Ensemble { row, parameter: "", section: &self.section, h: h_near, progress };
        for i in self.samples() {
            self.discover(&ensemble, &[i], &mut map.attractors, &mut cells)?;
        }
        loop {
            let open: Vec<usize> = (0..size).filter(|&i| cells[i].is_none()).collect();
            if open.is_empty() {
                break;
            }
            if map.attractors.len() >= MOST_ATTRACTORS {
                let ending = Ending { outcome: UNSETTLED, failure: None };
                let cell = Cell { attractor: None, periods: self.longest, ending };
                open.into_iter().for_each(|i| cells[i] = Some(cell.clone()));
                break;
            }
            let watch = |&i: &usize| {
                Ok((self.member(i)?, Nearby::new(self, &map.attractors, self.longest)))
            };
            let members = open.iter().map(watch).collect::<Result<Vec<_>, InputError>>()?;
            let ended = ensemble.follow(members)?;
            for (&i, (watch, ending)) in open.iter().zip(ended) {
                if watch.reached.is_some() || !ending.is_completed() {
                    let (attractor, periods) = (watch.reached, watch.returns);
                    cells[i] = Some(Cell { attractor, periods, ending });
                }
            }
            // The runs that reach none of the attractors show new ones.
            let left: Vec<usize> = open.into_iter().filter(|&i| cells[i].is_none()).collect();
            let (stride, before) = (left.len().div_ceil(NEW_AT_ONCE).max(1), map.attractors.len());
            for &i in left.iter().step_by(stride) {
                self.discover(&ensemble, &[i], &mut map.attractors, &mut cells)?;
            }
            if map.attractors.len() > before {
                continue;
            }
            // Another comparison would be that of before. Each run decides for itself.
            for group in left.chunks(TOGETHER) {
                if map.attractors.len() < MOST_ATTRACTORS {
                    self.discover(&ensemble, group, &mut map.attractors, &mut cells)?;
                }
            }
        }
        map.cells = cells.into_iter().flatten().collect();
        Ok(map)
    }

    /// Follows the runs of open cells until each reaches an attractor or shows one, and adds that
    /// to the others if it is new.
    fn discover(
        &self,
        ensemble: &Ensemble<'_>,
        group: &[usize],
        attractors: &mut Vec<Known>,
        cells: &mut [Option<Cell>],
    ) -> Result<(), InputError> {
        let open: Vec<usize> = group.iter().copied().filter(|&i| cells[i].is_none()).collect();
        let nearby = Nearby::new(self, attractors, self.longest);
        let ended = if self.is_autonomous() {
            self.look::<true>(ensemble, &open, &nearby)?
        } else {
            self.look::<false>(ensemble, &open, &nearby)?
        };
        for (&i, ((reached, periods, shown), mut ending)) in open.iter().zip(ended) {
            let mut attractor = reached;
            if ending.is_completed() && reached.is_none() {
                let found = match shown {
                    Some(Shown::Known(known)) => Some(known),
                    Some(Shown::Motion { from, extent }) => self.path(ensemble, &from, extent)?,
                    None => None,
                };
                ending.outcome = UNSETTLED;
                if let Some(found) = found {
                    attractor = same(self, attractors, &found);
                    if attractor.is_none() && self.repels(ensemble, found.cycle())? {
                        ending.outcome = UNSTABLE;
                    } else if attractor.is_none() && attractors.len() < MOST_ATTRACTORS {
                        attractors.push(found);
                        attractor = Some(attractors.len() - 1);
                    }
                }
                if attractor.is_some() {
                    ending.outcome = COMPLETED;
                }
            }
            cells[i] = Some(Cell { attractor, periods, ending });
        }
        Ok(())
    }

    /// Follows runs until each reaches a known attractor or has settled.
    fn look<const STEPS: bool>(
        &self,
        ensemble: &Ensemble<'_>,
        open: &[usize],
        nearby: &Nearby<'_>,
    ) -> Result<Vec<(Ended, Ending)>, InputError> {
        let watch = |&i: &usize| Ok((self.member(i)?, Found::<STEPS>::new(nearby.clone())));
        let members = open.iter().map(watch).collect::<Result<Vec<_>, InputError>>()?;
        let ended = ensemble.follow(members)?.into_iter();
        Ok(ended.map(|(watch, ending)| (watch.ended(), ending)).collect())
    }

    /// The attractor of a motion without a drive that has settled: its path from a state on it.
    fn path(
        &self,
        ensemble: &Ensemble<'_>,
        from: &[f64],
        extent: f64,
    ) -> Result<Option<Known>, InputError> {
        let path = Path::new(Nearby::new(self, &[], self.longest), extent);
        let ended = ensemble.follow(vec![(self.member_at(from)?, path)])?.pop();
        Ok(ended.filter(|ended| ended.1.is_completed()).and_then(|(path, _)| path.known()))
    }

    /// Whether the equations do not depend on the time, so that the section has no part in the
    /// motion.
    pub fn is_autonomous(&self) -> bool {
        let model = &self.problem.model;
        model.motors().count() == 0 && !model.has_clock()
    }

    /// The cells whose runs look for attractors first: some that are spread over the grid.
    fn samples(&self) -> Vec<usize> {
        let [width, height] = self.axes.each_ref().map(|axis| axis.values.len());
        let places = |count: usize| {
            let samples = SAMPLES.min(count);
            (0..samples).map(move |k| (2 * k + 1) * count / (2 * samples))
        };
        places(height).flat_map(|row| places(width).map(move |x| row * width + x)).collect()
    }

    /// The initial state of a cell.
    pub fn start(&self, i: usize) -> [Vec<f64>; 2] {
        let width = self.axes[0].values.len();
        let (mut q, mut p) = (self.problem.q.clone(), self.problem.p.clone());
        for (axis, at) in self.axes.iter().zip([i % width, i / width]) {
            let part = if axis.variable == Variable::Q { &mut q } else { &mut p };
            part[axis.dof] = axis.values[at];
        }
        [q, p]
    }

    fn member(&self, i: usize) -> Result<Member, InputError> {
        self.member_at(&self.start(i).concat())
    }

    /// A run from a state (q, p) on the section.
    fn member_at(&self, at: &[f64]) -> Result<Member, InputError> {
        let (q, p) = at.split_at(self.problem.q.len());
        let (q, p) = (q.to_vec(), p.to_vec());
        let problem = Problem { q, p, ..self.problem.clone() };
        let start = problem.start()?;
        Ok(Member { value: 0.0, model: problem.model, start })
    }

    /// The rows of the table.
    pub fn rows<'a>(&'a self, map: &'a BasinMap) -> impl Iterator<Item = BasinRow> + 'a {
        map.cells.iter().enumerate().map(|(i, cell)| {
            let [q, p] = self.start(i);
            BasinRow {
                method: map.row.name,
                h: map.h,
                q,
                p,
                attractor: cell.attractor.map_or(0, |attractor| attractor + 1),
                periods: cell.periods,
                outcome: cell.ending.outcome,
            }
        })
    }
}

impl Dynamics for Basins {
    type Piece = BasinMap;
    type Found = BasinMap;

    /// One piece: each run is compared with the attractors found before.
    fn pieces(&self) -> Vec<(String, f64, usize)> {
        let runs: usize = self.axes.iter().map(|axis| axis.values.len()).product();
        let interval = self.section.interval(&self.problem.model).unwrap_or(1.0);
        vec![(String::new(), interval * self.longest as f64 * runs as f64, runs)]
    }

    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        _piece: usize,
        progress: &dyn Progress,
    ) -> Result<BasinMap, MapError> {
        Ok(self.run(row, h, progress)?)
    }

    fn join(&self, row: &'static Row, h: f64, pieces: Vec<BasinMap>) -> BasinMap {
        let none = BasinMap { row, h, attractors: Vec::new(), cells: Vec::new() };
        pieces.into_iter().next().unwrap_or(none)
    }
}

/// The known attractor that a run has reached, its returns, and what it shows.
type Ended = (Option<usize>, u64, Option<Shown>);

impl<const STEPS: bool> Watch for Found<'_, STEPS> {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>) -> ControlFlow<()> {
        self.add(n, point(self.periods(), self.dof(), state).concat())
    }

    fn step(&mut self, state: StateRef<'_, f64>) {
        if STEPS {
            let at = point(self.periods(), self.dof(), state).concat();
            self.pass(&at);
        }
    }

    const WANTS_STEPS: bool = STEPS;
}

impl Watch for Path<'_> {
    fn see(&mut self, n: u64, _: StateRef<'_, f64>) -> ControlFlow<()> {
        Self::goes_on(n)
    }

    fn step(&mut self, state: StateRef<'_, f64>) {
        let at = point(self.periods(), self.dof(), state).concat();
        self.pass(at);
    }

    const WANTS_STEPS: bool = true;
}

impl Watch for Nearby<'_> {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>) -> ControlFlow<()> {
        let at = point(&self.periods, self.dof, state).concat();
        self.compare(n, &at)
    }
}
