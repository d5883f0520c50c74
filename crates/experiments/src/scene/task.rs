//! The two tasks of a scene: its trajectories and its studies.

use serde::{Deserialize, Serialize};

/// The task that a command carries out on a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Task {
    /// The trajectories of `[run]`.
    Run,
    /// The studies.
    Study,
}

impl Task {
    /// The name of its command.
    pub fn name(self) -> &'static str {
        match self {
            Self::Run => "run",
            Self::Study => "study",
        }
    }
}
