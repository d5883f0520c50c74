//! The columns of a table, and their cells in JSON and in arrays.

use crate::UnitsTable;
use afterbay_analysis::columns::{ColumnCells, Kind};
use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};
use std::collections::HashMap;

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

impl Column {
    /// The column of these cells.
    pub(super) fn of(cells: ColumnCells, units: &UnitsTable) -> Self {
        let ColumnCells { name, kind, missing } = cells;
        let kind = kind.unwrap_or(Kind::Float);
        let unit = units.of_column(&name).filter(|_| kind != Kind::Word).map(str::to_owned);
        Self { name, kind, unit, missing, words: Vec::new() }
    }

    /// One of its cells in JSON.
    pub(super) fn value(&self, cell: &str) -> Value {
        let number = |number: Option<Number>| number.map(Value::Number);
        let found = match self.kind {
            _ if cell.is_empty() => Some(Value::Null),
            Kind::Integer => number(cell.parse::<i64>().ok().map(Number::from)),
            Kind::Float => number(cell.parse().ok().and_then(Number::from_f64)),
            Kind::Bool => cell.parse().ok().map(Value::Bool),
            Kind::Word => None,
        };
        found.unwrap_or_else(|| cell.into())
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
