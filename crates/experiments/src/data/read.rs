//! Reading tables back, in any format, as text.

use super::{Column, DataError, DataFormat, Kind, Sidecar};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// The header and the rows of a table. Cells are as in CSV: missing values are empty.
pub(crate) type Cells = (Vec<String>, Vec<Vec<String>>);

/// Reads a table. An array and JSON Lines need their sidecar.
///
/// # Errors
/// [`DataError`] if it is not what its extension says.
pub(crate) fn read(path: &Path, format: DataFormat) -> Result<Cells, DataError> {
    match format {
        DataFormat::Csv => text(path),
        DataFormat::Npy => array(path, &Sidecar::read(&path.with_extension("json"))?),
        DataFormat::Jsonl => lines(path, &Sidecar::read(&path.with_extension("json"))?),
    }
}

fn header(sidecar: &Sidecar) -> Vec<String> {
    sidecar.columns.iter().map(|column| column.name.clone()).collect()
}

fn text(path: &Path) -> Result<Cells, DataError> {
    let mut reader = csv::Reader::from_path(path)?;
    let texts = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect();
    let header = texts(reader.headers()?);
    let rows = reader.records().map(|record| record.map(|record| texts(&record)));
    Ok((header, rows.collect::<Result<_, _>>()?))
}

fn array(path: &Path, sidecar: &Sidecar) -> Result<Cells, DataError> {
    let numbers: Vec<f64> = npyz::NpyFile::new(BufReader::new(File::open(path)?))?.into_vec()?;
    let (rows, columns) = (sidecar.rows, sidecar.columns.len());
    if numbers.len() != rows * columns {
        return Err(DataError::Shape { found: numbers.len(), rows, columns });
    }
    let row = |row: &[f64]| row.iter().zip(&sidecar.columns).map(cell).collect();
    // A table without columns has no rows.
    Ok((header(sidecar), numbers.chunks(columns.max(1)).map(row).collect()))
}

/// A number of an array as the text it stands for.
fn cell((&number, column): (&f64, &Column)) -> String {
    match column.kind {
        _ if number.is_nan() => String::new(),
        Kind::Integer => number.to_string(),
        Kind::Float => format!("{number:?}"),
        Kind::Bool => (number != 0.0).to_string(),
        Kind::Word => column.words.get(number as usize).cloned().unwrap_or_default(),
    }
}

fn lines(path: &Path, sidecar: &Sidecar) -> Result<Cells, DataError> {
    let mut rows = Vec::with_capacity(sidecar.rows);
    for line in BufReader::new(File::open(path)?).lines() {
        let row: serde_json::Map<String, Value> = serde_json::from_str(&line?)?;
        let cell = |column: &Column| match row.get(&column.name) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(word)) => word.clone(),
            Some(other) => other.to_string(),
        };
        rows.push(sidecar.columns.iter().map(cell).collect());
    }
    Ok((header(sidecar), rows))
}
