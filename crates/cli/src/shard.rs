//! Shares of a study: the share that this command computes, the plan of all cells, and the summary
//! at the end of a share.

use crate::arguments::{Format, ShardArgument};
use crate::failure::{Failure, code_of_results};
use crate::table::{self, Column};
use afterbay_analysis::study::cell::Cell;
use afterbay_experiments::counted;
use afterbay_experiments::experiment::Cells;
use afterbay_experiments::journal::{Journal, Shard};
use afterbay_experiments::scene::Scene;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// The share that an argument asks for.
pub(crate) fn of(argument: ShardArgument) -> Result<Shard, Failure> {
    let shard = match argument {
        ShardArgument::Given(shard) => return Ok(shard),
        ShardArgument::Slurm => {
            let number = |name: &'static str, or: Option<usize>| match std::env::var(name) {
                Ok(text) => text.parse().map_err(|_| Failure::no_shard(name, &text)),
                Err(_) => or.ok_or_else(|| Failure::no_shard(name, "")),
            };
            let id = number("SLURM_ARRAY_TASK_ID", None)?;
            let count = number("SLURM_ARRAY_TASK_COUNT", None)?;
            // Without them the tasks are those from 1, one by one.
            let first = number("SLURM_ARRAY_TASK_MIN", Some(1))?;
            let step = number("SLURM_ARRAY_TASK_STEP", Some(1))?.max(1);
            let number = id.checked_sub(first).map_or(0, |after| after / step + 1);
            (number, count, "SLURM_ARRAY_TASK_ID", id)
        }
        ShardArgument::HyperQueue(count) => {
            let name = "HQ_TASK_ID";
            let text = std::env::var(name).map_err(|_| Failure::no_shard(name, ""))?;
            let number = text.parse().map_err(|_| Failure::no_shard(name, &text))?;
            (number, count, name, number)
        }
    };
    match shard {
        (number, count, ..) if (1..=count).contains(&number) => Ok(Shard { number, count }),
        (.., name, id) => Err(Failure::no_shard(name, &id.to_string())),
    }
}

/// The most cells of a plan that are listed as a table.
const MOST_LISTED: usize = 1000;

/// The plan printed as JSON.
#[derive(Serialize)]
struct Plan<'a> {
    scene: String,
    cost: f64,
    reference_bytes: f64,
    cells: &'a [Cell],
}

/// Prints all cells and their costs.
pub(crate) fn show(scene: &Scene, cells: &Cells<'_>, format: Format) -> Result<ExitCode, Failure> {
    let (plan, reference_bytes) = (cells.plan(), cells.reference_bytes());
    let cost = plan.iter().map(|cell| cell.cost).sum();
    match format {
        Format::Json => {
            table::json(&Plan { scene: scene.hash(), cost, reference_bytes, cells: plan })?;
        }
        Format::Table => {
            let row = |cell: &Cell| vec![cell.key.clone(), format!("{:.3e}", cell.cost)];
            let columns = [Column::words("cell", 0, 24), Column::of("cost", 1)];
            table::print(&columns, plan.iter().take(MOST_LISTED).map(row))?;
            if plan.len() > MOST_LISTED {
                let left = plan.len() - MOST_LISTED;
                table::text(&format!("And {left} more cells (--format json has all)."))?;
            }
            table::text(&format!(
                "{} of the scene {}. A cost is a number of steps times degrees of freedom; \
                 all are {cost:.3e}. The largest reference takes about {:.1} MB.",
                counted(plan.len(), "cell"),
                &scene.hash()[..12],
                1e-6 * reference_bytes,
            ))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints warnings about the cells of a journal on stderr.
pub(crate) fn warn(journal: &Journal) {
    if journal.damaged > 0 {
        let (lines, are) = if journal.damaged == 1 { ("line", "is") } else { ("lines", "are") };
        table::message(&format!(
            "{} {lines} of the journals {are} not whole and left out.",
            journal.damaged
        ));
    }
    if journal.mixed {
        table::message(
            "Some cells come from processors with other features: last digits may differ from \
             those of one machine.",
        );
    }
}

/// The summary of a share, or of a study that was stopped, printed as JSON.
#[derive(Serialize)]
struct Done<'a> {
    out: &'a Path,
    shard: String,
    cells: usize,
    finished: usize,
    reused: usize,
}

/// Prints how many cells of a share, or of a study that was stopped, are finished.
pub(crate) fn done(
    Shard { number, count }: Shard,
    (out, journal): (&Path, &Journal),
    format: Format,
) -> Result<ExitCode, Failure> {
    let (cells, finished, reused) = (journal.cells(), journal.finished(), journal.reused);
    let shard = format!("{number}/{count}");
    match format {
        Format::Json => table::json(&Done { out, shard, cells, finished, reused })?,
        Format::Table if finished < cells => table::text(&format!(
            "Share {shard}: {finished} of {} finished. --resume computes the others.",
            counted(cells, "cell")
        ))?,
        Format::Table => table::text(&format!(
            "Share {shard}: {}, {reused} of them from an earlier command. Join all shares with \
             `afterbay merge {}`.",
            counted(cells, "cell"),
            out.display(),
        ))?,
    }
    Ok(code_of_results(false))
}
