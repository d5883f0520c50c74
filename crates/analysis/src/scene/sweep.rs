//! The points of a sweep: values of what is varied, and the problem at each.

use super::document::{Expression, Spacing, SweepTable, Varied};
use super::planner::Planner;
use super::problem::{SceneError, SceneProblem};
use super::{Scene, check_start, problem_of};
use crate::study::Problem;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal, Uniform};

/// The most points of a sweep.
const MOST_POINTS: f64 = 100_000.0;

/// A sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The names of the quantities that are varied, in the order of the values of a point.
    pub names: Vec<String>,
    /// The points. The last name varies fastest, then the draws of random values.
    pub points: Vec<Point>,
}

/// A point of a sweep.
#[derive(Clone, Debug)]
pub struct Point {
    /// The value of each name.
    pub values: Vec<f64>,
    /// The problem with these values.
    pub problem: Problem,
}

/// Something that is varied.
struct Axis {
    name: String,
    target: Target,
    values: Values,
}

#[derive(Clone, Copy)]
enum Target {
    Parameter,
    /// q_j, counted from 0
    Coordinate(usize),
    /// p_j
    Momentum(usize),
}

enum Values {
    Listed(Vec<f64>),
    Uniform(Uniform),
    Normal(Normal),
}

impl Values {
    /// The value of this listed index, or a draw.
    fn at(&self, index: usize, random: &mut Pcg64) -> f64 {
        // A number in (0, 1) of 53 bits.
        let mut share = || ((random.next_u64() >> 11) as f64 + 0.5) * 2f64.powi(-53);
        match self {
            Self::Listed(list) => list.get(index).copied().unwrap_or(f64::NAN),
            Self::Uniform(uniform) => uniform.inverse_cdf(share()),
            Self::Normal(normal) => normal.inverse_cdf(share()),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Listed(list) => list.len(),
            Self::Uniform(_) | Self::Normal(_) => 1,
        }
    }
}

impl Scene {
    /// The scene at a point of its sweep: the same with other parameters and another initial state.
    pub fn at(&self, point: &Point) -> Self {
        Self { problem: point.problem.clone(), sweep: None, ..self.clone() }
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
        let point = |index: u64| {
            let mut rest = index / samples;
            let mut indices = vec![0; axes.len()];
            for (at, axis) in indices.iter_mut().zip(&axes).rev() {
                let count = axis.values.len() as u64;
                *at = (rest % count) as usize;
                rest /= count;
            }
            // A stream of its own, so that a point is the same whatever else the sweep contains.
            let mut random = Pcg64::new(u128::from(table.seed), u128::from(index));
            let values: Vec<f64> = axes
                .iter()
                .zip(indices)
                .map(|(axis, index)| axis.values.at(index, &mut random))
                .collect();
            let problem = self.problem_at(&axes, &values)?;
            Ok(Point { values, problem })
        };
        let points: Vec<Result<Point, SceneError>> =
            (0..listed as u64 * samples).into_par_iter().map(point).collect();
        // The error is that of the first point, whatever the threads.
        let points = points.into_iter().collect::<Result<_, _>>()?;
        Ok(Some(Sweep { names: axes.into_iter().map(|axis| axis.name).collect(), points }))
    }

    fn axis(&self, name: &str, varied: &Varied) -> Result<Axis, SceneError> {
        let path = format!("sweep.vary.{name}");
        let known = self.problem.model.parameters();
        let entry = |letter: char| {
            let j: usize = name.strip_prefix(letter)?.parse().ok()?;
            (1..=self.problem.model.degrees()).contains(&j).then(|| j - 1)
        };
        let target = if known.contains(&name) {
            Target::Parameter
        } else if let Some(j) = entry('q') {
            Target::Coordinate(j)
        } else if let Some(j) = entry('p') {
            Target::Momentum(j)
        } else {
            let entries = ["q1", "p1"].into_iter();
            let known = known.into_iter().chain(entries).map(str::to_owned).collect();
            let what = "parameter or initial value";
            return self.refuse(&path, SceneProblem::Unknown { what, name: name.into(), known });
        };
        let of_drive = self.document.drive.as_ref().and_then(|drive| drive.parameters.get(name));
        if let Some(Expression::Text(_)) = of_drive.or(self.document.system.parameters.get(name)) {
            let why = "it is computed from other parameters";
            return self.refuse(&path, SceneProblem::NotVaried { name: name.into(), why });
        }
        Ok(Axis { name: name.into(), target, values: self.values(&path, varied)? })
    }

