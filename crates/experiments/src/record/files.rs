//! Files that get their names when they are complete.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Duration;

/// The prefix of the names of files that are not complete, and the number of letters and digits
/// that follow it.
const TEMPORARY: (&str, usize) = (".afterbay-", 6);
/// The age from which such a file belongs to a command that was killed. A command has each of them
/// for as long as it writes one file.
const ABANDONED: Duration = Duration::from_secs(600);

/// A file that gets its name when it is complete.
pub(crate) fn temporary(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let (prefix, random) = TEMPORARY;
    tempfile::Builder::new().prefix(prefix).rand_bytes(random).tempfile_in(folder)
}

/// Removes the temporary files of commands that were killed, as far as that is possible.
pub(crate) fn remove_abandoned(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let rest = name.to_str().and_then(|name| name.strip_prefix(TEMPORARY.0));
        let ours = rest.is_some_and(|rest| {
            rest.len() == TEMPORARY.1 && rest.bytes().all(|byte| byte.is_ascii_alphanumeric())
        }) && entry.file_type().is_ok_and(|kind| kind.is_file());
        let time = entry.metadata().and_then(|about| about.modified()).ok();
        let age = time.and_then(|time| time.elapsed().ok()).unwrap_or_default();
        if ours && age > ABANDONED {
            // A file that stays does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Checks that a file can be written, and leaves it as it is.
///
/// # Errors
/// A folder that is missing or closed, or a file that is closed or no file.
pub fn writable(path: &Path) -> io::Result<()> {
    if path.exists() {
        return File::options().append(true).open(path).map(drop);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let why = format!("there is no folder {}", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, why));
    }
    // The error of a temporary file names that file.
    temporary(folder).map(drop).map_err(|error| error.kind().into())
}

pub(super) fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    write_by(path, |file| file.write_all(contents))
}

/// Makes a file that gets its name when `write` has written it.
pub(super) fn write_by<T, E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<T, E>,
) -> Result<T, E> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let file = temporary(folder)?;
    let mut buffer = BufWriter::new(file.as_file());
    let written = write(&mut buffer)?;
    buffer.flush()?;
    drop(buffer);
    // Temporary files are private by default, but others must be able to read the results.
    #[cfg(unix)]
    file.as_file().set_permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644))?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::prepare;

    #[test]
    fn the_temporary_files_of_killed_commands_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let data = root.path().join("data");
        std::fs::create_dir(&data).unwrap();
        let old = std::time::SystemTime::now() - 2 * ABANDONED;
        let file = |name: &str, time| {
            let file = std::fs::File::create(data.join(name)).unwrap();
            file.set_modified(time).unwrap();
        };
        file(".afterbay-Ab4nDo", old);
        file(".afterbay-notes.md", old);
        file(".afterbay-AnOthr", std::time::SystemTime::now());
        file("notes.txt", old);
        prepare(root.path()).unwrap();
        let left = std::fs::read_dir(&data).unwrap().map(|entry| entry.unwrap().file_name());
        let mut left: Vec<_> = left.collect();
        left.sort();
        assert_eq!(left, [".afterbay-AnOthr", ".afterbay-notes.md", "notes.txt"]);
    }
}
