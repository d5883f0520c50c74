//! The table of the runs that did not complete, with their points.

use crate::claim::in_short;
use crate::manifest::Alike;
use crate::sheet::Sheet;

/// The most rows of the table. The record has all runs.
const MOST_ROWS: usize = 20;

/// Adds the table, if there are such runs. Runs that ended alike share a row.
pub(super) fn list(sheet: &mut Sheet) {
    let groups = Alike::groups(&sheet.runs);
    let rows = groups.iter().take(MOST_ROWS).map(|Alike { first, count }| {
        let [point, why] = [&first.point, &first.failure].map(|x| x.clone().unwrap_or_default());
        let (h, count, outcome) = (in_short(first.h), count.to_string(), first.outcome.clone());
        vec![first.study.into(), first.method.into(), h, outcome, count, point, why]
    });
    let (rows, all): (Vec<_>, _) = (rows.collect(), groups.len());
    if all == 0 {
        return;
    }
    let columns = ["study", "method", "h", "did not complete", "runs", "first at", "why"];
    sheet.table(&columns, rows);
    if all > MOST_ROWS {
        sheet.text(format!("The first {MOST_ROWS} rows of {all}. All runs are in run.json."));
    }
}
