//! Tables as files: CSV, NumPy arrays or JSON Lines, each with a sidecar that names the columns,
//! their types and units, and the origin of the table.
//!
//! A table is made as CSV, in which every number reads back to the bit. The other formats are
//! translations of it.

mod column;
mod read;

pub use column::{Column, Kind};
pub(crate) use read::read;

use crate::record::Manifest;
use crate::scene::UnitsTable;
use column::Words;
use npyz::WriterBuilder;
use serde::{Deserialize, Serialize, Serializer as _};
use std::io;
use std::path::PathBuf;
use thiserror::Error;

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

/// What a table in `data/NAME.csv` consists of, written beside it as `data/NAME.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sidecar {
    /// The format of the table.
    pub format: DataFormat,
    /// The number of rows.
    pub rows: usize,
    /// The columns in their order.
    pub columns: Vec<Column>,
    /// Where the table comes from.
    pub provenance: Provenance,
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
        /// Why it cannot be read.
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

/// A table in a format, with its sidecar.
pub(crate) struct Written {
    pub(crate) table: Vec<u8>,
    pub(crate) sidecar: Sidecar,
}

/// Translates a table from CSV.
pub(crate) fn translate(
    text: &str,
    format: DataFormat,
    manifest: &Manifest,
) -> Result<Written, DataError> {
    let units = serde_json::from_value::<UnitsTable>(manifest.scene["units"].clone());
    let (mut columns, rows) = column::of_table(text, &units.unwrap_or_default())?;
    let table = match format {
        DataFormat::Csv => text.as_bytes().to_vec(),
        DataFormat::Npy => array(text, &mut columns, rows)?,
        DataFormat::Jsonl => lines(text, &columns)?,
    };
    let provenance = Provenance::of(manifest);
    Ok(Written { table, sidecar: Sidecar { format, rows, columns, provenance } })
}

/// The rows of a table in CSV, behind its header. Rows may differ in length.
fn records(text: &str) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes())
}

fn array(text: &str, columns: &mut [Column], rows: usize) -> Result<Vec<u8>, DataError> {
    let mut bytes = Vec::new();
    let shape = [rows, columns.len()].map(|length| length as u64);
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    let mut array = options.writer(&mut bytes).begin_nd()?;
    let mut words: Vec<Words> = columns.iter().map(|_| Words::default()).collect();
    for record in records(text).records() {
        let record = record?;
        for ((at, column), words) in columns.iter().enumerate().zip(&mut words) {
            array.push(&words.number(column.kind, record.get(at).unwrap_or_default()))?;
        }
    }
    array.finish()?;
    columns.iter_mut().zip(words).for_each(|(column, words)| column.words = words.all);
    Ok(bytes)
}

fn lines(text: &str, columns: &[Column]) -> Result<Vec<u8>, DataError> {
    let mut bytes = Vec::new();
    for record in records(text).records() {
        let record = record?;
        let entry = |(at, column): (usize, &Column)| {
            (column.name.clone(), column.kind.value(record.get(at).unwrap_or_default()))
        };
        let mut line = serde_json::Serializer::new(&mut bytes);
        line.collect_map(columns.iter().enumerate().map(entry))?;
        bytes.push(b'\n');
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn manifest() -> Manifest {
        Manifest::new("run", serde_json::json!({ "units": { "q": "m", "time": "s" } }), Vec::new())
    }

    /// The cells of a table that was written in a format.
    fn there_and_back(text: &str, format: DataFormat) -> (Vec<Column>, read::Cells) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(format!("x.{}", format.extension()));
        let written = translate(text, format, &manifest()).expect("a table");
        std::fs::write(&path, written.table).expect("a file");
        let sidecar = serde_json::to_vec(&written.sidecar).expect("JSON");
        std::fs::write(path.with_extension("json"), sidecar).expect("a file");
        (written.sidecar.columns, read(&path, format).expect("it reads back"))
    }

    /// A cell as a number where it is one, so that 1e5 is 100000.0.
    fn value(cell: &str) -> Result<u64, String> {
        cell.parse::<f64>().map(f64::to_bits).map_err(|_| cell.to_owned())
    }

    fn cell() -> impl Strategy<Value = [String; 5]> {
        let float = prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO;
        let whole = any::<i32>();
        let float =
            prop_oneof![9 => float.prop_map(|x| format!("{x:?}")), 1 => Just(String::new())];
        let word = "[a-z]{1,3}( \"|,|\n)?[a-z]";
        (float, whole, word, any::<bool>(), any::<u64>()).prop_map(|(x, n, word, truth, large)| {
            [x, n.to_string(), word, truth.to_string(), large.to_string()]
        })
    }

    proptest! {
        #[test]
        fn every_format_reads_back(rows in prop::collection::vec(cell(), 0..20)) {
            let mut writer = csv::Writer::from_writer(Vec::new());
            writer.write_record(["q1", "n", "word", "truth", "large"]).expect("a header");
            for row in &rows {
                writer.write_record(row).expect("a row");
            }
            let text = String::from_utf8(writer.into_inner().expect("a table")).expect("UTF-8");
            for format in DataFormat::ALL {
                let (_, (header, found)) = there_and_back(&text, format);
                prop_assert_eq!(header, ["q1", "n", "word", "truth", "large"]);
                prop_assert_eq!(found.len(), rows.len());
                for (found, row) in found.iter().flatten().zip(rows.iter().flatten()) {
                    prop_assert_eq!(value(found), value(row), "{:?}: {}, {}", format, found, row);
                }
            }
        }
    }

    #[test]
    fn columns_have_types_and_units() {
        let text =
            "method,step,t,q1,K,kept,value\nrk4,0,0.0,1.5,2.0,true,1\nmoddg,1,0.5,,2.0,false,x\n";
        let (columns, _) = there_and_back(text, DataFormat::Npy);
        let kinds: Vec<_> = columns.iter().map(|column| column.kind).collect();
        use Kind::{Bool, Float, Integer, Word};
        assert_eq!(kinds, [Word, Integer, Float, Float, Float, Bool, Word]);
        assert_eq!(columns[0].words, ["rk4", "moddg"]);
        let units: Vec<_> = columns.iter().map(|column| column.unit.as_deref()).collect();
        assert_eq!(units, [None, None, Some("s"), Some("m"), None, None, None]);
        assert!(columns[3].missing && !columns[2].missing);
    }

    #[test]
    fn rows_may_differ_in_length() {
        for format in [DataFormat::Npy, DataFormat::Jsonl] {
            let (columns, (_, rows)) = there_and_back("a,b\n1,2\n3\n4,5,6.5\n", format);
            assert_eq!(columns[2].name, "column3");
            assert!(columns[1].missing && columns[2].missing);
            assert_eq!(rows, [["1", "2", ""], ["3", "", ""], ["4", "5", "6.5"]]);
        }
    }

    #[test]
    fn an_array_without_its_sidecar_is_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.npy");
        let written = translate("a\n1.5\n", DataFormat::Npy, &manifest()).expect("a table");
        std::fs::write(&path, written.table).expect("a file");
        assert!(matches!(read(&path, DataFormat::Npy), Err(DataError::Sidecar { .. })));
    }
}
