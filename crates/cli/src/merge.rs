//! `afterbay merge`

use crate::arguments::Format;
use crate::bars::Bars;
use crate::failure::Failure;
use crate::{experiment, interrupt, shard};
use afterbay_experiments::data::Files;
use afterbay_experiments::experiment::{perform, plan};
use afterbay_experiments::journal::{Joined, Journal};
use afterbay_experiments::scene::Task;
use std::path::Path;
use std::process::ExitCode;

/// Joins the cells of a folder and writes the results. A folder without studies has runs.
pub(crate) fn run(
    (folder, task): (&Path, Task),
    files: Files,
    format: Format,
) -> Result<ExitCode, Failure> {
    let Joined { journal, task, scene } = Journal::join(folder, task).map_err(Failure::merge)?;
    shard::warn(&journal);
    let plan = plan(task, &scene)?;
    let missing: Vec<&str> = journal.missing(&plan).map(|cell| &*cell.key).collect();
    if !missing.is_empty() {
        return Err(Failure::missing(&missing, plan.len()));
    }
    experiment::folder(folder, &scene, false)?;
    interrupt::listen();
    let bars = Bars::new();
    let results = perform(task, &scene, &journal, &bars)?;
    bars.finish();
    match results {
        Some(results) => {
            experiment::write(results, (folder, files, Some((&journal, plan.len()))), format)
        }
        None => Err(Failure::interrupted()),
    }
}
