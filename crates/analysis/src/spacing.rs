//! The spacing of values.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
