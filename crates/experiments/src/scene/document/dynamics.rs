//! The tables of the studies of driven and self-excited systems, as they are written.

use super::{ParameterTable, RangeTable, Spread};
use afterbay_analysis::study::section::Direction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The crossing of a value by a coordinate or a momentum.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionTable {
    /// The coordinate or momentum, such as "q1" or "p2".
    pub of: String,
    /// The value that it crosses [default: 0].
    #[serde(default)]
    pub value: f64,
    /// The direction of the crossing [default: rising].
    #[serde(default)]
    pub direction: Direction,
}

/// The states of runs on a section, after a transient.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoincareTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps [default: that of [time]]. An interval of the section is divided into whole steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// The section [default: every period of the drive; without one, p1 falling through 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub section: Option<SectionTable>,
    /// The interval of time between two states, instead of `section`: a multiple of the period of
    /// the drive, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// The number of states that are not kept [default: 100].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transient: Option<u64>,
    /// The number of states that are kept of each run [default: 1000].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<u64>,
    /// The number of runs. The first starts from the initial state, the others from states around
    /// it [default: 1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starts: Option<u64>,
    /// The largest distance of the starts from the initial state, in each coordinate and momentum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<f64>,
    /// Whether a reference with small steps is shown, too [default: true].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<bool>,
}

/// The states on a section against a parameter.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BifurcationTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps [default: that of [time]]. An interval of the section is divided into whole steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// The parameter that is varied, of the system or of the drive.
    pub parameter: ParameterTable,
    /// The section [default: every period of the drive; without one, p1 falling through 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub section: Option<SectionTable>,
    /// The interval of time between two states, instead of `section`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// The number of states of each run that are not kept [default: 200].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transient: Option<u64>,
    /// The number of states that are kept [default: 100].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<u64>,
    /// Whether each run begins where that of the value before ended, once upwards and once
    /// downwards [default: false, each from the initial state].
    #[serde(default)]
    pub follow: bool,
    /// Whether a reference with small steps is shown, too [default: true].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<bool>,
}

/// Amplitude and energy per period against the frequency of the drive.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResonanceTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps [default: that of [time]]. The period is divided into whole steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// The parameter that changes the period of the drive.
    pub parameter: ParameterTable,
    /// The number of periods at each value before those that are measured [default: 200].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transient: Option<u64>,
    /// The number of periods that are measured [default: 4].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periods: Option<u64>,
    /// Whether a reference with small steps is shown, too [default: true].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<bool>,
}

/// The attractors that a grid of initial states reaches.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BasinsTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps [default: that of [time]]. The interval is divided into whole steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// The two entries of the initial state that are varied, and their values:
    /// { q1 = { from = -2, to = 2, count = 100 }, p1 = { from = -2, to = 2, count = 100 } }.
    pub grid: BTreeMap<String, RangeTable>,
    /// The interval of time between two states that are compared [default: the period of the drive;
    /// without one, 1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// The intervals within which a run is compared with the attractors known so far [default:
    /// 1000]. Runs that reach none are followed for 4000 more or longer, to find new ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest: Option<u64>,
    /// Whether a reference with small steps is shown, too [default: true].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<bool>,
}
