//! The failures of a command: a message for people and an exit code for scripts.

use crate::exit_code::{FAILED, SCENE, STORAGE, USAGE};
use crate::printable::Printable;
use crate::table::Unprinted;
use crate::{interrupt, table};
use afterbay_experiments::ReportError;
use afterbay_experiments::compare::CompareError;
use afterbay_experiments::counted;
use afterbay_experiments::journal::JournalError;
use afterbay_experiments::scene::{SceneError, Task};
use miette::{Diagnostic, NamedSource, SourceSpan};
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use thiserror::Error;

/// The diagnostic of a failure, and its exit code.
pub(crate) struct Failure {
    pub(crate) diagnostic: Box<Trouble>,
    pub(crate) code: u8,
}

/// The message and the help of a failure.
#[derive(Debug, Error, Diagnostic)]
pub(crate) enum Trouble {
    #[error("the results could not be written")]
    #[diagnostic(help("give a folder that can be written to with --out DIR"))]
    Storage(#[source] Box<dyn std::error::Error + Send + Sync>),
    #[error("the output could not be printed")]
    #[diagnostic(help("make room where the output goes, or send it elsewhere"))]
    Stdout(#[source] std::io::Error),
    #[error("{} holds the results of another scene, or parts of them", folder.display())]
    #[diagnostic(help(
        "give another folder with --out DIR, or overwrite those results with --force (its scene \
         has the hash {hash})"
    ))]
    Taken { folder: PathBuf, hash: String },
    #[error("{} holds results of `afterbay {command}`", folder.display())]
    #[diagnostic(help("give another folder with --out DIR"))]
    OfAnother { folder: PathBuf, command: String },
    #[error("{} is one of the two results", folder.display())]
    #[diagnostic(help("give another folder with --out DIR"))]
    Compared { folder: PathBuf },
    #[error("the file {} exists", path.display())]
    #[diagnostic(help(
        "give another file with --write FILE.toml, or overwrite this one with --force"
    ))]
    Exists { path: PathBuf },
    #[error("the scene {} could not be written", path.display())]
    #[diagnostic(help("give a file that can be written to with --write FILE.toml"))]
    Unwritable { path: PathBuf, source: std::io::Error },
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
        /// The line and the column, counted from 1.
        place: Option<[usize; 2]>,
    },
    #[error("the results cannot be compared")]
    #[diagnostic(help("{}", .0.help()))]
    Compare(#[source] Box<CompareError>),
    #[error("the threads could not be started")]
    #[diagnostic(help("ask for fewer with --threads N"))]
    Threads(#[source] Box<dyn std::error::Error + Send + Sync>),
    #[error("the cells cannot be kept")]
    #[diagnostic(help("{}", .1))]
    Journal(#[source] Box<dyn std::error::Error + Send + Sync>, &'static str),
    #[error("the parts cannot be joined")]
    #[diagnostic(help("{}", .1))]
    Merge(#[source] Box<dyn std::error::Error + Send + Sync>, &'static str),
    #[error("{missing} of {} missing: {first}", counted(all, "cell"))]
    #[diagnostic(help(
        "run the shares that are missing, or those that stopped with --resume, and merge again"
    ))]
    Missing { missing: usize, all: usize, first: String },
    #[error("there is no share to compute: {name} is {found}")]
    #[diagnostic(help(
        "start the command in a job array, or give the share as --shard K/N with 1 ≤ K ≤ N"
    ))]
    NoShard { name: &'static str, found: String },
    #[error("interrupted before there was a result")]
    Interrupted,
    #[error("the study could not be run")]
    Study(#[source] Box<dyn std::error::Error + Send + Sync>),
}

/// A failure as JSON.
#[derive(Serialize)]
pub(crate) struct FailureJson {
    error: String,
    causes: Vec<String>,
    help: Option<String>,
    /// The line and the column in the scene, counted from 1.
    place: Option<[usize; 2]>,
    exit_code: u8,
}

impl FailureJson {
    /// A mistake on the command line. The text after the message explains the usage.
    pub(crate) fn usage(error: &clap::Error) -> Self {
        let text = error.render().to_string();
        let (message, help) = text.split_once("\n\n").unwrap_or((&text, ""));
        Self {
            error: message.trim_start_matches("error: ").trim().to_owned(),
            causes: Vec::new(),
            help: Some(help.trim().to_owned()),
            place: None,
            exit_code: USAGE,
        }
    }
}

/// The exit code of a command that has written its results, some of which may be failures.
pub(crate) fn code_of_results(failed: bool) -> ExitCode {
    interrupt::exit_code().unwrap_or(ExitCode::from(if failed { FAILED } else { 0 }))
}

impl Failure {
    /// The exit code. A signal takes precedence over the failure it caused.
    pub(crate) fn exit_code(&self) -> ExitCode {
        interrupt::exit_code().unwrap_or(ExitCode::from(self.code))
    }

    pub(crate) fn json(&self) -> FailureJson {
        let trouble = &*self.diagnostic;
        let causes = std::iter::successors(std::error::Error::source(trouble), |e| e.source());
        let place = if let Trouble::Scene { place, .. } = trouble { *place } else { None };
        FailureJson {
            error: trouble.to_string(),
            causes: causes.map(ToString::to_string).collect(),
            help: trouble.help().map(|help| help.to_string()),
            place,
            exit_code: self.code,
        }
    }

    /// Prints the message on stderr, and returns the exit code.
    pub(crate) fn tell(&self) -> ExitCode {
        let code = self.exit_code();
        let text =
            if let Trouble::Scene { text, .. } = &*self.diagnostic { Some(text) } else { None };
        let message = miette::Report::new(Printable::new(&*self.diagnostic, text));
        table::message(&format!("{message:?}"));
        code
    }

    fn new(trouble: Trouble, code: u8) -> Self {
        Self { diagnostic: Box::new(trouble), code }
    }

    pub(crate) fn storage(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::new(Trouble::Storage(in_one(&error)), STORAGE)
    }

    pub(crate) fn taken(folder: &Path, hash: &str) -> Self {
        let hash = hash.chars().take(12).collect();
        Self::new(Trouble::Taken { folder: folder.into(), hash }, STORAGE)
    }

    pub(crate) fn of_another(folder: &Path, command: String) -> Self {
        Self::new(Trouble::OfAnother { folder: folder.into(), command }, STORAGE)
    }

    pub(crate) fn compared(folder: &Path) -> Self {
        Self::new(Trouble::Compared { folder: folder.into() }, STORAGE)
    }

    pub(crate) fn exists(path: &Path) -> Self {
        Self::new(Trouble::Exists { path: path.into() }, STORAGE)
    }

    pub(crate) fn unwritable(path: &Path, source: std::io::Error) -> Self {
        Self::new(Trouble::Unwritable { path: path.into(), source }, STORAGE)
    }

    pub(crate) fn unreadable(path: &Path, source: std::io::Error) -> Self {
        Self::new(Trouble::Unreadable { path: path.into(), source }, SCENE)
    }

    /// A mistake in a scene, with its place in the text if the text is given.
    pub(crate) fn scene(path: &Path, text: &str, error: SceneError) -> Self {
        let span = clipped(text, error.span);
        let fits = around(text, &span).lines().all(|line| line.len() <= WIDEST);
        let mut message = error.problem.to_string();
        let place =
            (span != (0..0)).then(|| place_after(text.get(..span.start).unwrap_or_default()));
        if let Some([line, column]) = place.filter(|_| !fits) {
            message = format!("{}:{line}:{column}: {message}", path.display());
        }
        let text = if fits { text } else { "" };
        let diagnostic = Trouble::Scene {
            message,
            help: error.problem.help(),
            text: NamedSource::new(path.display().to_string(), text.to_owned()),
            span: (fits && span != (0..0)).then(|| SourceSpan::from(span)),
            place,
        };
        Self::new(diagnostic, SCENE)
    }

    pub(crate) fn study(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::new(Trouble::Study(Box::new(error)), FAILED)
    }

    /// Two results that cannot be compared.
    pub(crate) fn compare(error: CompareError) -> Self {
        Self::new(Trouble::Compare(Box::new(error)), SCENE)
    }

    /// Cells that cannot be kept or read.
    pub(crate) fn journal(error: JournalError) -> Self {
        Self::new(Trouble::Journal(in_one(&error), journal_help(&error)), STORAGE)
    }

    /// Parts that cannot be joined.
    pub(crate) fn merge(error: JournalError) -> Self {
        let code = match error {
            JournalError::File { .. } | JournalError::Busy { .. } => STORAGE,
            _ => SCENE,
        };
        Self::new(Trouble::Merge(in_one(&error), merge_help(&error)), code)
    }

    /// Parts that are not complete.
    pub(crate) fn missing(keys: &[&str], all: usize) -> Self {
        const SHOWN: usize = 10;
        let more = if keys.len() > SHOWN { ", …" } else { "" };
        let first = format!("{}{more}", keys[..keys.len().min(SHOWN)].join(", "));
        Self::new(Trouble::Missing { missing: keys.len(), all, first }, FAILED)
    }

    /// A share that the environment does not name.
    pub(crate) fn no_shard(name: &'static str, found: &str) -> Self {
        let found = if found.is_empty() { "not set".into() } else { found.into() };
        Self::new(Trouble::NoShard { name, found }, USAGE)
    }

    pub(crate) fn interrupted() -> Self {
        // The command's exit code is that of the signal.
        Self::new(Trouble::Interrupted, FAILED)
    }

    pub(crate) fn threads(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::new(Trouble::Threads(Box::new(error)), USAGE)
    }
}

/// The line and the column behind a text, counted from 1.
fn place_after(before: &str) -> [usize; 2] {
    let line = before.matches('\n').count() + 1;
    [line, before.rsplit('\n').next().unwrap_or_default().chars().count() + 1]
}

/// The longest line of a scene that is shown, in bytes.
const WIDEST: usize = 400;

/// The part of a span on its first line.
fn clipped(text: &str, span: Range<usize>) -> Range<usize> {
    let line = text.get(span.clone()).and_then(|part| part.find(['\r', '\n']));
    span.start..line.map_or(span.end, |length| span.start + length)
}

/// The lines a span is shown with: its own, and those before and after.
fn around<'a>(text: &'a str, span: &Range<usize>) -> &'a str {
    let before = text.get(..span.start).unwrap_or_default();
    let start = before.rmatch_indices('\n').nth(1).map_or(0, |(at, _)| at + 1);
    let after = text.get(span.end..).unwrap_or_default();
    let end = after.match_indices('\n').nth(1).map_or(text.len(), |(at, _)| span.end + at);
    text.get(start..end).unwrap_or_default()
}

