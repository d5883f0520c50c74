//! Tables as files: CSV, NumPy arrays or JSON Lines, each with a sidecar that names the columns,
//! their types and units, and the origin of the table.
//!
//! A table is made as CSV, in which every number reads back to the bit. The other formats are
//! translations of it.

mod column;
mod format;
mod read;
mod write;

pub use afterbay_analysis::columns::Kind;
pub use column::Column;
pub use format::{DataFormat, Files};
pub(crate) use read::read;
pub(crate) use write::write;

use crate::manifest::Manifest;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The description of a table in `data/NAME.csv`, written beside it as `data/NAME.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sidecar {
    /// The format of the table.
    pub format: DataFormat,
    /// The number of rows.
    pub rows: usize,
    /// The columns in their order.
    pub columns: Vec<Column>,
    /// The origin of the table.
    pub provenance: Provenance,
}

impl Sidecar {
    /// Reads the sidecar in a file.
    ///
    /// # Errors
    /// [`DataError::Sidecar`] if there is none.
    pub(crate) fn read(path: &Path) -> Result<Self, DataError> {
        let failed = |why: String| DataError::Sidecar { path: path.to_owned(), why };
        let text = std::fs::read_to_string(path).map_err(|why| failed(why.to_string()))?;
        serde_json::from_str(&text).map_err(|why| failed(why.to_string()))
    }

    /// Whether afterbay wrote the table.
    pub(crate) fn is_ours(&self) -> bool {
        self.provenance.program.starts_with("afterbay ")
    }
}

/// The origin of a table, as in `run.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Provenance {
    /// `afterbay` and its version.
    pub program: String,
    /// The command.
    pub command: String,
    /// SHA-256 of the scene.
    pub scene: String,
}

impl Provenance {
    fn of(manifest: &Manifest) -> Self {
        Self {
            program: format!("afterbay {}", manifest.version),
            command: manifest.command.into(),
            scene: manifest.hash.clone(),
        }
    }
}

/// A table that cannot be written or read.
#[derive(Debug, Error)]
pub enum DataError {
    /// It is not CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// It is not JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// The file cannot be read, or is no NumPy array.
    #[error(transparent)]
    File(#[from] io::Error),
    /// It cannot be read without its sidecar.
    #[error("its columns are not known: {}: {why}", path.display())]
    Sidecar {
        /// The file of the sidecar.
        path: PathBuf,
        /// The reason for which it cannot be read.
        why: String,
    },
    /// The array and its sidecar do not agree.
    #[error("the array has {found} numbers where its sidecar has {rows} rows of {columns} columns")]
    Shape {
        /// The numbers of the array.
        found: usize,
        /// The rows of the sidecar.
        rows: usize,
        /// The columns of the sidecar.
        columns: usize,
    },
}
