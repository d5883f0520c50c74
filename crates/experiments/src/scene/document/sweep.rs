//! The table of a sweep, as it is written.

use afterbay_analysis::Spacing;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A sweep: every combination of the listed values, each with `samples` draws of the random ones.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepTable {
    /// The quantities that are varied: parameters of the system by name, and entries q1, p2, .. of
    /// the initial state.
    pub vary: BTreeMap<String, Varied>,
    /// The number of draws of the random values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<u64>,
    /// The seed of the random values [default: 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

/// The values of one thing that is varied.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "values are expected here: a list of numbers, { from, to, count }, \
                 { uniform = [low, high] } or { normal = [mean, deviation] }"
)]
pub enum Varied {
    /// A list of values.
    List(Vec<f64>),
    /// A range, or random draws.
    Table(VariedTable),
}

/// A range { from, to, count, scale }, or a distribution { uniform } or { normal }.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariedTable {
    /// The first value of a range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// The last value of a range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// The number of values of a range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<u64>,
    /// The spacing of the values of a range [default: "linear"].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Spacing>,
    /// The bounds of a uniform distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uniform: Option<[f64; 2]>,
    /// The mean and the standard deviation of a normal distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 2]>,
}
