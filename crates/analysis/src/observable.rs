//! Quantities of a state that a figure can show.

use crate::Model;
use crate::Variable;
use crate::study::PUMPED;
use crate::study::trajectory::TrajectoryRow;

/// A quantity of a state, named like the columns of `trajectory.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observable {
    /// t
    Time,
    /// q, p or w of one degree of freedom, counted from 0.
    Of(Variable, usize),
    /// Σ w
    Reservoirs,
    /// Σ s
    Supplied,
    /// s_t, the energy pumped by V(q, t)
    Pumped,
    /// H
    Energy,
    /// K
    Total,
    /// K - K₀
    Drift,
}

impl Observable {
    /// The quantity of a name, if there is one in this model.
    pub fn parse(name: &str, model: &Model) -> Option<Self> {
        let (dof, is_driven) = (model.degrees(), !model.driven().is_empty());
        let numbered = || {
            let variable = match name.get(..1)? {
                "q" => Variable::Q,
                "p" => Variable::P,
                "w" => Variable::W,
                "s" if is_driven => Variable::S,
                _ => return None,
            };
            let number = name.get(1..)?;
            let j: usize = number.parse().ok()?;
            // Not q01 or q+1.
            ((1..=dof).contains(&j) && j.to_string() == number).then(|| Self::Of(variable, j - 1))
        };
        match name {
            "t" => Some(Self::Time),
            "W" => Some(Self::Reservoirs),
            "S" if is_driven => Some(Self::Supplied),
            PUMPED if model.has_clock() => Some(Self::Pumped),
            "H" => Some(Self::Energy),
            "K" => Some(Self::Total),
            "K - K0" => Some(Self::Drift),
            _ => numbered(),
        }
    }

    /// The names there are, those of many degrees of freedom as ranges.
    pub fn names(model: &Model) -> Vec<String> {
        let dof = model.degrees();
        let range = |name: &str| {
            if dof == 1 { format!("{name}1") } else { format!("{name}1 to {name}{dof}") }
        };
        let variables = model.variables().iter().map(|name| range(name));
        let supplied = (!model.driven().is_empty()).then_some("S");
        let pumped = model.has_clock().then_some(PUMPED);
        let others = ["W"].into_iter().chain(supplied).chain(pumped).chain(["H", "K", "K - K0"]);
        let others = others.map(str::to_owned);
        std::iter::once("t".to_owned()).chain(variables).chain(others).collect()
    }

    /// The value in a state of a run that began with `first`; none for a degree of freedom that the
    /// run does not have, or a pumped energy that it does not count.
    pub fn of(self, row: &TrajectoryRow, first: &TrajectoryRow) -> Option<f64> {
        Some(match self {
            Self::Time => row.t,
            Self::Of(variable, j) => *row.entries(variable).get(j)?,
            Self::Reservoirs => row.w.iter().sum(),
            Self::Supplied => row.s.iter().sum(),
            Self::Pumped => *row.pumped.first()?,
            Self::Energy => row.energy,
            Self::Total => row.total,
            Self::Drift => row.total - first.total,
        })
    }

    /// The symbol in labels of charts, such as `q1` or `H`.
    pub fn symbol(self) -> String {
        match self {
            Self::Time => "t".into(),
            Self::Of(variable, j) => format!("{}{}", variable.letter(), j + 1),
            Self::Reservoirs => "Σ w".into(),
            Self::Supplied => "Σ s".into(),
            Self::Pumped => "s_t".into(),
            Self::Energy => "H".into(),
            Self::Total => "K".into(),
            Self::Drift => "K − K₀".into(),
        }
    }
}
