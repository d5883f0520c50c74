//! The table of an event, as it is written.

use super::Expression;
use afterbay_analysis::study::section::Direction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An event: where `of` crosses `value`, or where `when` is zero.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventTable {
    /// A quantity: t, q1, .., p1, .., w1, .., H, W or K, and s1, .., S where there is a drive,
    /// st where V or D depends on t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// The value that the quantity crosses [default: 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// A function of q1, .., p1, .., t and the parameters, instead of `of`: "q1 - 0.5*q2".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub when: Option<Expression>,
    /// The direction in which zero is crossed [default: both].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
    /// The action taken.
    #[serde(default)]
    pub action: ActionName,
    /// The factor of the velocity after a bounce, from 0 to 1 [default: 1]. The energy lost goes to
    /// the reservoir.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
}

/// The action taken at an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ActionName {
    /// It is recorded in events.csv.
    #[default]
    Record,
    /// It is recorded, and the run ends.
    Stop,
    /// It is recorded, and the velocity of the coordinate that `of` names is reversed by a change
    /// of its momentum, as at a wall.
    Bounce,
}
