//! The types of the columns of a table in CSV, which follow from all of their cells.

use csv::StringRecord;
use serde::{Deserialize, Serialize};
use std::io::Read;

/// f64 represents every integer up to this one.
const LARGEST_INTEGER: u64 = 1 << f64::MANTISSA_DIGITS;

/// The type of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Whole numbers up to 2^53.
    Integer,
    /// Numbers in f64.
    Float,
    /// `true` and `false`.
    Bool,
    /// Anything else.
    Word,
}

impl Kind {
    /// The type of a cell.
    fn of(cell: &str) -> Self {
        match cell {
            "true" | "false" => Self::Bool,
            _ if is_whole(cell) => match cell.parse::<i64>() {
                Ok(whole) if whole.unsigned_abs() <= LARGEST_INTEGER => Self::Integer,
                _ => Self::Word,
            },
            _ if cell.parse::<f64>().is_ok() => Self::Float,
            _ => Self::Word,
        }
    }

    /// The type that has the values of both.
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (one, other) if one == other => one,
            (Self::Integer | Self::Float, Self::Integer | Self::Float) => Self::Float,
            _ => Self::Word,
        }
    }
}

/// Whether a text is a whole number of any length.
fn is_whole(cell: &str) -> bool {
    let digits = cell.strip_prefix('-').unwrap_or(cell);
    digits.bytes().all(|byte| byte.is_ascii_digit())
}

/// The cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnCells {
    /// The name of the column.
    pub name: String,
    /// Their type; none where all are empty.
    pub kind: Option<Kind>,
    /// Whether some are empty.
    pub missing: bool,
}

impl ColumnCells {
    fn new(name: &str) -> Self {
        Self { name: name.into(), kind: None, missing: false }
    }

    fn see(&mut self, cell: &str) {
        if cell.is_empty() {
            self.missing = true;
        } else {
            let kind = Kind::of(cell);
            self.kind = Some(self.kind.map_or(kind, |before| before.and(kind)));
        }
    }
}

/// The columns and the length of a table.
#[derive(Clone, Debug)]
pub struct TableColumns {
    /// The columns.
    pub columns: Vec<ColumnCells>,
    /// The number of rows, the header not included.
    pub rows: usize,
}

/// The columns of a table with a header. Rows may differ in length: cells behind the header belong
/// to columns named by their places.
///
/// # Errors
/// A text that cannot be read, or is not CSV.
pub fn of_table(table: &mut dyn Read) -> Result<TableColumns, csv::Error> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(table);
    let mut columns: Vec<ColumnCells> = reader.headers()?.iter().map(ColumnCells::new).collect();
    let (mut rows, mut record) = (0, StringRecord::new());
    while reader.read_record(&mut record)? {
        while columns.len() < record.len() {
            let mut more = ColumnCells::new(&format!("column{}", columns.len() + 1));
            more.missing = rows > 0;
            columns.push(more);
        }
        for (at, column) in columns.iter_mut().enumerate() {
            column.see(record.get(at).unwrap_or_default());
        }
        rows += 1;
    }
    Ok(TableColumns { columns, rows })
}
