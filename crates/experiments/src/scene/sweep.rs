//! The points of a sweep: values of what is varied, and the problem at each. No point is kept:
//! there may be a million.

mod axis;

use super::document::{Document, Expression};
use super::planner::Planner;
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use super::{Scene, check_start, problem_of};
use crate::claim::in_full;
use afterbay_analysis::study::Problem;
use axis::{Axis, Target};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// The most points of a sweep.
const MOST_POINTS: f64 = 1e6;

/// A sweep. The last name varies fastest, then the draws of random values.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The names of the quantities that are varied, in the order of the values of a point.
    pub names: Vec<String>,
    axes: Vec<Axis>,
    /// The draws at each combination of listed values.
    samples: u64,
    seed: u64,
    /// The number of points.
    count: u64,
}

impl Sweep {
    /// The number of points, at least 1.
    pub fn count(&self) -> usize {
        self.count as usize
    }

    /// The value of each name at a point.
    pub fn values(&self, index: usize) -> Vec<f64> {
        let mut rest = index as u64 / self.samples;
        let mut indices = vec![0; self.axes.len()];
        for (at, axis) in indices.iter_mut().zip(&self.axes).rev() {
            let count = axis.values.len() as u64;
            *at = (rest % count) as usize;
            rest /= count;
        }
        // A stream of its own, so that a point is the same whatever else the sweep contains.
        let mut random = Pcg64::new(u128::from(self.seed), index as u128);
        let places = self.axes.iter().zip(indices);
        places.map(|(axis, index)| axis.values.at(index, &mut random)).collect()
    }

    /// The names and values of a point, in words.
    pub fn place(&self, index: usize) -> String {
        let values = self.values(index);
        let part = |(name, value): (&String, f64)| format!("{name} = {}", in_full(value));
        self.names.iter().zip(values).map(part).collect::<Vec<_>>().join(", ")
    }
}

impl Scene {
    /// The scene at a point of its sweep: the same with other parameters and another initial state.
    ///
    /// # Errors
    /// None at a point of the sweep: each was checked when the scene was read.
    pub fn at(&self, index: usize) -> Result<Self, SceneError> {
        let source = Source::parse("")?;
        let problem = match &self.sweep {
            Some(sweep) => Problems::new(&source, &self.document, sweep).at(index)?.clone(),
            None => self.problem.clone(),
        };
        Ok(Self { problem, sweep: None, ..self.clone() })
    }
}

impl Planner<'_> {
    /// The points of the sweep, at each of which the scene is valid.
    pub(super) fn sweep(&self) -> Result<Option<Sweep>, SceneError> {
        let Some(table) = &self.document.sweep else { return Ok(None) };
        let axes = table
            .vary
            .iter()
            .map(|(name, varied)| self.axis(name, varied))
            .collect::<Result<Vec<_>, _>>()?;
        if axes.is_empty() {
            return self.refuse("sweep.vary", SceneProblem::Empty { what: "thing to vary" });
        }
        let samples = self.samples(table, &axes)?;
        let listed: f64 = axes.iter().map(|axis| axis.values.len() as f64).product();
        self.budget(
            "sweep",
            "the number of points",
            (listed * samples as f64, MOST_POINTS),
            "give fewer values or samples",
        )?;
        let names = axes.iter().map(|axis| axis.name.clone()).collect();
        let count = listed as u64 * samples;
        let sweep = Sweep { names, axes, samples, seed: table.seed, count };
        let problems = || Problems::new(self.source, self.document, &sweep);
        let dof = self.problem.model.dof();
        let wrong = |problems: &mut Problems<'_>, index| match problems.at(index) {
            Ok(problem) if problem.model.dof() != dof => {
                let why = "it is the number of degrees of freedom";
                let varied = SceneProblem::NotVaried { name: "n".into(), why };
                self.refuse::<()>("sweep.vary", varied).err()
            }
            found => found.err(),
        };
        // The error is that of the first point, whatever the threads.
        let points = (0..sweep.count()).into_par_iter();
        match points.map_init(problems, wrong).find_map_first(|error| error) {
            Some(error) => Err(error),
            None => Ok(Some(sweep)),
        }
    }
}

/// Makes the problems of points. The model is made anew where parameters change.
struct Problems<'a> {
    source: &'a Source<'a>,
    document: Document,
    sweep: &'a Sweep,
    /// The values of the last point, and its problem.
    last: Option<(Vec<f64>, Problem)>,
}

impl<'a> Problems<'a> {
    fn new(source: &'a Source<'a>, document: &Document, sweep: &'a Sweep) -> Self {
        Self { source, document: document.clone(), sweep, last: None }
    }

    /// The problem at a point. Expressions of parameters and of the initial state follow.
    fn at(&mut self, index: usize) -> Result<&Problem, SceneError> {
        let values = self.sweep.values(index);
        let within = |error: SceneError| {
            let (at, problem) = (self.sweep.place(index), Box::new(error.problem));
            let problem = SceneProblem::AtPoint { at, problem };
            SceneError { problem, span: self.source.span("sweep.vary") }
        };
        let axes = || self.sweep.axes.iter().zip(&values);
        let is_parameter = |axis: &Axis| matches!(axis.target, Target::Parameter);
        let mut problem = match self.last.take() {
            Some((last, problem))
                if axes().zip(&last).all(|((axis, value), last)| {
                    !is_parameter(axis) || value.to_bits() == last.to_bits()
                }) =>
            {
                problem
            }
            _ => {
                for (axis, &value) in axes().filter(|(axis, _)| is_parameter(axis)) {
                    let of_drive = self.document.drive.as_mut().map(|drive| &mut drive.parameters);
                    let parameters = of_drive
                        .filter(|parameters| parameters.contains_key(&axis.name))
                        .unwrap_or(&mut self.document.system.parameters);
                    parameters.insert(axis.name.clone(), Expression::Number(value));
                }
                problem_of(self.source, &self.document).map_err(within)?
            }
        };
        for (axis, &value) in axes() {
            let entry = match axis.target {
                Target::Parameter => None,
                Target::Coordinate(j) => problem.q.get_mut(j),
                Target::Momentum(j) => problem.p.get_mut(j),
            };
            if let Some(entry) = entry {
                *entry = value;
            }
        }
        check_start(self.source, &problem).map_err(within)?;
        Ok(&self.last.insert((values, problem)).1)
    }
}
