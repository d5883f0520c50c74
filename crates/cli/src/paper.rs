//! `afterbay paper`

use crate::arguments::Format;
use crate::bars::Bars;
use crate::{exit, table};
use afterbay_analysis::paper::{self, Extent, PaperError};
use afterbay_analysis::report::Verdict;
use miette::Diagnostic;
use std::path::Path;
use std::process::ExitCode;
use thiserror::Error;

/// A command that did not do what it was asked for.
pub(crate) struct Failure {
    pub(crate) diagnostic: Trouble,
    pub(crate) code: u8,
}

/// What to say of it.
#[derive(Debug, Error, Diagnostic)]
pub(crate) enum Trouble {
    #[error("the results could not be written")]
    #[diagnostic(help("give a folder that can be written to with --out DIR"))]
    Storage(#[source] Box<dyn std::error::Error + Send + Sync>),
    #[error("the study could not be run")]
    Study(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl Failure {
    pub(crate) fn storage(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { diagnostic: Trouble::Storage(Box::new(error)), code: exit::STORAGE }
    }
}

impl From<PaperError> for Failure {
    fn from(error: PaperError) -> Self {
        match error {
            PaperError::Storage(error) => Self::storage(error),
            PaperError::Study(error) => {
                Self { diagnostic: Trouble::Study(Box::new(error)), code: exit::USAGE }
            }
        }
    }
}

pub(crate) fn run(out: &Path, quick: bool, format: Format) -> Result<ExitCode, Failure> {
    let bars = Bars::new();
    let extent = if quick { Extent::Quick } else { Extent::Full };
    let (output, findings) = paper::run(extent, &bars)?;
    bars.finish();
    output.write(out).map_err(Failure::storage)?;
    match format {
        Format::Json => table::json(&findings)?,
        Format::Table => {
            let word = |verdict| match verdict {
                Verdict::Holds => "holds",
                Verdict::Fails => "does not hold",
                Verdict::Note => "note",
            };
            let rows = findings.iter().map(|finding| {
                vec![word(finding.verdict).into(), format!("{}: {}", finding.topic, finding.statement)]
            });
            table::print(&["verdict", "on what, and what was found"], rows)?;
            table::line(&format!("Report: {}", out.join("report.html").display()))?;
        }
    }
    // A run that fails in here is what the study set out to show: it is in its table, and no failure of the command.
    Ok(ExitCode::SUCCESS)
}
