//! The origin of results, as it is written to `run.json`.

mod outcome;

pub use outcome::{Alike, RunOutcome};

use serde::Serialize;
use sha2::{Digest, Sha256};

/// The origin of the output: the data that reproduce it, and the machine on which it was made.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// Version of afterbay.
    pub version: &'static str,
    /// The command.
    pub command: &'static str,
    /// The scene that was run, with defaults filled in.
    pub scene: serde_json::Value,
    /// SHA-256 of the scene.
    pub hash: String,
    /// The processor.
    pub cpu: String,
    /// The number of threads.
    pub threads: usize,
    /// The outcome of every run.
    pub runs: Vec<RunOutcome>,
}

impl Manifest {
    /// The manifest of `scene`, run by `command` on this machine.
    pub fn new(command: &'static str, scene: serde_json::Value, runs: Vec<RunOutcome>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            command,
            hash: hash_of(&scene),
            scene,
            cpu: processor(),
            threads: rayon::current_num_threads(),
            runs,
        }
    }
}

/// SHA-256 of a scene.
pub(crate) fn hash_of(scene: &serde_json::Value) -> String {
    let hash = Sha256::digest(scene.to_string().as_bytes());
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The name of the processor where the operating system gives it, else its architecture.
pub fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told
        .lines()
        .find(|line| line.starts_with("model name"))
        .and_then(|line| line.split(": ").nth(1));
    name.unwrap_or(std::env::consts::ARCH).to_owned()
}