impl From<Unprinted> for Failure {
    fn from(Unprinted(error): Unprinted) -> Self {
        Self::new(Trouble::Stdout(error), STORAGE)
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        match error {
            error if error.is_interrupted() => Self::interrupted(),
            ReportError::Storage(error) => Self::storage(error),
            ReportError::Study(error) => Self::study(error),
            ReportError::Map(error) => Self::study(error),
            ReportError::Journal(error) => Self::journal(error),
            error @ (ReportError::Method { .. } | ReportError::NoReference(_)) => {
                Self::study(error)
            }
        }
    }
}

impl From<JournalError> for Failure {
    fn from(error: JournalError) -> Self {
        Self::journal(error)
    }
}

/// An error whose message names its cause, without the cause: that would be printed twice.
fn in_one(error: &impl std::error::Error) -> Box<dyn std::error::Error + Send + Sync> {
    error.to_string().into()
}

/// The advice where parts cannot be joined.
fn merge_help(error: &JournalError) -> &'static str {
    match error {
        JournalError::File { .. } => "give a folder whose files can be read and written",
        JournalError::Busy { .. } => "wait until it ends, and merge again",
        JournalError::Foreign { .. } | JournalError::NoHeader { .. } => {
            "compute the shares anew: `afterbay run` or `study` with --force and without --shard \
             overwrites all parts of the folder"
        }
        JournalError::NoScene { .. } => "repeat a share with --resume, which writes the copy again",
        _ => journal_help(error),
    }
}

/// The advice on an error of a journal.
fn journal_help(error: &JournalError) -> &'static str {
    match error {
        JournalError::File { .. } | JournalError::Unwritten { .. } => {
            "give a folder that can be written to with --out DIR"
        }
        JournalError::Busy { .. } => "wait until it ends, or give another folder with --out DIR",
        JournalError::Unfinished { .. } => {
            "go on with --resume, or compute all cells again with --force"
        }
        JournalError::Foreign { .. } | JournalError::NoHeader { .. } => {
            "take a folder of one scene: give another with --out DIR, or overwrite all parts of \
             this one by `afterbay run` or `study` with --force and without --shard"
        }
        JournalError::Nothing { task: Task::Run, .. } => {
            "give the folder --out of `afterbay run --shard K/N`"
        }
        JournalError::Nothing { .. } | JournalError::NoScene { .. } => {
            "give the folder --out of `afterbay study --shard K/N` or `run --shard K/N`"
        }
        JournalError::Scene { .. } | JournalError::Unreadable { .. } => {
            "compute the study anew with --force"
        }
    }
}
