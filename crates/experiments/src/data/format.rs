//! The formats in which results are written.

use serde::{Deserialize, Serialize};

/// The format of the tables in `data/`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DataFormat {
    /// Comma-separated values. Missing values are empty.
    #[default]
    Csv,
    /// A two-dimensional NumPy array of f64, a row of the table in each of its rows. Words are
    /// numbers that count the `words` of the column in the sidecar from 0; missing values are NaN.
    Npy,
    /// A JSON object a line, under the names of the columns. Missing values are null, and numbers
    /// that are not finite are strings such as `inf`.
    Jsonl,
}

impl DataFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Npy, Self::Jsonl];

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Npy => "npy",
            Self::Jsonl => "jsonl",
        }
    }
}

/// The kinds of files that are written.
#[derive(Clone, Copy, Debug)]
pub struct Files {
    /// The format of tables.
    pub tables: DataFormat,
    /// Whether each chart is written as a PNG file too, beside the SVG.
    pub png: bool,
}

impl Default for Files {
    /// Tables as CSV, and PNG files.
    fn default() -> Self {
        Self { tables: DataFormat::Csv, png: true }
    }
}
