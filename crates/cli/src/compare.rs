//! `afterbay compare`

use crate::arguments::{CompareArguments, Format};
use crate::failure::Failure;
use crate::table::Column;
use crate::{experiment, table};
use afterbay_experiments::Finding;
use afterbay_experiments::compare::{self, Comparison, Difference, Joined};
use afterbay_experiments::journal::take_over;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// The summary printed as JSON.
#[derive(Serialize)]
struct Summary<'a> {
    out: &'a Path,
    findings: &'a [Finding],
    scene: &'a [Difference],
    tables: &'a [Joined],
}

pub(crate) fn run(arguments: &CompareArguments, format: Format) -> Result<ExitCode, Failure> {
    let &CompareArguments { ref a, ref b, ref out, force, files } = arguments;
    let Comparison { output, findings, scenes, tables } =
        compare::compare(a, b).map_err(Failure::compare)?;
    let is_out = |folder: &Path| folder.canonicalize().ok() == out.canonicalize().ok();
    if out.exists() && (is_out(a) || is_out(b)) {
        return Err(Failure::compared(out));
    }
    experiment::own_folder(out, &output.manifest.hash, force)?;
    if force {
        take_over(out, &output.manifest.hash)?;
    }
    output.write(out, files.into()).map_err(Failure::storage)?;
    match format {
        Format::Json => {
            table::json(&Summary { out, findings: &findings, scene: &scenes, tables: &tables })?;
        }
        Format::Table => {
            if !scenes.is_empty() {
                let rows = scenes.iter().map(Difference::row);
                let columns = [
                    Column::of("key of the scene", 0),
                    Column::words("A", 0, 10),
                    Column::words("B", 0, 10),
                ];
                table::print(&columns, rows)?;
            }
            experiment::print(&findings, &[], out)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
