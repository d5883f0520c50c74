//! The tables of studies of errors, energy and stability, and the list of all studies.

use super::{
    BasinsTable, BifurcationTable, LimitCycleTable, LyapunovTable, ParameterTable, PoincareTable,
    ResonanceTable, Spread,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The tables of `afterbay study`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct StudyTables {
    /// The errors of single steps along the exact solution, and their orders.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local_order: Option<LocalOrderTable>,
    /// The errors of whole runs, and their orders.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_order: Option<GlobalOrderTable>,
    /// H, K - K0 and w along the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyTable>,
    /// Errors against time and evaluations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work_precision: Option<WorkPrecisionTable>,
    /// Verdicts on runs as the step grows, for values of a parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stability: Option<StabilityTable>,
    /// The growth of |K - K0| over very many steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub long_run: Option<LongRunTable>,
    /// The states of runs on a section.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poincare: Option<PoincareTable>,
    /// The states on a section against a parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bifurcation: Option<BifurcationTable>,
    /// Amplitude and energy per period against the frequency of the drive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resonance: Option<ResonanceTable>,
    /// The attractors that a grid of initial states reaches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub basins: Option<BasinsTable>,
    /// Lyapunov exponents.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lyapunov: Option<LyapunovTable>,
    /// A limit cycle, or a branch of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_cycle: Option<LimitCycleTable>,
}

/// Local errors on a base grid.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LocalOrderTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The distance of the points from which steps are taken.
    pub base_step: f64,
    /// The steps, multiples of the base step.
    pub steps: Spread,
}

/// Errors of whole runs.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GlobalOrderTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps, each of which divides the end of time.
    pub steps: Spread,
}

/// The energy balance.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnergyTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The step [default: that of [time]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// The number of steps between two rows that are kept. By default at most 10,000 rows are kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<u64>,
}

/// Work against precision.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorkPrecisionTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps, each of which divides the end of time. Methods that choose their steps need none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<Spread>,
    /// Relative and absolute tolerances of q, p and w for the methods that choose their steps. If
    /// none of them is named, all of them run with each tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerances: Option<Vec<f64>>,
}

/// A map over steps and a parameter.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StabilityTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The steps.
    pub steps: Spread,
    /// The parameter that is varied.
    pub parameter: ParameterTable,
    /// The time span of a run, rounded up to whole steps, at least 50 of them [default: the end of
    /// [time]]. Runs with long steps end later.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
}

/// Very many steps.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LongRunTable {
    /// Names of methods [default: those of [run]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub methods: Option<Vec<String>>,
    /// The step [default: that of [time]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// The number of steps.
    pub count: u64,
    /// Whether methods also run with compensated roundings, where they can.
    #[serde(default)]
    pub compensated: bool,
}
