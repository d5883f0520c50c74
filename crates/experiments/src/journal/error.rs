//! The errors that prevent the use of a journal.

use crate::claim::counted;
use crate::scene::Task;
use afterbay_analysis::rows::RowsError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// An error that prevents the use of a journal.
#[derive(Debug, Error)]
pub enum JournalError {
    /// A file could not be read or written.
    #[error("cannot use {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// Another command uses the journal.
    #[error("another command is at work on these cells: {} is locked", path.display())]
    Busy {
        /// The locked file.
        path: PathBuf,
    },
    /// Some cells are finished and others are not.
    #[error("{} holds unfinished work: {done} of {} done", folder.display(), counted(all, "cell"))]
    Unfinished {
        /// The folder of the results.
        folder: PathBuf,
        /// The cells that are done.
        done: usize,
        /// All cells.
        all: usize,
    },
    /// A journal of another scene, command, machine or version.
    #[error("{} has another {what}: {theirs}, here {ours}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The entry of the header that differs.
        what: &'static str,
        /// The value of this command.
        ours: String,
        /// The value of the file.
        theirs: String,
    },
    /// A file does not begin as a journal does.
    #[error("{} is no journal of this version: {why}", path.display())]
    NoHeader {
        /// The file.
        path: PathBuf,
        /// The reason, in words.
        why: String,
    },
    /// There are no journals.
    #[error(
        "{} has no parts of a {}",
        folder.display(),
        if *task == Task::Run { "run" } else { "study or a run" }
    )]
    Nothing {
        /// The folder.
        folder: PathBuf,
        /// The command whose parts were asked for. Without a study, there may be a run.
        task: Task,
    },
    /// The copy of the scene beside the journals is missing.
    #[error("{} has no copy of the scene: its file NAME.toml is missing", parts.display())]
    NoScene {
        /// The folder of the journals.
        parts: PathBuf,
    },
    /// The scene of a journal cannot be read.
    #[error("the scene {} is not valid: {why}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// The reason, in words.
        why: String,
    },
    /// A result cannot be read.
    #[error("the result of the cell {key} cannot be read: {why}")]
    Unreadable {
        /// The cell.
        key: String,
        /// The reason, in words.
        why: String,
    },
    /// A header or a result cannot be serialized.
    #[error("a result cannot be written: {why}")]
    Unwritten {
        /// The reason, in words.
        why: String,
    },
}

impl From<RowsError> for JournalError {
    fn from(error: RowsError) -> Self {
        match error {
            RowsError::File { path, source } => Self::File { path, source },
            RowsError::Unwritten { why } => Self::Unwritten { why },
        }
    }
}

impl JournalError {
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }

    pub(crate) fn unwritten(why: impl ToString) -> Self {
        Self::Unwritten { why: why.to_string() }
    }
}
