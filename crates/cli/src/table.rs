//! Tables and JSON on stdout.

use crate::failure::Failure;
use comfy_table::{ColumnConstraint, ContentArrangement, Table, presets};
use serde::Serialize;
use std::io::{self, Write};

/// Prints a table that fits the terminal without breaking names; one line per row if there is no
/// terminal.
pub(crate) fn print(
    header: &[&str],
    rows: impl IntoIterator<Item = Vec<String>>,
) -> Result<(), Failure> {
    let mut table = Table::new();
    let arrangement =
        if table.is_tty() { ContentArrangement::Dynamic } else { ContentArrangement::Disabled };
    table.load_preset(presets::UTF8_BORDERS_ONLY).set_content_arrangement(arrangement);
    table.set_header(header).add_rows(rows);
    if let Some(names) = table.column_mut(0) {
        names.set_constraint(ColumnConstraint::ContentWidth);
    }
    line(&table.to_string())
}

/// Prints JSON.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::storage)?;
    line(&text)
}

/// Prints a line. A closed pipe is not an error.
pub(crate) fn line(text: &str) -> Result<(), Failure> {
    match writeln!(io::stdout(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::storage(error)),
        _ => Ok(()),
    }
}
