//! The first line of a journal.

use crate::scene::Task;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// The version of the format.
const SCHEMA: u32 = 3;
/// The version of afterbay and the hash of its sources (`build.rs`).
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("AFTERBAY_SOURCES"));

/// The most bytes of a header that are read. A choice: one has about 300.
const MOST_BYTES: u64 = 1 << 16;

/// The first line of a journal. Results are joined if their headers agree; the features of the
/// processors may differ.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The version of the format.
    pub journal: u32,
    /// The version of afterbay, and a hash of its sources and dependencies: between releases the
    /// version alone does not change.
    pub version: String,
    /// The command.
    pub task: Task,
    /// SHA-256 of the scene.
    pub scene: String,
    /// The architecture and the operating system.
    pub target: String,
    /// The features of the processor that the program is built for. The last digits of results may
    /// depend on them.
    pub features: String,
}

impl Header {
    /// The header of a task on a scene.
    pub fn new(task: Task, hash: &str) -> Self {
        let features = [
            ("avx2", cfg!(target_feature = "avx2")),
            ("fma", cfg!(target_feature = "fma")),
            ("avx512f", cfg!(target_feature = "avx512f")),
            ("neon", cfg!(target_feature = "neon")),
        ];
        let has = features.iter().filter(|feature| feature.1).map(|feature| feature.0);
        Self {
            journal: SCHEMA,
            version: VERSION.into(),
            task,
            scene: hash.into(),
            target: format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
            features: has.collect::<Vec<_>>().join(" "),
        }
    }

    /// The header of a journal; none if its first line is none of this format.
    pub(super) fn read(path: &Path) -> Option<Self> {
        let mut line = String::new();
        BufReader::new(File::open(path).ok()?).take(MOST_BYTES).read_line(&mut line).ok()?;
        serde_json::from_str(&line).ok()
    }

    /// The name of the first entry that differs from another header, and both values.
    pub(super) fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let pairs = [
            ("format of journals", self.journal.to_string(), other.journal.to_string()),
            ("version of afterbay", self.version.clone(), other.version.clone()),
            ("command", self.task.name().into(), other.task.name().into()),
            ("scene", self.scene.clone(), other.scene.clone()),
            ("machine", self.target.clone(), other.target.clone()),
            ("features of the processor", self.features.clone(), other.features.clone()),
        ];
        pairs.into_iter().find(|(_, ours, theirs)| ours != theirs)
    }
}
