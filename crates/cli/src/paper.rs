//! `afterbay paper`

use crate::arguments::Format;
use crate::bars::Bars;
use crate::failure::Failure;
use crate::table::Column;
use crate::{interrupt, table};
use afterbay_experiments::data::Files;
use afterbay_experiments::paper::{self, Extent};
use afterbay_experiments::record::{self, Held};
use std::path::Path;
use std::process::ExitCode;

pub(crate) fn run(
    (out, files): (&Path, Files),
    quick: bool,
    format: Format,
) -> Result<ExitCode, Failure> {
    // Fails now rather than after everything is computed.
    if let Some(held) = Held::read(out).filter(|held| held.command != "paper") {
        return Err(Failure::of_another(out, held.command));
    }
    record::prepare(out).map_err(Failure::storage)?;
    interrupt::listen();
    let bars = Bars::new();
    let extent = if quick { Extent::Quick } else { Extent::Full };
    let (output, findings) = paper::run(extent, &bars)?;
    bars.finish();
    output.write(out, files).map_err(Failure::storage)?;
    match format {
        Format::Json => table::json(&findings)?,
        Format::Table => {
            let rows = findings
                .iter()
                .map(|finding| vec![finding.verdict.describe().into(), finding.topic.clone()]);
            let columns = [Column::of("verdict", 0), Column::words("finding", 0, 30)];
            table::print(&columns, rows)?;
            table::text(
                "The report has the sentences and figures of each finding; so has --format json.",
            )?;
            table::text(&format!("Report: {}", out.join("report.html").display()))?;
        }
    }
    if let Some(code) = interrupt::exit_code() {
        if format == Format::Table {
            table::line("Interrupted: the report says which parts were not finished.")?;
        }
        return Ok(code);
    }
    // A run that fails here is a result of the paper. It is in its table and is no failure of the
    // command.
    Ok(ExitCode::SUCCESS)
}
