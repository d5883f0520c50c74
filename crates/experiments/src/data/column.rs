//! The columns of a table: their types, which follow from their cells, and their units.

use super::DataError;
use crate::UnitsTable;
use csv::StringRecord;
use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};
use std::collections::HashMap;
use std::io::Read;

/// The largest integer up to which f64 has all of them.
const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The type of its values.
    #[serde(rename = "type")]
    pub kind: Kind,
    /// The unit, where the scene gives one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Whether values are missing.
    pub missing: bool,
    /// The words of a column of words, each once, where the table has their numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
}

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
            _ => match (cell.parse::<i64>(), cell.parse::<f64>()) {
                (Ok(whole), _) if whole.unsigned_abs() <= EXACT => Self::Integer,
                (Err(_), Ok(_)) if !is_whole(cell) => Self::Float,
                _ => Self::Word,
            },
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

    /// A cell in JSON.
    pub(super) fn value(self, cell: &str) -> Value {
        let number = |number: Option<Number>| number.map(Value::Number);
        let found = match self {
            _ if cell.is_empty() => Some(Value::Null),
            Self::Integer => number(cell.parse::<i64>().ok().map(Number::from)),
            Self::Float => number(cell.parse().ok().and_then(Number::from_f64)),
            Self::Bool => cell.parse().ok().map(Value::Bool),
            Self::Word => None,
        };
        found.unwrap_or_else(|| cell.into())
    }
}

/// Whether a text is a whole number of any length.
fn is_whole(cell: &str) -> bool {
    let digits = cell.strip_prefix('-').unwrap_or(cell);
    digits.bytes().all(|byte| byte.is_ascii_digit())
}

/// The columns of a table in CSV, and the number of its rows. Cells behind the header belong to
/// columns named by their places.
pub(super) fn of_table(
    mut reader: csv::Reader<impl Read>,
    units: &UnitsTable,
) -> Result<(Vec<Column>, usize), DataError> {
    let mut found: Vec<Found> = reader.headers()?.iter().map(Found::new).collect();
    let (mut rows, mut record) = (0, StringRecord::new());
    while reader.read_record(&mut record)? {
        while found.len() < record.len() {
            let mut more = Found::new(&format!("column{}", found.len() + 1));
            more.missing = rows > 0;
            found.push(more);
        }
        for (at, column) in found.iter_mut().enumerate() {
            column.see(record.get(at).unwrap_or_default());
        }
        rows += 1;
    }
    Ok((found.into_iter().map(|found| found.column(units)).collect(), rows))
}

/// What the cells of a column are, as far as they were seen.
struct Found {
    name: String,
    kind: Option<Kind>,
    missing: bool,
}

impl Found {
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

    fn column(self, units: &UnitsTable) -> Column {
        let Self { name, kind, missing } = self;
        let kind = kind.unwrap_or(Kind::Float);
        let unit = units.of_column(&name).filter(|_| kind != Kind::Word).map(str::to_owned);
        Column { name, kind, unit, missing, words: Vec::new() }
    }
}

/// The different words of a column in the order in which they first occur.
#[derive(Default)]
pub(super) struct Words {
    pub(super) all: Vec<String>,
    places: HashMap<String, usize>,
}

impl Words {
    /// The place of a word.
    fn place(&mut self, word: &str) -> usize {
        if let Some(&place) = self.places.get(word) {
            return place;
        }
        self.places.insert(word.into(), self.all.len());
        self.all.push(word.into());
        self.all.len() - 1
    }

    /// A cell of a column as a number; NaN where it is empty.
    pub(super) fn number(&mut self, kind: Kind, cell: &str) -> f64 {
        match kind {
            _ if cell.is_empty() => f64::NAN,
            Kind::Integer | Kind::Float => cell.parse().unwrap_or(f64::NAN),
            Kind::Bool => f64::from(u8::from(cell == "true")),
            Kind::Word => self.place(cell) as f64,
        }
    }
}
