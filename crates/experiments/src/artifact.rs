//! Files of results before they are written: tables and figures.

use crate::chart::Drawing;
use afterbay_analysis::rows::RowsFile;
use serde::Serialize;
use std::io::{self, Read};
use thiserror::Error;

/// A file of the output, named relative to its folder.
#[derive(Clone, Debug, Default)]
pub struct Artifact {
    /// `data/local_orders.csv`, `figures/figure-3-1.svg`, ...
    pub name: String,
    /// The contents; of a long table, their beginning.
    pub text: String,
    /// The other rows of a long table.
    pub rows: Vec<RowsFile>,
    /// The chart of an SVG file, from which the PNG file beside it is drawn.
    pub picture: Option<Drawing>,
}

impl Artifact {
    /// A table. Floats are printed as the shortest text that reads back the same; missing values
    /// are empty.
    ///
    /// # Errors
    /// [`TableError`] if a row cannot be serialized as CSV.
    pub fn table<R: Serialize>(name: impl Into<String>, rows: &[R]) -> Result<Self, TableError> {
        Self::written(name, rows, csv::Writer::from_writer(Vec::new()))
    }

    /// A table whose number of columns depends on the number of degrees of freedom. Rows contain
    /// vectors, and the header names each entry.
    ///
    /// # Errors
    /// [`TableError`] if a row cannot be serialized as CSV or differs from the header in
    /// length.
    pub fn wide_table<R: Serialize>(
        name: impl Into<String>,
        header: &[String],
        rows: &[R],
    ) -> Result<Self, TableError> {
        let name = name.into();
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        match writer.write_record(header) {
            Ok(()) => Self::written(name, rows, writer),
            Err(source) => Err(TableError { name, source }),
        }
    }

    fn written<R: Serialize>(
        name: impl Into<String>,
        rows: &[R],
        mut writer: csv::Writer<Vec<u8>>,
    ) -> Result<Self, TableError> {
        let name = name.into();
        let write = || -> Result<String, csv::Error> {
            rows.iter().try_for_each(|row| writer.serialize(row))?;
            let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
            Ok(String::from_utf8_lossy(&bytes).into_owned())
        };
        match write() {
            Ok(text) => Ok(Self { name, text, ..Self::default() }),
            Err(source) => Err(TableError { name, source }),
        }
    }

    /// Reads the contents, whether or not they are in memory.
    ///
    /// # Errors
    /// A file of rows that cannot be opened.
    pub fn open(&self) -> io::Result<impl Read + '_> {
        let mut rows: Box<dyn Read + '_> = Box::new(io::empty());
        for more in &self.rows {
            rows = Box::new(rows.chain(more.open()?));
        }
        Ok(self.text.as_bytes().chain(rows))
    }
}

/// A row that could not be serialized as CSV.
#[derive(Debug, Error)]
#[error("cannot write the table {name}: {source}")]
pub struct TableError {
    /// The table.
    pub name: String,
    /// The cause.
    pub source: csv::Error,
}
