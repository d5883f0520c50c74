//! The tables of figures and units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A figure of the trajectories of [run]: curves, or a map over a chain and time.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FigureTable {
    /// The title [default: the quantities].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The quantity of the horizontal axis: t, q1, p1, w1, .., W (the sum of all w), s1, .. and S
    /// of a drive, st of V(q, t), H, K or "K - K0" [default: t].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<String>,
    /// The quantity of the vertical axis, or a list of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Names>,
    /// In place of y: the variable shown as a colour over the degree of freedom and time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<Variable>,
    /// Names of methods, some of those of [run] [default: all of them].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// Whether the vertical axis is logarithmic and shows absolute values.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub log: bool,
}

/// One name, or several.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Names {
    /// One.
    One(String),
    /// A list.
    List(Vec<String>),
}

impl Names {
    /// The names in their order, each with the end of its path.
    pub(in crate::scene) fn each(&self) -> Vec<(String, &str)> {
        match self {
            Self::One(name) => vec![(String::new(), name)],
            Self::List(list) => {
                list.iter().enumerate().map(|(i, name)| (format!(".{i}"), name.as_str())).collect()
            }
        }
    }
}

/// A variable that each degree of freedom has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variable {
    /// The coordinates.
    Q,
    /// The momenta.
    P,
    /// The reservoirs.
    W,
    /// The energies supplied by a drive.
    S,
}

/// Names of units. They label the axes of charts; nothing is converted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitsTable {
    /// The unit of t and of steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// The unit of the coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub q: Option<String>,
    /// The unit of the momenta.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p: Option<String>,
    /// The unit of H, w and K.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
}

impl UnitsTable {
    /// The label of a quantity of time, for instance `time t [s]`.
    pub(crate) fn time(&self, quantity: &str) -> String {
        with(quantity, self.time.as_deref())
    }

    /// The unit of a column of a table, told by its name: t and h are times, q1 is a coordinate,
    /// w1 and H are energies.
    pub(crate) fn of_column(&self, name: &str) -> Option<&str> {
        let unit = match name.trim_end_matches(|c: char| c.is_ascii_digit()) {
            "t" | "h" => &self.time,
            "q" => &self.q,
            "p" => &self.p,
            "w" | "s" | "st" | "H" | "K" => &self.energy,
            _ => &None,
        };
        unit.as_deref()
    }

    /// The label of an energy.
    pub(crate) fn energy(&self, quantity: &str) -> String {
        with(quantity, self.energy.as_deref())
    }

    /// The label of a variable.
    pub(crate) fn variable(&self, variable: Variable, quantity: &str) -> String {
        let unit = match variable {
            Variable::Q => &self.q,
            Variable::P => &self.p,
            Variable::W | Variable::S => &self.energy,
        };
        with(quantity, unit.as_deref())
    }
}

/// A label: a quantity and its unit, if there is one.
fn with(quantity: &str, unit: Option<&str>) -> String {
    unit.map_or_else(|| quantity.to_owned(), |unit| format!("{quantity} [{unit}]"))
}
