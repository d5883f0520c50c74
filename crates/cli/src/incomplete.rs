//! The runs that did not complete: a row for those that ended alike, and the reason of the first.

use crate::failure::Failure;
use crate::table::{self, Column};
use afterbay_analysis::study::outcome::COMPLETED;
use afterbay_experiments::record::RunOutcome;
use std::path::Path;

/// Runs of a method with a step that ended alike, such as those at the points of a sweep.
struct Alike<'a> {
    first: &'a RunOutcome,
    count: usize,
}

/// Prints the runs that did not complete. `out` is the folder of the results.
pub(crate) fn print(runs: &[RunOutcome], out: &Path) -> Result<(), Failure> {
    let failed = grouped(runs.iter().filter(|run| run.outcome != COMPLETED));
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
        let h = table::number(first.h);
        vec![first.study.into(), first.method.into(), h, first.outcome.clone(), count.to_string()]
    });
    table::print(&columns, rows)?;
    for Alike { first, .. } in &failed {
        if let Some(why) = &first.failure {
            let at = first.point.as_ref().map(|point| format!(" at {point}")).unwrap_or_default();
            let h = table::number(first.h);
            table::text(&format!("{} with h = {h}{at}: {why}", first.method))?;
        }
    }
    if several {
        let record = out.join("run.json");
        table::text(&format!("The first of each row; all are in {}", record.display()))?;
    }
    Ok(())
}

/// The groups of runs of a study, a method and a step that ended alike, in the order of their first
/// runs.
fn grouped<'a>(runs: impl Iterator<Item = &'a RunOutcome>) -> Vec<Alike<'a>> {
    let mut groups: Vec<Alike<'a>> = Vec::new();
    let key = |run: &RunOutcome| (run.study, run.method, run.h.to_bits());
    for run in runs {
        let is_alike =
            |x: &&mut Alike<'_>| key(x.first) == key(run) && x.first.outcome == run.outcome;
        match groups.iter_mut().find(is_alike) {
            Some(alike) => alike.count += 1,
            None => groups.push(Alike { first: run, count: 1 }),
        }
    }
    groups
}
