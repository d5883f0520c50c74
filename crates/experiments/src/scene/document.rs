//! The tables and keys of a scene file, as they are written.

mod drive;
mod dynamics;
mod entries;
mod event;
mod figures;
mod range;
mod studies;
mod sweep;
mod system;
mod tangents;

pub(super) use drive::DriveTable;
pub(super) use dynamics::{
    BasinsTable, BifurcationTable, PoincareTable, ResonanceTable, SectionTable,
};
pub(super) use entries::{Column, Entries, EntriesTable};
pub(super) use event::{ActionName, EventTable};
pub(super) use figures::{FigureTable, Names};
pub(super) use range::{ParameterTable, RangeTable, Spread};
pub(super) use studies::StudyTables;
pub(super) use sweep::{SweepTable, Varied};
pub(super) use system::{Expression, PerDegree, SystemTable};
pub(super) use tangents::{LimitCycleTable, LyapunovTable};

use crate::UnitsTable;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A scene: a system, its initial state, the end of time, and what to do with it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Document {
    /// The title of reports [default: the name of the file].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The system to integrate.
    pub system: SystemTable,
    /// The state at t = 0. The reservoir starts empty.
    pub initial: InitialTable,
    /// The end of time and the step.
    pub time: TimeTable,
    /// Forces that depend on time, for any system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveTable>,
    /// Trajectories, for `afterbay run`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<RunTable>,
    /// Studies, for `afterbay study`.
    #[serde(default)]
    pub study: StudyTables,
    /// Values of parameters and of the initial state at which everything is repeated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepTable>,
    /// Figures of `afterbay run`, each under the name of its file. Default figures of other names
    /// are shown too.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub figure: BTreeMap<String, FigureTable>,
    /// Units, for the axes of charts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<UnitsTable>,
}

/// The initial state.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialTable {
    /// The coordinates: a list, one rule for all such as "0.1*i", or { count, value }. Expressions
    /// may mention the parameters, i (the number of the degree of freedom) and n (their count).
    pub q: Entries,
    /// The momenta, likewise.
    pub p: Entries,
}

/// The time span of a run.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeTable {
    /// The end of time, a multiple of the step.
    pub end: f64,
    /// The step h. It may be left out where all methods choose their steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
}

/// The table of `afterbay run`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunTable {
    /// Names of methods, see `afterbay list methods`.
    pub methods: Vec<String>,
    /// The number of steps between two states that are kept. By default at most 10,000 states are
    /// kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<u64>,
    /// A relative and absolute tolerance of q, p and w for the methods that choose their steps,
    /// which are shown at the same times: relative to the largest |q_j|, |p_j| and |w_j|. If none
    /// of them is named, adaptive-collocation runs too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// The spacing in time of the states that are kept, instead of `every`. States between two
    /// steps are computed by shorter steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<f64>,
    /// Events, each under its name: zeros of functions of the state, found to rounding.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub events: BTreeMap<String, EventTable>,
}
