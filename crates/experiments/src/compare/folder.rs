//! The folder of a result: its origin as `run.json` records it, and its tables.

use super::CompareError;
use super::table::Table;
use crate::data::{DataFormat, Sidecar};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The commands whose results can be compared.
const COMMANDS: [&str; 4] = ["run", "study", "paper", "pick"];

/// A result as it was written.
pub(super) struct Folder {
    pub(super) path: PathBuf,
    pub(super) origin: Origin,
    /// The tables by their names below `data`, without extensions.
    pub(super) tables: BTreeMap<String, Table>,
    /// The names of the tables that come from another scene, by their sidecars. They are left out.
    pub(super) of_another: Vec<String>,
}

/// The origin of a result, from `run.json`.
#[derive(Deserialize)]
pub(super) struct Origin {
    pub(super) version: String,
    pub(super) command: String,
    pub(super) scene: Value,
    pub(super) hash: String,
    pub(super) cpu: String,
    pub(super) threads: usize,
    runs: Vec<Ended>,
}

/// A run, and how it ended.
#[derive(Deserialize)]
struct Ended {
    method: String,
    outcome: String,
}

impl Origin {
    /// The methods of the runs, each once.
    pub(super) fn methods(&self) -> Vec<&str> {
        let mut found = Vec::new();
        for run in &self.runs {
            if !found.contains(&run.method.as_str()) {
                found.push(&run.method);
            }
        }
        found
    }

    /// The number of runs with each outcome: `12 completed, 1 pole`.
    pub(super) fn outcomes(&self) -> String {
        let mut counts = BTreeMap::<&str, usize>::new();
        self.runs.iter().for_each(|run| *counts.entry(&run.outcome).or_default() += 1);
        let each = counts.iter().map(|(outcome, count)| format!("{count} {outcome}"));
        each.collect::<Vec<_>>().join(", ")
    }
}

impl Folder {
    /// Reads a result.
    pub(super) fn read(path: &Path) -> Result<Self, CompareError> {
        let folder = || path.to_owned();
        if !path.is_dir() {
            return Err(CompareError::NoFolder { folder: folder() });
        }
        let text = std::fs::read_to_string(path.join("run.json"))
            .map_err(|source| CompareError::NoResult { folder: folder(), source })?;
        let origin: Origin = serde_json::from_str(&text)
            .map_err(|source| CompareError::Manifest { folder: folder(), source })?;
        if !COMMANDS.contains(&origin.command.as_str()) {
            let command = origin.command;
            return Err(CompareError::Command { folder: folder(), command });
        }
        let (tables, of_another) = (BTreeMap::new(), Vec::new());
        let mut found = Self { path: folder(), origin, tables, of_another };
        found.read_tables(&path.join("data"), "")?;
        found.of_another.sort();
        Ok(found)
    }

    /// Reads the tables of a folder and of those below it.
    fn read_tables(&mut self, folder: &Path, prefix: &str) -> Result<(), CompareError> {
        let failed = |source| CompareError::Data { folder: folder.to_owned(), source };
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            // Links to folders are not followed: they may lead back.
            if entry.file_type().map_err(failed)?.is_dir() {
                self.read_tables(&path, &format!("{prefix}{name}/"))?;
                continue;
            }
            for format in DataFormat::ALL {
                let Some(name) = name.strip_suffix(&format!(".{}", format.extension())) else {
                    continue;
                };
                self.read_table(&path, format, format!("{prefix}{name}"))?;
            }
        }
        Ok(())
    }

    fn read_table(
        &mut self,
        path: &Path,
        format: DataFormat,
        name: String,
    ) -> Result<(), CompareError> {
        let sidecar = Sidecar::read(&path.with_extension("json")).ok();
        if sidecar.is_some_and(|found| found.provenance.scene != self.origin.hash) {
            self.of_another.push(name);
            return Ok(());
        }
        let table = Table::read(path, format)
            .map_err(|source| CompareError::Table { file: path.to_owned(), source })?;
        self.tables.insert(name, table);
        Ok(())
    }

    /// The names of its tables.
    pub(super) fn names(&self) -> String {
        let names: Vec<_> = self.tables.keys().map(String::as_str).collect();
        let names = if names.is_empty() { "none".into() } else { names.join(", ") };
        match &self.of_another[..] {
            [] => names,
            others => format!("{names} (of another scene: {})", others.join(", ")),
        }
    }
}
