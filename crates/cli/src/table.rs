//! Text, tables and JSON on stdout, as wide as the terminal, and messages on stderr.

use crate::printable::printable;
use comfy_table::{ColumnConstraint, ContentArrangement, Table, Width, presets};
use serde::Serialize;
use std::io::{self, BufWriter, Write};
use textwrap::{Options, WordSeparator, WordSplitter};

/// The width where there is no terminal.
const PIPE: usize = 120;
/// The widths that `COLUMNS` may set.
const WIDTHS: std::ops::RangeInclusive<usize> = 40..=1000;

/// Output that could not be printed.
#[derive(Debug)]
pub(crate) struct Unprinted(pub(crate) io::Error);

/// A column of a table.
pub(crate) struct Column {
    name: &'static str,
    /// The rank. If the table is too wide, columns of the largest rank are left out first. Columns
    /// of rank 0 are always shown.
    rank: u8,
    /// The least width to which its cells may be wrapped; none where they may not.
    least: Option<usize>,
}

impl Column {
    /// A column of names and numbers.
    pub(crate) fn of(name: &'static str, rank: u8) -> Self {
        Self { name, rank, least: None }
    }

    /// A column of words, which may be wrapped.
    pub(crate) fn words(name: &'static str, rank: u8, least: usize) -> Self {
        Self { name, rank, least: Some(least) }
    }

    /// The least width of the column with these cells.
    fn least<'a>(&self, cells: impl Iterator<Item = &'a str>) -> usize {
        let cells = cells.chain([self.name]);
        match self.least {
            None => cells.map(wide).max().unwrap_or(0),
            Some(least) => {
                let [all, word] = cells
                    .map(|cell| [wide(cell), cell.split(' ').map(wide).max().unwrap_or(0)])
                    .fold([0; 2], |[all, word], [a, b]| [all.max(a), word.max(b)]);
                least.max(word).min(all)
            }
        }
    }
}

/// The width of a text on a terminal.
fn wide(text: &str) -> usize {
    textwrap::core::display_width(text)
}

/// The width of stdout: that of `COLUMNS`, else that of the terminal.
pub(crate) fn width() -> usize {
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let terminal = || Table::new().width().map(usize::from);
    let known = asked.filter(|&columns: &usize| columns > 0).or_else(terminal);
    known.map_or(PIPE, |width| width.clamp(*WIDTHS.start(), *WIDTHS.end()))
}

/// Prints a table. Where it is too wide, the least important columns are left out and named below
/// it.
pub(crate) fn print(
    columns: &[Column],
    rows: impl IntoIterator<Item = Vec<String>>,
) -> Result<(), Unprinted> {
    let (width, rows): (_, Vec<_>) = (width(), rows.into_iter().collect());
    let cells = |i: usize| rows.iter().filter_map(move |row| row.get(i)).map(String::as_str);
    let least: Vec<_> = columns.iter().enumerate().map(|(i, x)| x.least(cells(i))).collect();
    let mut shown: Vec<usize> = (0..columns.len()).collect();
    // Each column has a blank on both sides, and there is one between two of them.
    let takes = |shown: &[usize]| 1 + shown.iter().map(|&i| least[i] + 3).sum::<usize>();
    while takes(&shown) > width {
        let rank = |at: &usize| columns[shown[*at]].rank;
        match (0..shown.len()).max_by_key(rank).filter(|at| rank(at) > 0) {
            Some(at) => drop(shown.remove(at)),
            None => break,
        }
    }
    let mut table = Table::new();
    table.load_preset(presets::UTF8_BORDERS_ONLY);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(u16::try_from(width).unwrap_or(u16::MAX));
    table.set_header(shown.iter().map(|&i| columns[i].name));
    table.add_rows(rows.iter().map(|row| shown.iter().filter_map(|&i| row.get(i))));
    for (at, &i) in shown.iter().enumerate() {
        let least = Width::Fixed(u16::try_from(least[i] + 2).unwrap_or(u16::MAX));
        if let Some(column) = table.column_mut(at) {
            column.set_constraint(match columns[i].least {
                None => ColumnConstraint::ContentWidth,
                Some(_) => ColumnConstraint::LowerBoundary(least),
            });
        }
    }
    line(&table.to_string())?;
    let left_out = columns.iter().enumerate().filter(|(i, _)| !shown.contains(i));
    let left_out: Vec<_> = left_out.map(|(_, column)| column.name).collect();
    match left_out.is_empty() {
        true => Ok(()),
        false => text(&format!(
            "Left out at this width: {} (--format json has all).",
            left_out.join("; ")
        )),
    }
}

/// Prints a paragraph, wrapped between words. Names, paths, and what stands beside `=` stay whole.
pub(crate) fn text(text: &str) -> Result<(), Unprinted> {
    let options = Options::new(width())
        .subsequent_indent("  ")
        .break_words(false)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation);
    let text = text.replace("(q, p)", "(q,\u{a0}p)").replace(" = ", "\u{a0}=\u{a0}");
    line(&textwrap::fill(&text, options).replace('\u{a0}', " "))
}

/// Prints JSON.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Unprinted> {
    let mut out = BufWriter::new(io::stdout().lock());
    let written = serde_json::to_writer_pretty(&mut out, value).map_err(io::Error::from);
    not_closed(written.and_then(|()| writeln!(out)).and_then(|()| out.flush()))
}

/// Prints lines, with control characters as escapes.
pub(crate) fn line(text: &str) -> Result<(), Unprinted> {
    not_closed(writeln!(io::stdout(), "{}", printable(text)))
}

/// Prints bytes as they are.
pub(crate) fn bytes(bytes: &[u8]) -> Result<(), Unprinted> {
    let mut out = io::stdout().lock();
    not_closed(out.write_all(bytes).and_then(|()| out.flush()))
}

/// Prints a message on stderr. If that fails, nothing is left to report it on.
pub(crate) fn message(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// A closed pipe is not an error.
fn not_closed(written: io::Result<()>) -> Result<(), Unprinted> {
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Unprinted(error)),
        _ => Ok(()),
    }
}
