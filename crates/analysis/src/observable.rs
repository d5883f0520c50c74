//! Quantities of a state that a figure can show.

use crate::Model;
use crate::study::PUMPED;
use crate::study::trajectory::TrajectoryRow;
use crate::{UnitsTable, Variable};

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
    pub(crate) fn parse(name: &str, model: &Model) -> Option<Self> {
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
    pub(crate) fn names(model: &Model) -> Vec<String> {
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

    /// The value in a state of a run that began with `first`.
    pub(crate) fn of(self, row: &TrajectoryRow, first: &TrajectoryRow) -> Option<f64> {
        Some(match self {
            Self::Time => row.t,
            Self::Of(variable, j) => *entries(variable, row).get(j)?,
            Self::Reservoirs => row.w.iter().sum(),
            Self::Supplied => row.s.iter().sum(),
            Self::Pumped => *row.pumped.first()?,
            Self::Energy => row.energy,
            Self::Total => row.total,
            Self::Drift => row.total - first.total,
        })
    }

    /// The symbol.
    pub(crate) fn symbol(self) -> String {
        match self {
            Self::Time => "t".into(),
            Self::Of(variable, j) => format!("{}{}", letter(variable), j + 1),
            Self::Reservoirs => "Σ w".into(),
            Self::Supplied => "Σ s".into(),
            Self::Pumped => "s_t".into(),
            Self::Energy => "H".into(),
            Self::Total => "K".into(),
            Self::Drift => "K − K₀".into(),
        }
    }

    /// The label of an axis that shows `quantity`, which is of this kind.
    pub(crate) fn label(self, quantity: &str, units: &UnitsTable) -> String {
        match self {
            Self::Time => units.time(quantity),
            Self::Of(variable, _) => units.variable(variable, quantity),
            _ => units.energy(quantity),
        }
    }
}

/// The letter of a variable.
pub(crate) fn letter(variable: Variable) -> &'static str {
    match variable {
        Variable::Q => "q",
        Variable::P => "p",
        Variable::W => "w",
        Variable::S => "s",
    }
}

/// The entries of a variable in a state.
pub(crate) fn entries(variable: Variable, row: &TrajectoryRow) -> &[f64] {
    match variable {
        Variable::Q => &row.q,
        Variable::P => &row.p,
        Variable::W => &row.w,
        Variable::S => &row.s,
    }
}
