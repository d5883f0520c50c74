//! The scene that a folder belongs to by its results and its journals, and how another scene takes
//! the folder over.

use super::folder::{files, forget, held, lock};
use super::{Header, JournalError, PARTS};
use crate::record::{Held, StorageError, remove};
use std::fs::File;
use std::path::{Path, PathBuf};

/// The hash of another scene than `hash` that has results or journals in a folder.
pub fn other_scene(folder: &Path, hash: &str) -> Option<String> {
    let results = Held::read(folder).map(|held| held.hash);
    let journals = PARTS.iter().flat_map(|name| scenes(&folder.join(name)));
    results.into_iter().chain(journals).find(|scene| scene != hash)
}

/// Removes the results and the journals of other scenes in a folder, for a command that has no
/// journal.
///
/// # Errors
/// [`JournalError`] where a command is at work, or files cannot be removed.
pub fn take_over(folder: &Path, hash: &str) -> Result<(), JournalError> {
    if other_scene(folder, hash).is_none() {
        return Ok(());
    }
    for parts in PARTS.map(|name| folder.join(name)).iter().filter(|parts| parts.is_dir()) {
        let _lock = lock(parts, false)?;
        forget_others(parts, hash)?;
    }
    remove_others(folder, hash)
}

/// The journals of the other command in a folder. Their lock is held as long as the folder is used.
#[derive(Debug)]
pub(super) struct Beside {
    parts: PathBuf,
    shared: bool,
    lock: File,
}

impl Beside {
    /// Locks the journals, if there are any: shards share them, all others have them alone.
    pub(super) fn lock(parts: PathBuf, shared: bool) -> Result<Option<Self>, JournalError> {
        if !parts.is_dir() {
            return Ok(None);
        }
        lock(&parts, shared).map(|lock| Some(Self { parts, shared, lock }))
    }

    /// Removes the journals of other scenes, which nobody else may use meanwhile.
    pub(super) fn forget_others(&self, hash: &str) -> Result<(), JournalError> {
        if scenes(&self.parts).iter().all(|scene| scene == hash) {
            return Ok(());
        }
        held(&self.lock, false, &self.parts)?;
        forget_others(&self.parts, hash)?;
        held(&self.lock, self.shared, &self.parts)
    }
}

/// Removes the results of another scene.
pub(super) fn remove_others(folder: &Path, hash: &str) -> Result<(), JournalError> {
    if Held::read(folder).is_none_or(|held| held.hash == hash) {
        return Ok(());
    }
    remove(folder).map_err(|error| match error {
        StorageError::File { path, source } => JournalError::File { path, source },
        other => JournalError::unwritten(other),
    })
}

fn forget_others(parts: &Path, hash: &str) -> Result<(), JournalError> {
    if scenes(parts).iter().any(|scene| scene != hash) { forget(parts) } else { Ok(()) }
}

/// The hashes of the scenes of journals. Journals without a header have no cells.
fn scenes(parts: &Path) -> Vec<String> {
    let journals = files(parts, "jsonl").unwrap_or_default();
    journals.iter().filter_map(|path| Header::read(path)).map(|header| header.scene).collect()
}
