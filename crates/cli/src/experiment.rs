//! `afterbay run` and `afterbay study`

use crate::arguments::{Format, SceneArguments};
use crate::bars::Bars;
use crate::failure::Failure;
use crate::table::Column;
use crate::{exit_code, interrupt, scene, table};
use afterbay_analysis::experiment::Results;
use afterbay_analysis::record::{self, Manifest, RunOutcome};
use afterbay_analysis::report::Verdict;
use afterbay_analysis::scene::{Scene, SceneError, SceneProblem};
use afterbay_analysis::study::outcome::COMPLETED;
use afterbay_analysis::{Finding, ReportError, experiment};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The command to run on a scene.
#[derive(Clone, Copy)]
pub(crate) enum What {
    Run,
    Study,
}

/// The summary printed as JSON.
#[derive(Serialize)]
struct Summary<'a> {
    out: &'a Path,
    findings: &'a [Finding],
    runs: &'a [RunOutcome],
}

pub(crate) fn run(
    what: What,
    arguments: &SceneArguments,
    format: Format,
) -> Result<ExitCode, Failure> {
    let scene = scene::read(&arguments.scene)?;
    wanted(what, &scene).map_err(|problem| {
        Failure::scene(&arguments.scene, "", SceneError { problem, span: 0..0 })
    })?;
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.scene));
    folder(&out, &scene, arguments.force)?;
    interrupt::listen();
    let bars = Bars::new();
    let (output, findings): Results = match what {
        What::Run => experiment::run(&scene, &bars),
        What::Study => experiment::study(&scene, &bars),
    }
    .map_err(|error: ReportError| Failure::from(error))?;
    bars.finish();
    output.write(&out).map_err(Failure::storage)?;
    let runs = &output.manifest.runs;
    match format {
        Format::Json => table::json(&Summary { out: &out, findings: &findings, runs })?,
        Format::Table => print(&findings, runs, &out)?,
    }
    let failed = runs.iter().any(|run| run.outcome != COMPLETED);
    Ok(exit_code::of_results(failed))
}

/// Makes the folder for the results of a scene before anything is computed. Refuses a folder with
/// the results of another scene unless `force` is set.
pub(crate) fn folder(out: &Path, scene: &Scene, force: bool) -> Result<(), Failure> {
    let document = serde_json::to_value(&scene.document).map_err(Failure::storage)?;
    own_folder(out, &Manifest::new("", document, Vec::new()), force)
}

/// Makes the folder for the results that a manifest describes, as [`folder`] does.
pub(crate) fn own_folder(out: &Path, manifest: &Manifest, force: bool) -> Result<(), Failure> {
    let others = Manifest::hash_in(out).filter(|found| *found != manifest.hash);
    match others.filter(|_| !force) {
        Some(other) => Err(Failure::taken(out, &other)),
        None => record::prepare(out).map_err(Failure::storage),
    }
}

/// Checks that the scene declares what the command needs.
fn wanted(what: What, scene: &Scene) -> Result<(), SceneProblem> {
    match what {
        What::Run if scene.run.is_none() => Err(SceneProblem::Nothing { table: "[run]" }),
        What::Study if scene.studies.is_empty() => {
            Err(SceneProblem::Nothing { table: "[study.*]" })
        }
        What::Run | What::Study => Ok(()),
    }
}

fn default_folder(scene: &Path) -> PathBuf {
    Path::new("out").join(scene.file_stem().unwrap_or(scene.as_os_str()))
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
    let failed: Vec<_> = runs.iter().filter(|run| run.outcome != COMPLETED).collect();
    if !failed.is_empty() {
        let h = |run: &RunOutcome| table::number(run.h);
        let rows = failed
            .iter()
            .map(|run| vec![run.study.into(), run.method.into(), h(run), run.outcome.clone()]);
        let columns = [
            Column::of("study", 2),
            Column::of("method", 0),
            Column::of("h", 1),
            Column::words("did not complete", 0, 16),
        ];
        table::print(&columns, rows)?;
        for run in failed {
            if let Some(why) = &run.failure {
                table::text(&format!("{} with h = {}: {why}", run.method, h(run)))?;
            }
        }
    }
    table::text(&format!("Report: {}", out.join("report.html").display()))
}
