//! The table of the runs that did not complete, with their points.

use crate::sheet::Sheet;
use afterbay_analysis::study::outcome::COMPLETED;

/// The most runs that did not complete and are listed. The record has all.
const MOST_FAILED: usize = 20;

/// Adds the table, if there are such runs.
pub(super) fn list(sheet: &mut Sheet) {
    let failed = || sheet.runs.iter().filter(|run| run.outcome != COMPLETED);
    let count = failed().count();
    if count == 0 {
        return;
    }
    let rows = failed().take(MOST_FAILED).map(|run| {
        let point = run.point.clone().unwrap_or_default();
        let why = run.failure.clone().unwrap_or_default();
        vec![run.study.into(), run.method.into(), point, run.outcome.clone(), why]
    });
    let rows = rows.collect();
    sheet.table(&["study", "method", "point", "did not complete", "why"], rows);
    if count > MOST_FAILED {
        sheet.text(format!("The first {MOST_FAILED} of {count}. All are in run.json."));
    }
}
