//! A command that did not do what it was asked for, and the exit code that says so to scripts.

use afterbay_analysis::paper::PaperError;
use miette::Diagnostic;
use thiserror::Error;

/// The study could not be run as asked for.
const USAGE: u8 = 2;
/// Results could not be written.
const STORAGE: u8 = 5;

/// What went wrong, and the exit code.
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
    #[error("the threads could not be started")]
    #[diagnostic(help("ask for fewer with --threads N"))]
    Threads(#[source] Box<dyn std::error::Error + Send + Sync>),
    #[error("the study could not be run")]
    Study(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl Failure {
    pub(crate) fn storage(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { diagnostic: Trouble::Storage(Box::new(error)), code: STORAGE }
    }

    pub(crate) fn threads(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { diagnostic: Trouble::Threads(Box::new(error)), code: USAGE }
    }
}

impl From<PaperError> for Failure {
    fn from(error: PaperError) -> Self {
        match error {
            PaperError::Storage(error) => Self::storage(error),
            PaperError::Study(error) => Self { diagnostic: Trouble::Study(Box::new(error)), code: USAGE },
        }
    }
}
