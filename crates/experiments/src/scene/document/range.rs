//! The values of a step or a parameter.

use afterbay_analysis::Spacing;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Values: a list, or a range.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Spread {
    /// A list of values.
    List(Vec<f64>),
    /// A range of values.
    Range(RangeTable),
}

/// A range of values.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RangeTable {
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// The number of values.
    pub count: u64,
    /// The spacing of the values.
    #[serde(default)]
    pub scale: Spacing,
}

/// A parameter of the system and its values.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterTable {
    /// Its name.
    pub name: String,
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// The number of values.
    pub count: u64,
    /// The spacing of the values.
    #[serde(default)]
    pub scale: Spacing,
}
