//! The variables of a state.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A variable that each degree of freedom has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variable {
    /// The coordinates.
    Q,
    /// The momenta.
    P,
    /// The reservoirs.
    W,
    /// The energies supplied by a drive.
    S,
}

impl Variable {
    /// The letter: q, p, w or s.
    pub fn letter(self) -> &'static str {
        match self {
            Self::Q => "q",
            Self::P => "p",
            Self::W => "w",
            Self::S => "s",
        }
    }
}
