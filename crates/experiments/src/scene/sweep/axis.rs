//! The quantities that a sweep varies.

use super::super::document::{SweepTable, Varied};
use super::super::planner::Planner;
use super::super::problem::{SceneError, SceneProblem};
use afterbay_analysis::Spacing;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use statrs::distribution::{ContinuousCDF, Normal, Uniform};

/// A quantity that is varied.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) name: String,
    pub(super) target: Target,
    pub(super) values: Values,
    /// The spacing of a range, and of draws; none of a list.
    pub(super) spacing: Option<Spacing>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    Parameter,
    /// q_j, counted from 0
    Coordinate(usize),
    /// p_j
    Momentum(usize),
}

#[derive(Clone, Debug)]
pub(super) enum Values {
    Listed(Vec<f64>),
    Uniform(Uniform),
    Normal(Normal),
}

impl Values {
    /// The value of this listed index, or a draw.
    pub(super) fn at(&self, index: usize, random: &mut Pcg64) -> f64 {
        // A number in (0, 1) of 53 bits.
        let mut share = || ((random.next_u64() >> 11) as f64 + 0.5) * 2f64.powi(-53);
        match self {
            Self::Listed(list) => list.get(index).copied().unwrap_or(f64::NAN),
            Self::Uniform(uniform) => uniform.inverse_cdf(share()),
            Self::Normal(normal) => normal.inverse_cdf(share()),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Listed(list) => list.len(),
            Self::Uniform(_) | Self::Normal(_) => 1,
        }
    }
}

/// The most entries of q, and of p, that a message names one by one.
const MOST_NAMED: usize = 4;

/// The names of the entries of q or p, in a message.
fn entries(letter: char, dof: usize) -> Vec<String> {
    let name = |j: usize| format!("{letter}{j}");
    if dof <= MOST_NAMED {
        return (1..=dof).map(name).collect();
    }
    vec![name(1), name(2), "..".into(), name(dof)]
}

impl Planner<'_> {
    pub(super) fn axis(&self, name: &str, varied: &Varied) -> Result<Axis, SceneError> {
        let path = format!("sweep.vary.{name}");
        self.not_computed(&path, name)?;
        let (known, dof) = (self.problem.model.parameters(), self.problem.model.degrees());
        let entry = |letter: char| {
            let j: usize = name.strip_prefix(letter)?.parse().ok()?;
            (1..=dof).contains(&j).then(|| j - 1)
        };
        let target = if known.contains(&name) {
            Target::Parameter
        } else if let Some(j) = entry('q') {
            Target::Coordinate(j)
        } else if let Some(j) = entry('p') {
            Target::Momentum(j)
        } else {
            let entries = ['q', 'p'].into_iter().flat_map(|letter| entries(letter, dof));
            let known = known.into_iter().map(str::to_owned).chain(entries).collect();
            let what = "parameter or initial value";
            return self.refuse(&path, SceneProblem::Unknown { what, name: name.into(), known });
        };
        let spacing = match varied {
            Varied::List(_) => None,
            Varied::Table(table) => Some(table.scale.unwrap_or(Spacing::Linear)),
        };
        let values = self.values(&path, varied)?;
        Ok(Axis { name: name.into(), target, values, spacing })
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
                Ok(uniform) if low < high && (high - low).is_finite() => {
                    Ok(Values::Uniform(uniform))
                }
                _ => refuse("uniform", low, "below the other bound, at a finite distance"),
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
    pub(super) fn samples(&self, table: &SweepTable, axes: &[Axis]) -> Result<u64, SceneError> {
        let random = axes.iter().any(|axis| !matches!(axis.values, Values::Listed(_)));
        if let Some(count) = table.samples {
            self.at_least_one("sweep", "samples", count)?;
        }
        for (key, given) in [("samples", table.samples), ("seed", table.seed)] {
            if given.is_some() && !random {
                let why = "nothing is random";
                let misplaced = SceneProblem::Misplaced { key, why };
                return self.refuse(&format!("sweep.{key}"), misplaced);
            }
        }
        match table.samples {
            None if random => self.refuse("sweep", SceneProblem::Missing { key: "samples".into() }),
            samples => Ok(samples.unwrap_or(1)),
        }
    }
}
