//! Tables written in a format, row by row: what is in memory does not depend on their length.

use super::column::Words;
use super::{Column, DataError, DataFormat, Provenance, Sidecar};
use crate::UnitsTable;
use crate::artifact::Artifact;
use crate::manifest::Manifest;
use afterbay_analysis::columns::{self, TableColumns};
use csv::StringRecord;
use npyz::WriterBuilder;
use serde::Serializer as _;
use std::io::{self, Read, Write};

/// Writes a table, which is read twice: once for the types of its columns, which follow from all
/// cells, and for its length. Returns the sidecar.
///
/// # Errors
/// [`DataError`] if it cannot be read or written.
pub(crate) fn write(
    table: &Artifact,
    format: DataFormat,
    manifest: &Manifest,
    to: &mut impl Write,
) -> Result<Sidecar, DataError> {
    let units = serde_json::from_value::<UnitsTable>(manifest.scene["units"].clone());
    let units = units.unwrap_or_default();
    let TableColumns { columns, rows } = columns::of_table(&mut table.open()?)?;
    let mut columns: Vec<Column> =
        columns.into_iter().map(|cells| Column::of(cells, &units)).collect();
    match format {
        DataFormat::Csv => {
            io::copy(&mut table.open()?, to)?;
        }
        DataFormat::Npy => array(records(table.open()?), (&mut columns, rows), to)?,
        DataFormat::Jsonl => lines(records(table.open()?), &columns, to)?,
    }
    let provenance = Provenance::of(manifest);
    Ok(Sidecar { format, rows, columns, provenance })
}

/// The rows of a table in CSV, behind its header. Rows may differ in length.
fn records<R: Read>(text: R) -> csv::Reader<R> {
    csv::ReaderBuilder::new().flexible(true).from_reader(text)
}

fn array(
    mut records: csv::Reader<impl Read>,
    (columns, rows): (&mut [Column], usize),
    to: &mut impl Write,
) -> Result<(), DataError> {
    let shape = [rows, columns.len()].map(|length| length as u64);
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    let mut array = options.writer(to).begin_nd()?;
    let mut words: Vec<Words> = columns.iter().map(|_| Words::default()).collect();
    let mut record = StringRecord::new();
    while records.read_record(&mut record)? {
        for ((at, column), words) in columns.iter().enumerate().zip(&mut words) {
            array.push(&words.number(column.kind, record.get(at).unwrap_or_default()))?;
        }
    }
    array.finish()?;
    columns.iter_mut().zip(words).for_each(|(column, words)| column.words = words.all);
    Ok(())
}

fn lines(
    mut records: csv::Reader<impl Read>,
    columns: &[Column],
    to: &mut impl Write,
) -> Result<(), DataError> {
    let mut record = StringRecord::new();
    while records.read_record(&mut record)? {
        let entries = columns
            .iter()
            .enumerate()
            .map(|(at, column)| (&column.name, column.value(record.get(at).unwrap_or_default())));
        serde_json::Serializer::new(&mut *to).collect_map(entries)?;
        to.write_all(b"\n")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::read::{Cells, read};
    use super::super::{Column, Kind};
    use super::*;
    use proptest::prelude::*;

    fn manifest() -> Manifest {
        Manifest::new("run", serde_json::json!({ "units": { "q": "m", "time": "s" } }), Vec::new())
    }

    fn translated(text: &str, format: DataFormat) -> (Vec<u8>, Sidecar) {
        let table = Artifact { name: "x.csv".into(), text: text.into(), ..Artifact::default() };
        let mut bytes = Vec::new();
        let sidecar = write(&table, format, &manifest(), &mut bytes).expect("a table");
        (bytes, sidecar)
    }

    /// The cells of a table that was written in a format.
    fn there_and_back(text: &str, format: DataFormat) -> (Vec<Column>, Cells) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(format!("x.{}", format.extension()));
        let (table, sidecar) = translated(text, format);
        std::fs::write(&path, table).expect("a file");
        let json = serde_json::to_vec(&sidecar).expect("JSON");
        std::fs::write(path.with_extension("json"), json).expect("a file");
        (sidecar.columns, read(&path, format).expect("it reads back"))
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
        let (table, _) = translated("a\n1.5\n", DataFormat::Npy);
        std::fs::write(&path, table).expect("a file");
        assert!(matches!(read(&path, DataFormat::Npy), Err(DataError::Sidecar { .. })));
    }
}
