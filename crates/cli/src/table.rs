//! Tables and JSON on stdout.

use crate::failure::Failure;
use comfy_table::{ContentArrangement, Table, presets};
use serde::Serialize;
use std::io::{self, Write};

/// Wider lines than this are hard to read, however wide the terminal.
const WIDEST: u16 = 120;

/// Prints a table that fits the terminal.
pub(crate) fn print(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Result<(), Failure> {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_BORDERS_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(table.width().map_or(WIDEST, |width| width.min(WIDEST)));
    table.set_header(header).add_rows(rows);
    line(&table.to_string())
}

/// Prints JSON.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::storage)?;
    line(&text)
}

/// Prints a line. A reader that has gone away has seen enough.
pub(crate) fn line(text: &str) -> Result<(), Failure> {
    match writeln!(io::stdout(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::storage(error)),
        _ => Ok(()),
    }
}
