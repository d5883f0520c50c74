//! Two results side by side: the differences of their scenes, of the rows of their tables, and of
//! their trajectories.

mod charts;
mod findings;
mod folder;
mod join;
mod scenes;
mod table;
mod trajectories;

pub use join::{Column, Joined, Measure};
pub use scenes::Difference;

use crate::claim::Finding;
use crate::data::DataError;
use crate::manifest::{Manifest, processor};
use crate::record::Output;
use crate::report::{Block, Report, Section};
use crate::sheet::{Gathered, Placed, ReportError, Sheet, scientific, table};
use charts::Drawn;
use findings::Counts;
use folder::Folder;
use serde_json::json;
use std::path::{Path, PathBuf};
use table::Table;
use thiserror::Error;

/// The most rows of a joined table that the report shows.
const SHOWN: usize = 100;

/// Two results compared.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The report and its tables.
    pub output: Output,
    /// Whether the results are equal, and how each table differs.
    pub findings: Vec<Finding>,
    /// The keys of the scenes that differ.
    pub scenes: Vec<Difference>,
    /// The tables that both have.
    pub tables: Vec<Joined>,
}

/// A reason why two results cannot be compared.
#[derive(Debug, Error)]
pub enum CompareError {
    /// There is no such folder.
    #[error("there is no folder {}", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder without a manifest.
    #[error("{} is no result: its run.json cannot be read", folder.display())]
    NoResult {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A manifest that is not one of afterbay.
    #[error("{} is no result: its run.json is not that of a run", folder.display())]
    Manifest {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: serde_json::Error,
    },
    /// The result of a command that has nothing to compare.
    #[error("{} is a result of `{command}`", folder.display())]
    Command {
        /// The folder.
        folder: PathBuf,
        /// The command.
        command: String,
    },
    /// A folder of tables that cannot be read.
    #[error("the tables in {} cannot be read", folder.display())]
    Data {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A table that is not what its extension says.
    #[error("the table {} cannot be read", file.display())]
    Table {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: DataError,
    },
    /// Two results without a common table.
    #[error("the results have no table in common: A has {}, B has {}", tables[0], tables[1])]
    NothingInCommon {
        /// The names of the tables in A, and in B.
        tables: [String; 2],
    },
    /// A report that cannot be made.
    #[error(transparent)]
    Report(#[from] ReportError),
}

impl CompareError {
    /// Advice on how to mend the error.
    pub fn help(&self) -> &'static str {
        match self {
            Self::NoFolder { .. } | Self::NoResult { .. } | Self::Manifest { .. } => {
                "give two folders that `afterbay run`, `study`, `paper` or `pick --out` has written"
            }
            Self::Command { .. } => "compare results of `run`, `study`, `paper` or `pick`",
            Self::Data { .. } | Self::Table { .. } => "repeat the command that wrote them",
            Self::NothingInCommon { .. } => {
                "compare two results of one command and the same studies; `run` and `study` write \
                 different tables"
            }
            Self::Report(_) => "give a folder that can be written to with --out DIR",
        }
    }
}

/// Compares the results A and B in two folders.
///
/// # Errors
/// [`CompareError`] where a folder is no result, a table cannot be read, or no table is in both.
pub fn compare(a: &Path, b: &Path) -> Result<Comparison, CompareError> {
    let (a, b) = (Folder::read(a)?, Folder::read(b)?);
    let mut joined = Vec::new();
    for (name, table) in &a.tables {
        joined.extend(b.tables.get(name).map(|other| Joined::of(name, table, other)));
    }
    if joined.is_empty() {
        return Err(CompareError::NothingInCommon { tables: [a.names(), b.names()] });
    }
    let scenes = scenes::differences(&a.origin.scene, &b.origin.scene);
    let mut sheets = vec![origin(&a, &b, &scenes, &joined)];
    for table in &joined {
        let tables = (&a.tables[&table.name], &b.tables[&table.name]);
        sheets.push(sheet(table, tables).map_err(ReportError::from)?);
    }
    let Gathered { sections, artifacts, findings, .. } =
        sheets.into_iter().collect::<Gathered>().in_order();
    let (report, manifest) = report(&a, &b, sections);
    let output = Output { report, artifacts, manifest };
    Ok(Comparison { output, findings, scenes, tables: joined })
}

/// The first section: the origin of the results, and their differences.
fn origin(a: &Folder, b: &Folder, scenes: &[Difference], joined: &[Joined]) -> Sheet {
    let mut sheet = Sheet::new("What differs");
    let only = |one: &Folder, other: &Folder| -> Vec<String> {
        one.tables.keys().filter(|name| !other.tables.contains_key(*name)).cloned().collect()
    };
    let in_one = [("A", only(a, b)), ("B", only(b, a))];
    let tables_in_one = in_one.iter().map(|(_, names)| names.len()).sum();
    let of_another = a.of_another.len() + b.of_another.len();
    let counts = Counts { scene: scenes.len(), tables_in_one, of_another };
    sheet.find("The results", findings::overall(&counts, joined), findings::equal_or_not);
    for (side, names) in in_one.iter().filter(|(_, names)| !names.is_empty()) {
        sheet.text(format!("Tables in {side} only: {}.", names.join(", ")));
    }
    for (side, names) in [("A", &a.of_another), ("B", &b.of_another)] {
        if !names.is_empty() {
            let names = names.join(", ");
            sheet.text(format!("Tables in {side} that come from another scene: {names}."));
        }
    }
    let row = |what: &str, of: &dyn Fn(&Folder) -> String| vec![what.to_owned(), of(a), of(b)];
    sheet.table(
        &["what", "A", "B"],
        vec![
            row("folder", &|x| x.path.display().to_string()),
            row("command", &|x| x.origin.command.clone()),
            row("version", &|x| x.origin.version.clone()),
            row("hash of the scene", &|x| x.origin.hash.chars().take(12).collect()),
            row("methods", &|x| x.origin.methods().join(", ")),
            row("runs", &|x| x.origin.outcomes()),
            row("processor", &|x| x.origin.cpu.clone()),
            row("threads", &|x| x.origin.threads.to_string()),
        ],
    );
    if !scenes.is_empty() {
        let rows = scenes.iter().map(Difference::row).collect();
        sheet.table(&["key of the scene", "A", "B"], rows);
    }
    sheet
}

/// The section of a table.
fn sheet(joined: &Joined, tables: (&Table, &Table)) -> Result<Sheet, crate::record::StorageError> {
    let mut sheet = Sheet::new(&joined.name);
    for (side, table) in [("A", tables.0), ("B", tables.1)] {
        if table.rows.is_empty() {
            sheet.text(format!("The table {} is empty in {side}.", joined.name));
        }
    }
    for (side, names) in ["A", "B"].iter().zip(&joined.columns_in_one) {
        if !names.is_empty() {
            sheet.text(format!("Columns in {side} only: {}.", names.join(", ")));
        }
    }
    sheet.text(match &joined.keys[..] {
        [] => "Rows are joined in their order.".into(),
        keys => format!("Rows are joined by {}.", keys.join(", ")),
    });
    let columns: Vec<&Column> = joined.columns.iter().collect();
    let rows: Vec<_> =
        joined.pairs.iter().map(|pair| joined.entries(tables, *pair, &columns)).collect();
    sheet.wide_data(&joined.name, &joined.header(&columns), &rows)?;
    let topic = joined.name.clone();
    let mut charts = Vec::new();
    if joined.name.ends_with("trajectory") {
        let found = trajectories::distances(joined, tables);
        let name = format!("{}_differences", joined.name);
        sheet.data(&name, &found)?;
        if !joined.is_equal() {
            sheet.find(&topic, findings::of_trajectories(&found), findings::largest_distances);
            let drawn = charts::distances(joined, &found).into_iter();
            charts.extend(drawn.map(|chart| (chart, name.clone())));
        }
    } else if !joined.is_equal() || joined.times().next().is_some() {
        sheet.find(&topic, findings::of_table(joined), findings::columns_that_differ);
    }
    if joined.is_equal() {
        sheet.text("Nothing differs.");
    }
    let overlaid = charts::overlaid(joined, tables).into_iter();
    let overlaid = overlaid.map(|chart| (chart, joined.name.clone()));
    show(&mut sheet, overlaid.chain(charts));
    sheet.section.blocks.push(summary(joined));
    let different: Vec<&Column> = joined.columns.iter().filter(|c| c.different > 0).collect();
    if !different.is_empty() && joined.pairs.len() <= SHOWN {
        let rows =
            joined.pairs.iter().map(|pair| shortened(joined.entries(tables, *pair, &different)));
        let header = joined.header(&different);
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        sheet.fold("the columns that differ, row by row", vec![table(&header, rows.collect())]);
    }
    Ok(sheet)
}

/// The columns of a table: in how many rows they differ, and how far.
fn summary(joined: &Joined) -> Block {
    let row = |column: &Column| {
        let [lo, hi] = column.range.map_or([None; 2], |range| range.map(Some));
        let measure = match (column.words, column.measure, column.range) {
            (true, ..) => "words",
            (_, _, None) => "",
            (_, Measure::Difference, _) => "B - A",
            (_, Measure::Ratio | Measure::Time, _) => "B/A",
        };
        let count = |count: usize| count.to_string();
        let (different, empty) = (count(column.different), count(column.empty));
        vec![column.name.clone(), different, empty, measure.into(), scientific(lo), scientific(hi)]
    };
    let header = ["column", "rows that differ", "empty in one", "compared by", "least", "largest"];
    table(&header, joined.columns.iter().map(row).collect())
}

/// Entries for the report: numbers with four significant digits.
fn shortened(entries: Vec<String>) -> Vec<String> {
    let short = |entry: String| match entry.parse::<f64>() {
        Ok(x) if x.is_finite() && entry.len() > 8 => format!("{x:.3e}"),
        _ => entry,
    };
    entries.into_iter().map(short).collect()
}

/// Shows charts, narrow ones side by side.
fn show(sheet: &mut Sheet, charts: impl Iterator<Item = (Drawn, String)>) {
    let place = |(Drawn { name, drawing, caption, wide }, data): (Drawn, String)| Placed {
        figure: sheet.figure(&name, drawing, caption, &data),
        wide,
    };
    let figures: Vec<_> = charts.map(place).collect();
    sheet.arrange(figures);
}

fn report(a: &Folder, b: &Folder, sections: Vec<Section>) -> (Report, Manifest) {
    let side = |of: &Folder| {
        json!({
            "folder": of.path,
            "command": of.origin.command,
            "version": of.origin.version,
            "hash": of.origin.hash,
        })
    };
    let manifest = Manifest::new("compare", json!({ "a": side(a), "b": side(b) }), Vec::new());
    let report = Report {
        title: "Two results compared".into(),
        subtitle: format!(
            "A is {} and B is {}. Compared by afterbay {} on {}.",
            a.path.display(),
            b.path.display(),
            manifest.version,
            processor()
        ),
        sections,
    };
    (report, manifest)
}
