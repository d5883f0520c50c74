//! The table of a drive.

use super::{Expression, PerDegree};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A drive: p_j' = -∂H/∂q_j - D_j + F_j(q, t). The energy it supplies is s_j, with s_j' = F_j
/// ∂H/∂p_j, and K = H + Σ w_j - Σ s_j.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveTable {
    /// The forces F_j(q, t), one for each degree of freedom (0 where there is none), or one rule
    /// for all of them: expressions in the time t, q1, q2, .. and the parameters of the drive and
    /// of the system, such as "f*cos(omega*t)".
    pub force: PerDegree,
    /// The values of parameters of the forces: numbers, or expressions in other parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, Expression>,
    /// A period of the forces in t, a number or an expression in the parameters such as
    /// "2*pi/omega". It is found if t occurs only in sines, cosines and remainders (`mod`)
    /// whose frequencies are multiples of one, the lowest at most 12 times it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<Expression>,
}
