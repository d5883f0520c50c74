//! The tables of the studies of tangent vectors, as they are written.

use super::Spread;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lyapunov exponents.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LyapunovTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps [default: that of [time]]. The period of a drive is divided into whole steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// The time before the exponents are measured [default: the end of time].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transient: Option<f64>,
    /// The time over which they are measured [default: the end of time].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// The number of times at which the exponents so far are kept [default: 50].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<u64>,
    /// Whether a reference with small steps is shown, too [default: true].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<bool>,
}

/// A limit cycle, or a branch of them in a parameter.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitCycleTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps [default: that of [time]]. The period of the cycle is divided into whole steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// The time of the run that leads to the cycle [default: the end of time].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transient: Option<f64>,
    /// The number of periods in t of the system in the cycle [default: found].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periods: Option<u64>,
    /// The parameter in which the cycle is followed, of the system or of the drive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter: Option<BranchTable>,
    /// Whether a reference with small steps is shown, too [default: true].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<bool>,
}

/// A parameter in which cycles are followed, past the values at which they turn back.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BranchTable {
    /// Its name.
    pub name: String,
    /// The value at which the branch begins.
    pub from: f64,
    /// The value at which it ends.
    pub to: f64,
    /// The number of period doublings to be found. The branch goes over to the cycles of twice the
    /// period at each, and ends at the last [default: 0, no doubled cycles].
    #[serde(default)]
    pub doublings: usize,
}
