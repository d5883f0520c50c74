//! The tables and keys of a scene file, as they are written.

mod drive;
mod dynamics;
mod event;
mod figures;
mod sweep;
mod tangents;

pub(super) use drive::DriveTable;
pub(super) use dynamics::{
    BasinsTable, BifurcationTable, PoincareTable, ResonanceTable, SectionTable,
};
pub(super) use event::{ActionName, EventTable};
pub(super) use figures::FigureTable;
pub use figures::{UnitsTable, Variable};
pub(super) use sweep::{SweepTable, Varied};
pub(super) use tangents::{LimitCycleTable, LyapunovTable};

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

/// A built-in system by name, or a custom one.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SystemTable {
    /// One of `afterbay list systems`, or "custom".
    pub name: String,
    /// The values of its parameters: numbers, or expressions in other parameters such as
    /// "sqrt(k/m)". A parameter given as an expression follows those that it mentions.
    #[serde(default)]
    pub parameters: BTreeMap<String, Expression>,
    /// Custom: V(q, t), an expression in q1, q2, .., t and the parameters. H = Σ p_j²/(2 m_j) + V.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub potential: Option<Expression>,
    /// Custom, instead of `potential` and `mass`: H(q, p), an expression in q1, q2, .., p1, p2, ..
    /// and the parameters. Methods for a separable H refuse it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hamiltonian: Option<Expression>,
    /// Custom: the dissipative forces D_j(q, p, v), one for each degree of freedom, or one rule for
    /// all of them, in which i is the number of the degree of freedom: "c*p[i]". The velocities v1,
    /// v2, .. are ∂H/∂p_j.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dissipation: Option<PerDegree>,
    /// Custom, instead of `dissipation`: the rows of R(q, p) in D = R v with v_j = ∂H/∂p_j. Where R
    /// is constant and positive semidefinite the system is passive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Vec<Vec<Expression>>>,
    /// Custom: the masses, one for each degree of freedom, or one rule for all of them. All are 1
    /// if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<PerDegree>,
}

impl SystemTable {
    /// The expressions of a custom system, each with its name.
    pub fn expressions(&self) -> Vec<(String, String)> {
        let mut all = Vec::new();
        let numbered =
            |name: &str, given: Option<&PerDegree>| given.map_or(Vec::new(), |all| all.named(name));
        all.extend(self.potential.iter().map(|text| ("V".into(), text.text())));
        all.extend(self.hamiltonian.iter().map(|text| ("H".into(), text.text())));
        all.extend(numbered("D", self.dissipation.as_ref()));
        for (i, row) in self.friction.iter().flatten().enumerate() {
            let row = row.iter().enumerate();
            all.extend(row.map(|(j, text)| (format!("R{}{}", i + 1, j + 1), text.text())));
        }
        all.extend(numbered("m", self.mass.as_ref()));
        all
    }
}

/// An expression such as "c*p1", or a number.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// An expression.
    Text(String),
}

impl Expression {
    /// The expression as text.
    pub fn text(&self) -> String {
        match self {
            Self::Number(value) => format!("{value:?}"),
            Self::Text(text) => text.clone(),
        }
    }
}

/// Expressions, one for each degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PerDegree {
    /// One after another.
    List(Vec<Expression>),
    /// One rule for all, in which i is the number of the degree of freedom.
    Rule(Expression),
}

impl PerDegree {
    /// The expressions, each with its name: that of all and its number.
    pub(crate) fn named(&self, name: &str) -> Vec<(String, String)> {
        match self {
            Self::Rule(rule) => vec![(format!("{name}_i"), rule.text())],
            Self::List(list) => {
                let list = list.iter().enumerate();
                list.map(|(j, text)| (format!("{name}{}", j + 1), text.text())).collect()
            }
        }
    }
}

/// Numbers, one for each degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Entries {
    /// One after another.
    List(Vec<Expression>),
    /// One rule for a number of entries, or a file.
    Table(EntriesTable),
    /// One rule for all, in which i is the number of the degree of freedom.
    Rule(Expression),
}

impl Entries {
    /// The number of entries, if it is given.
    pub(super) fn count(&self) -> Option<usize> {
        match self {
            Self::List(list) => Some(list.len()),
            Self::Table(table) => table.count.and_then(|count| usize::try_from(count).ok()),
            Self::Rule(_) => None,
        }
    }
}

/// A number of entries by one rule { count, value }, or a column of a file { file, column }.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EntriesTable {
    /// The number of entries.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<u64>,
    /// Entry i, counted from 1: a number or an expression such as "0.1*sin(pi*i/(n + 1))".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Expression>,
    /// A CSV file, relative to the folder of the scene. Lines that begin with # are comments, and
    /// the first line may name the columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The name of the column, or its number counted from 1 [default: the first].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<Column>,
}

/// A column of a file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Column {
    /// Its number, counted from 1.
    Number(u64),
    /// Its name.
    Name(String),
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
    /// which are shown at the same times. If none of them is named, adaptive-collocation runs too.
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
    /// The steps, each of which divides the end of time.
    pub steps: Spread,
    /// Relative and absolute tolerances of q, p and w for the methods that choose their steps. If
    /// none of them is named, all of them run with each tolerance.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tolerances: Vec<f64>,
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
    /// The time span of a run, rounded up to whole steps [default: the end of [time]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
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

/// The spacing of values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    /// By equal differences.
    #[default]
    Linear,
    /// By equal ratios.
    Log,
}
