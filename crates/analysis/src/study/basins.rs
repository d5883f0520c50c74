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
mod found;
mod known;
mod map;
mod path;
mod repels;
mod survey;
mod units;

use super::dynamics::{Dynamics, PiecePlan};
use super::ensemble::{Ensemble, Member};
use super::section::Section;
use super::stability::MapError;
use super::{Problem, numbered};
use crate::Model;
use crate::Variable;
use crate::progress::Progress;
use afterbay_core::InputError;
use afterbay_methods::registry::Row;
pub use known::Known;
pub use map::{BasinMap, Cell};
use serde::Serialize;
use survey::Survey;

/// The runs that look for attractors before all others, in each direction of the grid.
const SAMPLES: usize = 6;

/// The basins of a problem.
#[derive(Clone, Debug)]
pub struct Basins {
    /// The system, and the initial values of the entries that the grid does not vary.
    pub problem: Problem,
    /// The stroboscopic section.
    pub section: Section,
    /// The two axes of the grid.
    pub axes: [Axis; 2],
    /// The returns to the section within which a run is compared with the attractors beside others.
    /// One that has reached none of them is followed until it shows a new one, for at most 4000
    /// returns more. One that shows an attractor without a period is followed for 8000 more.
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
    /// The outcome of the run: `completed`, `unsettled`, `unstable`, `too-many-attractors`, or its
    /// failure.
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
/// The outcome of a run that reaches none of the [`MOST_ATTRACTORS`] that were found.
pub const TOO_MANY: &str = "too-many-attractors";
/// The most attractors that are told apart.
pub const MOST_ATTRACTORS: usize = 24;
/// The outcome of a run that comes to an equilibrium or a cycle that does not attract.
pub const UNSTABLE: &str = "unstable";

impl Basins {
    /// The map of a method with steps of nearly h.
    ///
    /// # Errors
    /// Invalid input, such as a method that does not apply.
    fn map(
        &self,
        row: &'static Row,
        h_near: f64,
        progress: &dyn Progress,
    ) -> Result<BasinMap, InputError> {
        let h = self.section.grid(&self.problem.model, h_near)?.h;
        let ensemble = Ensemble { row, parameter: "", section: &self.section, h: h_near, progress };
        Survey::new(self, ensemble)?.map(h)
    }

    /// Whether the equations do not depend on the time, so that the section has no part in the
    /// motion.
    pub fn is_autonomous(&self) -> bool {
        self.problem.model.is_autonomous()
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

    /// The initial q and p of cell i. The cells are counted row by row: the value of the first axis
    /// changes from one to the next.
    pub fn start(&self, i: usize) -> [Vec<f64>; 2] {
        let width = self.axes[0].values.len();
        let (mut q, mut p) = (self.problem.q.clone(), self.problem.p.clone());
        for (axis, at) in self.axes.iter().zip([i % width, i / width]) {
            let part = if axis.variable == Variable::Q { &mut q } else { &mut p };
            part[axis.dof] = axis.values[at];
        }
        [q, p]
    }

    /// The entry of (q, p) that an axis varies.
    fn entry(&self, axis: &Axis) -> usize {
        let before = if axis.variable == Variable::Q { 0 } else { self.problem.q.len() };
        before + axis.dof
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
    fn pieces(&self) -> Vec<PiecePlan> {
        let runs: usize = self.axes.iter().map(|axis| axis.values.len()).product();
        let interval = self.section.interval(&self.problem.model).unwrap_or(1.0);
        let time = interval * self.longest as f64 * runs as f64;
        vec![PiecePlan { key: String::new(), time, runs }]
    }

    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        _piece: usize,
        progress: &dyn Progress,
    ) -> Result<BasinMap, MapError> {
        Ok(self.map(row, h, progress)?)
    }

    fn join(&self, row: &'static Row, h: f64, pieces: Vec<BasinMap>) -> BasinMap {
        let none = BasinMap { row, h, attractors: Vec::new(), cells: Vec::new() };
        pieces.into_iter().next().unwrap_or(none)
    }
}
