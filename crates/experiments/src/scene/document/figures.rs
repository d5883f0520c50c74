//! The tables of figures.

use afterbay_analysis::Variable;
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
