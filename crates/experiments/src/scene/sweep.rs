//! The points of a sweep: values of what is varied, and the problem at each. No point is kept:
//! there may be a million.

mod axis;

use super::document::{Document, Expression};
use super::planner::{Planner, Plans};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use super::{Scene, check_start, problem_of};
use crate::claim::in_full;
use afterbay_analysis::Spacing;
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

    /// The spacing of the values of the k-th quantity; none if they are a list.
    pub fn spacing(&self, k: usize) -> Option<Spacing> {
        self.axes[k].spacing
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
    /// [`SceneProblem::Unsupported`] if a method does not apply to the system at this point. All
    /// else was checked when the scene was read.
    pub fn at(&self, index: usize) -> Result<Self, SceneError> {
        let Some(sweep) = &self.sweep else { return Ok(self.clone()) };
        let source = &Source::parse("")?;
        let mut points = Points::new(source, &self.document, sweep);
        let problem = points.at(index)?.clone();
        let (document, steps) = (points.document, (problem.end / self.step).round() as u64);
        let points = sweep.count();
        let planner = Planner { source, document: &document, problem: &problem, steps, points };
        let Plans { run, studies, changing } = planner.plans()?;
        Ok(Self { problem, run, studies, changing, document, sweep: None, ..self.clone() })
    }
}

impl Planner<'_> {
    /// The sweep. Its points are not checked.
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
        Ok(Some(Sweep { names, axes, samples, seed: table.seed.unwrap_or(0), count }))
    }

    /// Checks the scene at every point.
    pub(super) fn check_points(&self, sweep: &Sweep) -> Result<(), SceneError> {
        let points = || Points::new(self.source, self.document, sweep);
        let wrong = |points: &mut Points<'_>, index| self.check(points, index).err();
        // The error is that of the first point, whatever the threads.
        let all = (0..sweep.count()).into_par_iter();
        all.map_init(points, wrong).find_map_first(|error| error).map_or(Ok(()), Err)
    }

    /// Checks the scene at a point.
    fn check(&self, points: &mut Points<'_>, index: usize) -> Result<(), SceneError> {
        let problem = points.at(index)?.clone();
        if problem.model.dof() != self.problem.model.dof() {
            let why = "it is the number of degrees of freedom";
            let varied = SceneProblem::NotVaried { name: "n".into(), why };
            return self.refuse("sweep.vary", varied);
        }
        let planner = Planner { document: &points.document, problem: &problem, ..*self };
        match planner.plans() {
            // The other points can be run.
            Ok(_) | Err(SceneError { problem: SceneProblem::Unsupported { .. }, .. }) => Ok(()),
            Err(error) => Err(points.error_at(index, error)),
        }
    }
}

/// Makes the problems of points. The model is made anew where parameters change.
struct Points<'a> {
    source: &'a Source<'a>,
    /// The document with the parameters of the last point.
    document: Document,
    sweep: &'a Sweep,
    /// The values of the last point, and its problem.
    last: Option<(Vec<f64>, Problem)>,
}

impl<'a> Points<'a> {
    fn new(source: &'a Source<'a>, document: &Document, sweep: &'a Sweep) -> Self {
        Self { source, document: document.clone(), sweep, last: None }
    }

    /// The problem at a point. Expressions of parameters and of the initial state follow.
    fn at(&mut self, index: usize) -> Result<&Problem, SceneError> {
        let values = self.sweep.values(index);
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
                let found = problem_of(self.source, &self.document);
                found.map_err(|error| self.error_at(index, error))?
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
        check_start(self.source, &problem).map_err(|error| self.error_at(index, error))?;
        Ok(&self.last.insert((values, problem)).1)
    }

    /// An error of a point, with its values.
    fn error_at(&self, index: usize, error: SceneError) -> SceneError {
        let (at, problem) = (self.sweep.place(index), Box::new(error.problem));
        let problem = SceneProblem::AtPoint { at, problem };
        SceneError { problem, span: self.source.span("sweep.vary") }
    }
}
