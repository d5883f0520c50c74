//! The results that a folder holds already.

use serde::Deserialize;
use std::path::Path;

/// The record of the results in a folder, read from its `run.json`.
#[derive(Debug, Deserialize)]
pub struct Held {
    /// The command that wrote them.
    pub command: String,
    /// SHA-256 of its scene.
    pub hash: String,
    /// The figures of all commands on this scene.
    #[serde(default)]
    pub(super) figures: Vec<String>,
}

impl Held {
    /// Reads it; `None` if there are no results of afterbay.
    pub fn read(folder: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(folder.join("run.json")).ok()?;
        serde_json::from_str(&text).ok()
    }
}
