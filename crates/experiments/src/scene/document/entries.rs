//! The numbers of the initial state: a list, a rule, or a column of a file.

use super::Expression;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Numbers, one for each degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Entries {
    /// One after another.
    List(Vec<Expression>),
    /// One rule for a number of entries, or a file.
    Table(EntriesTable),
    /// One rule for all, in which i is the number of the degree of freedom.
    Rule(Expression),
}

impl Entries {
    /// The number of entries, if it is given.
    pub(in crate::scene) fn count(&self) -> Option<usize> {
        match self {
            Self::List(list) => Some(list.len()),
            Self::Table(table) => table.count.and_then(|count| usize::try_from(count).ok()),
            Self::Rule(_) => None,
        }
    }
}

/// A number of entries by one rule { count, value }, or a column of a file { file, column }.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EntriesTable {
    /// The number of entries.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<u64>,
    /// Entry i, counted from 1: a number or an expression such as "0.1*sin(pi*i/(n + 1))".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Expression>,
    /// A CSV file, relative to the folder of the scene. Lines that begin with # are comments, and
    /// the first line may name the columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The name of the column, or its number counted from 1 [default: the first].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<Column>,
}

/// A column of a file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Column {
    /// Its number, counted from 1.
    Number(u64),
    /// Its name.
    Name(String),
}
