//! The runs that did not complete. Runs with the same failure share a row, with the reason of the
//! first.

use crate::failure::Failure;
use crate::table::{self, Column};
use afterbay_experiments::in_short;
use afterbay_experiments::manifest::{Alike, RunOutcome};
use std::path::Path;

/// Prints the runs that did not complete. `out` is the folder of the results.
pub(crate) fn print(runs: &[RunOutcome], out: &Path) -> Result<(), Failure> {
    let failed = Alike::groups(runs);
    if failed.is_empty() {
        return Ok(());
    }
    let several = failed.iter().any(|alike| alike.count > 1);
    let mut columns = vec![
        Column::of("study", 2),
        Column::of("method", 0),
        Column::of("h", 1),
        Column::words("did not complete", 0, 16),
    ];
    if several {
        columns.push(Column::of("runs", 0));
    }
    let rows = failed.iter().map(|Alike { first, count }| {
        let h = in_short(first.h);
        vec![first.study.into(), first.method.into(), h, first.outcome.clone(), count.to_string()]
    });
    table::print(&columns, rows)?;
    for Alike { first, .. } in &failed {
        if let Some(why) = &first.failure {
            let at = first.point.as_ref().map(|point| format!(" at {point}")).unwrap_or_default();
            let h = in_short(first.h);
            table::text(&format!("{} with h = {h}{at}: {why}", first.method))?;
        }
    }
    if several {
        let record = out.join("run.json");
        table::text(&format!("The first of each row; all are in {}", record.display()))?;
    }
    Ok(())
}