    fn values(&self, path: &str, varied: &Varied) -> Result<Values, SceneError> {
        let table = match varied {
            Varied::List(list) if list.is_empty() => {
                return self.refuse(path, SceneProblem::Empty { what: "value" });
            }
            Varied::List(list) => {
                self.list(path, list, |_| Ok(()))?;
                return Ok(Values::Listed(list.clone()));
            }
            Varied::Table(table) => table,
        };
        let ranged = table.count.is_some() || table.from.is_some() || table.to.is_some();
        let refuse = |key: &'static str, value: f64, range: &'static str| {
            self.refuse(&format!("{path}.{key}"), SceneProblem::Range { name: key, value, range })
        };
        match (ranged || table.scale.is_some(), table.uniform, table.normal) {
            (true, None, None) => {
                let missing = |key: &str| SceneProblem::Missing { key: key.into() };
                let (Some(from), Some(to), Some(count)) = (table.from, table.to, table.count)
                else {
                    let given = [
                        ("from", table.from.is_some()),
                        ("to", table.to.is_some()),
                        ("count", table.count.is_some()),
                    ];
                    let key = given.into_iter().find(|x| !x.1).map_or("count", |x| x.0);
                    return self.refuse(path, missing(key));
                };
                let scale = table.scale.unwrap_or(Spacing::Linear);
                self.range(path, (from, to), count, scale, f64::NEG_INFINITY).map(Values::Listed)
            }
            (false, Some([low, high]), None) => match Uniform::new(low, high) {
                Ok(uniform) if low < high => Ok(Values::Uniform(uniform)),
                _ => refuse("uniform", low, "below the other bound, both finite"),
            },
            (false, None, Some([mean, deviation])) => match Normal::new(mean, deviation) {
                Ok(normal) if mean.is_finite() && deviation.is_finite() => {
                    Ok(Values::Normal(normal))
                }
                _ => refuse("normal", deviation, "a mean and a positive standard deviation"),
            },
            _ => self.refuse(path, SceneProblem::OneForm),
        }
    }

    /// The number of draws at each combination of listed values.
    fn samples(&self, table: &SweepTable, axes: &[Axis]) -> Result<u64, SceneError> {
        let random = axes.iter().any(|axis| !matches!(axis.values, Values::Listed(_)));
        match table.samples {
            Some(0) => {
                let (name, range) = ("samples", "at least 1");
                self.refuse("sweep.samples", SceneProblem::Range { name, value: 0.0, range })
            }
            Some(_) if !random => {
                let (key, why) = ("samples", "nothing is random");
                self.refuse("sweep.samples", SceneProblem::Misplaced { key, why })
            }
            None if random => self.refuse("sweep", SceneProblem::Missing { key: "samples".into() }),
            samples => Ok(samples.unwrap_or(1)),
        }
    }

    /// The problem with other values. Expressions of parameters and of the initial state follow.
    fn problem_at(&self, axes: &[Axis], values: &[f64]) -> Result<Problem, SceneError> {
        let mut document = self.document.clone();
        for (axis, &value) in axes.iter().zip(values) {
            if let Target::Parameter = axis.target {
                let of_drive = document.drive.as_mut().map(|drive| &mut drive.parameters);
                let parameters = of_drive
                    .filter(|parameters| parameters.contains_key(&axis.name))
                    .unwrap_or(&mut document.system.parameters);
                parameters.insert(axis.name.clone(), Expression::Number(value));
            }
        }
        let within = |error: SceneError| {
            let at: Vec<String> = axes
                .iter()
                .zip(values)
                .map(|(axis, value)| format!("{} = {value}", axis.name))
                .collect();
            let problem =
                SceneProblem::AtPoint { at: at.join(", "), problem: Box::new(error.problem) };
            SceneError { problem, span: self.source.span("sweep.vary") }
        };
        let mut problem = problem_of(self.source, &document).map_err(within)?;
        for (axis, &value) in axes.iter().zip(values) {
            let entry = match axis.target {
                Target::Parameter => None,
                Target::Coordinate(j) => problem.q.get_mut(j),
                Target::Momentum(j) => problem.p.get_mut(j),
            };
            if let Some(entry) = entry {
                *entry = value;
            }
        }
        if problem.model.dof() != self.problem.model.dof() {
            let why = "it is the number of degrees of freedom";
            return self.refuse("sweep.vary", SceneProblem::NotVaried { name: "n".into(), why });
        }
        check_start(self.source, &problem).map_err(within)?;
        Ok(problem)
    }
}
