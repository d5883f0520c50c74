//! `afterbay run` and `afterbay study`

use crate::arguments::{Format, SceneArguments};
use crate::bars::Bars;
use crate::failure::{Failure, code_of_results};
use crate::{incomplete, interrupt, scene, shard, table};
use afterbay_analysis::study::outcome::COMPLETED;
use afterbay_experiments::data::Files;
use afterbay_experiments::experiment::{Cells, Results};
use afterbay_experiments::journal::{Journal, Shard, Start, other_scene};
use afterbay_experiments::manifest::RunOutcome;
use afterbay_experiments::record;
use afterbay_experiments::report::Verdict;
use afterbay_experiments::scene::{Scene, SceneError, SceneProblem, Task};
use afterbay_experiments::{Finding, experiment};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The summary printed as JSON.
#[derive(Serialize)]
struct Summary<'a> {
    out: &'a Path,
    findings: &'a [Finding],
    runs: &'a [RunOutcome],
    /// The cells that were taken from the journal.
    reused: usize,
    cells: usize,
}

pub(crate) fn run(
    task: Task,
    arguments: &SceneArguments,
    format: Format,
) -> Result<ExitCode, Failure> {
    let scene = scene::read(&arguments.scene)?;
    wanted(task, &scene).map_err(|problem| {
        Failure::scene(&arguments.scene, "", SceneError { problem, span: 0..0 })
    })?;
    let cells = Cells::new(task, &scene)?;
    if arguments.plan {
        return shard::show(&scene, &cells, format);
    }
    let plan = cells.plan();
    let shard = arguments.shard.map(shard::of).transpose()?;
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.scene));
    folder(&out, &scene, arguments.force)?;
    let files = arguments.files.into();
    interrupt::listen();
    let bars = Bars::new();
    let start = match (arguments.resume, arguments.force) {
        (true, _) => Start::Resume,
        (_, true) => Start::Force,
        _ => Start::Fresh,
    };
    let share = (plan, shard.unwrap_or(Shard::WHOLE));
    let journal = Journal::open(&out, (task, &scene), share, start)?;
    shard::warn(&journal);
    let results = experiment::perform(task, &scene, &journal, &bars)?;
    bars.finish();
    match (shard, results) {
        (None, Some(results)) => {
            write(results, (&out, files, Some((&journal, plan.len()))), format)
        }
        (shard, _) => shard::done(shard.unwrap_or(Shard::WHOLE), (&out, &journal), format),
    }
}

/// Writes the results, and prints the findings.
pub(crate) fn write(
    (output, findings): Results,
    (out, files, cells): (&Path, Files, Option<(&Journal, usize)>),
    format: Format,
) -> Result<ExitCode, Failure> {
    output.write(out, files).map_err(Failure::storage)?;
    let runs = &output.manifest.runs;
    let (reused, cells) = cells.map_or((0, 0), |(journal, cells)| (journal.reused, cells));
    match format {
        Format::Json => {
            table::json(&Summary { out, findings: &findings, runs, reused, cells })?;
        }
        Format::Table => {
            print(&findings, runs, out)?;
            if reused > 0 {
                table::text(&format!("{reused} of {cells} cells were there already."))?;
            }
        }
    }
    let failed = runs.iter().any(|run| run.outcome != COMPLETED);
    Ok(code_of_results(failed))
}

/// Makes the folder for the results of a scene before anything is computed. Refuses a folder with
/// the results or journals of another scene unless `force` is set.
pub(crate) fn folder(out: &Path, scene: &Scene, force: bool) -> Result<(), Failure> {
    own_folder(out, &scene.hash(), force)
}

/// Makes the folder for the results of a scene with this hash, as [`folder`] does.
pub(crate) fn own_folder(out: &Path, hash: &str, force: bool) -> Result<(), Failure> {
    match other_scene(out, hash).filter(|_| !force) {
        Some(other) => Err(Failure::taken(out, &other)),
        None => record::prepare(out).map_err(Failure::storage),
    }
}

/// Checks that the scene declares what the command needs.
fn wanted(task: Task, scene: &Scene) -> Result<(), SceneProblem> {
    match task {
        Task::Run if scene.run.is_none() => Err(SceneProblem::Nothing { table: "[run]" }),
        Task::Study if scene.studies.is_empty() => {
            Err(SceneProblem::Nothing { table: "[study.*]" })
        }
        Task::Run | Task::Study => Ok(()),
    }
}

fn default_folder(scene: &Path) -> PathBuf {
    // A stem `.` or `..` would be a folder that is there already.
    let stem = scene.file_stem().filter(|stem| *stem != "." && *stem != "..");
    Path::new("out").join(stem.or(scene.file_name()).unwrap_or(scene.as_os_str()))
}

pub(crate) fn print(findings: &[Finding], runs: &[RunOutcome], out: &Path) -> Result<(), Failure> {
    for finding in findings {
        let mark = match finding.verdict {
            Verdict::Holds => "holds: ",
            Verdict::Fails => "! ",
            Verdict::Note => "",
        };
        table::text(&format!("{mark}{}: {}", finding.topic, finding.statement))?;
    }
    incomplete::print(runs, out)?;
    table::text(&format!("Report: {}", out.join("report.html").display()))?;
    Ok(())
}
