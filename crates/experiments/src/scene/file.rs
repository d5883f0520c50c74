//! Entries of the initial state from files of numbers.

use super::document::{Column, Document, Entries, EntriesTable, Expression};
use super::problem::{SceneError, SceneProblem};
use super::source::Source;
use afterbay_expression::MOST_DEGREES;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The most bytes of a file that are read.
const MOST_BYTES: u64 = 1 << 26;

/// Replaces files by the numbers in them, so that the document says all there is.
pub(super) fn resolve(
    source: &Source<'_>,
    document: &mut Document,
    folder: &Path,
) -> Result<(), SceneError> {
    let initial = &mut document.initial;
    for (path, entries) in [("initial.q", &mut initial.q), ("initial.p", &mut initial.p)] {
        let at =
            |key: &str, problem| SceneError { problem, span: source.span(&format!("{path}{key}")) };
        let Entries::Table(table) = entries else { continue };
        match table {
            EntriesTable { file: Some(file), column, count: None, value: None } => {
                let numbers = read(&folder.join(&*file), column.as_ref())
                    .map_err(|why| at(".file", SceneProblem::File { file: file.clone(), why }))?;
                *entries = Entries::List(numbers.into_iter().map(Expression::Number).collect());
            }
            EntriesTable { file: None, column: None, count: Some(_), value: Some(_) } => {}
            EntriesTable { file: None, column: None, count, .. } => {
                let key = if count.is_none() { "count" } else { "value" };
                return Err(at("", SceneProblem::Missing { key: key.into() }));
            }
            EntriesTable { file: None, .. } => {
                return Err(at("", SceneProblem::Missing { key: "file".into() }));
            }
            EntriesTable { count, .. } => {
                let key = if count.is_some() { "count" } else { "value" };
                let why = "the file has the entries";
                return Err(at(&format!(".{key}"), SceneProblem::Misplaced { key, why }));
            }
        }
    }
    Ok(())
}

/// The numbers of a column.
fn read(path: &Path, column: Option<&Column>) -> Result<Vec<f64>, String> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| error.to_string())?;
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(format!("it has more than {MOST_BYTES} bytes"));
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(&bytes[..]);
    let mut records = reader.records().peekable();
    let named = match records.peek() {
        Some(Ok(first)) if first.iter().any(|cell| cell.parse::<f64>().is_err()) => {
            Some(first.iter().map(str::to_owned).collect::<Vec<_>>())
        }
        _ => None,
    };
    let index = match (column, &named) {
        (None, _) => 0,
        (Some(Column::Number(0)), _) => return Err("columns are counted from 1".into()),
        (Some(&Column::Number(number)), _) => number as usize - 1,
        (Some(Column::Name(name)), Some(names)) => {
            let mut found = (0..names.len()).filter(|&k| names[k] == *name);
            match (found.next(), found.next()) {
                (Some(index), None) => index,
                (Some(_), Some(_)) => return Err(format!("several columns are called {name}")),
                (None, _) => {
                    return Err(format!(
                        "there is no column {name}; there are {}",
                        names.join(", ")
                    ));
                }
            }
        }
        (Some(Column::Name(_)), None) => return Err("its first line names no columns".into()),
    };
    let mut numbers = Vec::new();
    let mut width = named.as_ref().map(Vec::len);
    for record in records.skip(usize::from(named.is_some())) {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let cell =
            record.get(index).ok_or_else(|| format!("line {line} has no column {}", index + 1))?;
        let width = *width.get_or_insert(record.len());
        if record.len() != width {
            let found = record.len();
            return Err(format!("line {line} has {found} columns, those before it have {width}"));
        }
        match cell.parse::<f64>() {
            Ok(number) if number.is_finite() => numbers.push(number),
            _ => return Err(format!("line {line} has {cell:?}, where a number is expected")),
        }
        if numbers.len() > MOST_DEGREES {
            return Err(format!("it has more than {MOST_DEGREES} numbers"));
        }
    }
    if numbers.is_empty() { Err("it has no numbers".into()) } else { Ok(numbers) }
}
