//! The folder of the journals: its files, the scene and the locks.

use super::JournalError;
use crate::record::{remove_abandoned, temporary};
use crate::scene::Scene;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The files of a folder with an extension, by name.
pub(super) fn files(parts: &Path, extension: &str) -> Result<Vec<PathBuf>, JournalError> {
    let listed = std::fs::read_dir(parts).map_err(JournalError::file(parts))?;
    let mut paths = Vec::new();
    for entry in listed {
        let path = entry.map_err(JournalError::file(parts))?.path();
        if path.extension().is_some_and(|found| found == extension) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Removes all journals, rows and scenes of a folder, but not the locks.
pub(super) fn forget(parts: &Path) -> Result<(), JournalError> {
    for path in files(parts, "jsonl")? {
        // The journal of this command is open and locked: it is emptied instead.
        let emptied = OpenOptions::new().write(true).truncate(true).open(&path).map(drop);
        emptied.map_err(JournalError::file(&path))?;
    }
    remove(parts, "toml")?;
    remove(parts, "rows")
}

/// Removes the files of a folder with an extension.
pub(super) fn remove(parts: &Path, extension: &str) -> Result<(), JournalError> {
    for path in files(parts, extension)? {
        std::fs::remove_file(&path).map_err(JournalError::file(&path))?;
    }
    Ok(())
}

/// Stores the scene with all files it names, for a merge.
pub(super) fn keep_scene(parts: &Path, scene: &Scene) -> Result<(), JournalError> {
    // A scene without a title is called by its file.
    let file = scene.title.as_deref().filter(|_| scene.document.title.is_none());
    let name = file.unwrap_or("scene").replace(['/', '\\'], "-");
    let path = parts.join(format!("{name}.toml"));
    remove_abandoned(parts);
    if path.exists() {
        return Ok(());
    }
    let text = scene.text().map_err(JournalError::unwritten)?;
    let mut file = temporary(parts).map_err(JournalError::file(&path))?;
    file.write_all(text.as_bytes()).map_err(JournalError::file(&path))?;
    file.persist(&path).map_err(|error| JournalError::File { path, source: error.error })?;
    Ok(())
}

/// The scene of a folder; none if it has none.
pub(super) fn kept_scene(parts: &Path) -> Result<Option<Scene>, JournalError> {
    let Some(path) = files(parts, "toml")?.into_iter().next() else { return Ok(None) };
    let text = std::fs::read_to_string(&path).map_err(JournalError::file(&path))?;
    let mut scene = Scene::read_in(parts, &text).map_err(|error| JournalError::Scene {
        path: path.clone(),
        why: error.problem.to_string(),
    })?;
    scene.call_by(&path);
    Ok(Some(scene))
}

/// Locks a folder of journals: shards share it, all others have it alone.
pub(super) fn lock(parts: &Path, shared: bool) -> Result<File, JournalError> {
    let path = parts.join("lock");
    let open = OpenOptions::new().write(true).create(true).truncate(false).open(&path);
    let file = open.map_err(JournalError::file(&path))?;
    held(&file, shared, &path)?;
    Ok(file)
}

/// Locks a file until it is closed. File systems without locks go without.
pub(super) fn held(file: &File, shared: bool, path: &Path) -> Result<(), JournalError> {
    match if shared { file.try_lock_shared() } else { file.try_lock() } {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(JournalError::Busy { path: path.into() }),
        Err(TryLockError::Error(error)) if error.kind() == std::io::ErrorKind::Unsupported => {
            Ok(())
        }
        Err(TryLockError::Error(source)) => Err(JournalError::File { path: path.into(), source }),
    }
}
