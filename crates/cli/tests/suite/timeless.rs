//! Tables without the column of measured times, for comparisons to the bit.

use std::path::Path;

/// The rows of a table as CSV text, without the column `seconds`.
pub(crate) fn timeless(path: &Path) -> String {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(path).expect("a table");
    let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().expect("rows");
    let seconds = rows[0].iter().position(|name| name == "seconds");
    let kept = |row: &csv::StringRecord| {
        let cells = row.iter().enumerate().filter(|&(i, _)| Some(i) != seconds).map(|cell| cell.1);
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    rows.iter().map(kept).collect()
}
