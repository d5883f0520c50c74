//! A command that did not do what it was asked for, and the exit code that says so to scripts.

use crate::experiment::FAILED;
use afterbay_analysis::ReportError;
use afterbay_analysis::scene::SceneError;
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The study could not be run as asked for.
const USAGE: u8 = 2;
/// The scene is not valid.
const SCENE: u8 = 3;
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
    #[error("{} holds the results of another scene", folder.display())]
    #[diagnostic(help(
        "give another folder with --out DIR, or lose those results with --force (its scene has the hash {hash})"
    ))]
    Taken { folder: PathBuf, hash: String },
    #[error("the scene {} cannot be read", path.display())]
    #[diagnostic(help("a scene is a TOML file: see the folder scenes/, and `afterbay schema`"))]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("{message}")]
    Scene {
        message: String,
        #[help]
        help: Option<String>,
        #[source_code]
        text: NamedSource<String>,
        #[label("here")]
        span: Option<SourceSpan>,
    },
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

    pub(crate) fn taken(folder: &Path, hash: &str) -> Self {
        let diagnostic = Trouble::Taken { folder: folder.into(), hash: hash.chars().take(12).collect() };
        Self { diagnostic, code: STORAGE }
    }

    pub(crate) fn unreadable(path: &Path, source: std::io::Error) -> Self {
        Self { diagnostic: Trouble::Unreadable { path: path.into(), source }, code: SCENE }
    }

    /// What is wrong with a scene, pointed at in its text where there is one.
    pub(crate) fn scene(path: &Path, text: &str, error: SceneError) -> Self {
        let span = (!text.is_empty()).then(|| SourceSpan::from(error.span));
        let diagnostic = Trouble::Scene {
            message: error.problem.to_string(),
            help: error.problem.help(),
            text: NamedSource::new(path.display().to_string(), text.to_owned()),
            span,
        };
        Self { diagnostic, code: SCENE }
    }

    pub(crate) fn study(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { diagnostic: Trouble::Study(Box::new(error)), code: FAILED }
    }

    pub(crate) fn threads(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { diagnostic: Trouble::Threads(Box::new(error)), code: USAGE }
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Storage(error) => Self::storage(error),
            ReportError::Study(error) => Self::study(error),
            ReportError::Map(error) => Self::study(error),
        }
    }
}
