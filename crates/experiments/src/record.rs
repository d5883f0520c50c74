//! Files of results: tables, figures, the report and the manifest of a run.

mod files;
mod foreign;
mod held;
mod removal;

pub use files::writable;
pub(crate) use files::{remove_abandoned, temporary};
pub use held::Held;
pub(crate) use removal::remove;

use crate::artifact::{Artifact, TableError};
use crate::data::{self, DataError, DataFormat, Files};
use crate::manifest::Manifest;
use crate::report::Report;
use files::{write_by, write_whole};
use foreign::foreign;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The contents of `run.json`.
#[derive(Serialize)]
struct Record<'a> {
    #[serde(flatten)]
    manifest: &'a Manifest,
    /// The figures of all commands on this scene, as they are removed with its results.
    figures: BTreeSet<String>,
}

/// All results of a command.
#[derive(Clone, Debug)]
pub struct Output {
    /// The report.
    pub report: Report,
    /// Tables and figures.
    pub artifacts: Vec<Artifact>,
    /// The origin of the results.
    pub manifest: Manifest,
}

/// Makes the folder of the results and checks that they can be written there. Call it before
/// computing.
///
/// # Errors
/// [`StorageError::File`] with the folder or file that cannot be written, and
/// [`StorageError::Foreign`] with a file that results could replace, without a record of afterbay.
pub fn prepare(folder: &Path) -> Result<(), StorageError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| StorageError::File { path, source }
    };
    let made = std::fs::create_dir_all(folder).map_err(|error| {
        let why = match folder.symlink_metadata() {
            Ok(found) if found.is_symlink() && !folder.exists() => "it is a link to nothing",
            Ok(_) if !folder.is_dir() => "it is a file, not a folder",
            _ => return error,
        };
        io::Error::new(error.kind(), why)
    });
    made.map_err(failed(folder))?;
    for below in ["", "data", "figures"] {
        let path = folder.join(below);
        if below.is_empty() || path.symlink_metadata().is_ok() {
            temporary(&path).map(drop).map_err(failed(&path))?;
            remove_abandoned(&path);
        }
    }
    for name in ["run.json", "report.html"] {
        let path = folder.join(name);
        if path.is_dir() {
            return Err(failed(&path)(std::io::ErrorKind::IsADirectory.into()));
        }
    }
    foreign(folder).map_or(Ok(()), |path| Err(StorageError::Foreign { path }))
}

impl Output {
    /// Writes all results below `folder`. Each file gets its name only when it is complete. The
    /// record comes first, so that a command that was killed here can be repeated, and the report
    /// last.
    ///
    /// # Errors
    /// [`StorageError`] with the file that could not be written.
    pub fn write(&self, folder: &Path, files: Files) -> Result<(), StorageError> {
        let record = Record { manifest: &self.manifest, figures: self.figures(folder) };
        let record = serde_json::to_string_pretty(&record)
            .map_err(|source| StorageError::Manifest { source })?;
        let put = |name: &str, contents: &[u8]| {
            let path = folder.join(name);
            write_whole(&path, contents).map_err(|source| StorageError::File { path, source })
        };
        put("run.json", record.as_bytes())?;
        self.artifacts.par_iter().try_for_each(|artifact| {
            if let Some(table) = artifact.name.strip_suffix(".csv") {
                return self.write_table((table, artifact), files.tables, folder);
            }
            put(&artifact.name, artifact.text.as_bytes())?;
            let Some(picture) = artifact.picture.as_ref().filter(|_| files.png) else {
                return Ok(());
            };
            let name = Path::new(&artifact.name).with_extension("png");
            let png =
                picture.png().map_err(|why| StorageError::Picture { path: name.clone(), why });
            put(&name.to_string_lossy(), &png?)
        })?;
        put("report.html", self.report.html(files).as_bytes())?;
        self.remove_others(folder, files)
    }

    /// The figures of this command, and those of others on the same scene in the folder.
    fn figures(&self, folder: &Path) -> BTreeSet<String> {
        let held = Held::read(folder).filter(|held| held.hash == self.manifest.hash);
        let others = held.map(|held| held.figures).unwrap_or_default();
        let own = self.artifacts.iter().map(|x| x.name.clone());
        let own = own.filter(|name| name.starts_with("figures/"));
        others.into_iter().chain(own).collect()
    }

    /// Writes a table and its sidecar.
    fn write_table(
        &self,
        (name, table): (&str, &Artifact),
        format: DataFormat,
        folder: &Path,
    ) -> Result<(), StorageError> {
        let file = format!("{name}.{}", format.extension());
        let failed = |source| StorageError::Translation { name: file.clone(), source };
        let write = |to: &mut BufWriter<&File>| data::write(table, format, &self.manifest, to);
        let sidecar = write_by(&folder.join(&file), write).map_err(failed)?;
        let sidecar = serde_json::to_vec_pretty(&sidecar).map_err(|why| failed(why.into()))?;
        let path = folder.join(format!("{name}.json"));
        write_whole(&path, &sidecar).map_err(|source| StorageError::File { path, source })
    }

    /// Removes tables that an earlier command wrote under the same names in another format and, if
    /// no PNG files are written now, the PNG files of these charts.
    fn remove_others(&self, folder: &Path, files: Files) -> Result<(), StorageError> {
        let tables = self.artifacts.iter().filter_map(|x| x.name.strip_suffix(".csv"));
        let others = DataFormat::ALL.into_iter().filter(|other| *other != files.tables);
        let old = tables.flat_map(|table| {
            others.clone().map(move |other| folder.join(format!("{table}.{}", other.extension())))
        });
        let charts = self.artifacts.iter().filter(|x| !files.png && x.picture.is_some());
        let pictures = charts.map(|x| folder.join(&x.name).with_extension("png"));
        for path in old.chain(pictures).filter(|path| path.is_file()) {
            std::fs::remove_file(&path).map_err(|source| StorageError::File { path, source })?;
        }
        Ok(())
    }
}

/// A failure to write results.
#[derive(Debug, Error)]
pub enum StorageError {
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file has the name or the kind of a result, and there is no record of afterbay beside it.
    #[error(
        "{} is not overwritten, as {}: move it",
        path.display(),
        if path.ends_with("run.json") { "it is no record of afterbay" }
        else { "no run.json beside it says that afterbay wrote it" }
    )]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// A chart could not be drawn as a PNG picture.
    #[error("cannot draw {}: {why}", path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// The reason, in words.
        why: String,
    },
    /// A row could not be serialized as CSV.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A table could not be translated to its format.
    #[error("cannot write the table {name}: {source}")]
    Translation {
        /// The file.
        name: String,
        /// The cause.
        source: DataError,
    },
    /// The manifest could not be serialized as JSON.
    #[error("cannot write run.json: {source}")]
    Manifest {
        /// The cause.
        source: serde_json::Error,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(folder: &Path) -> PathBuf {
        match prepare(folder) {
            Err(StorageError::File { path, .. } | StorageError::Foreign { path }) => path,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_cannot_be_written_is_found_beforehand() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("deep/er");
        prepare(&folder).unwrap();
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "nothing is left behind");
        let file = |name: &str| {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, "a file").unwrap();
            path
        };
        assert_eq!(refused(&file("occupied")), root.path().join("occupied"));
        for name in ["data", "figures"] {
            let path = file(&format!("with-{name}/{name}"));
            assert_eq!(refused(path.parent().unwrap()), path);
        }
        for name in ["run.json", "report.html"] {
            let path = root.path().join(format!("with-{name}")).join(name);
            std::fs::create_dir_all(&path).unwrap();
            assert_eq!(refused(path.parent().unwrap()), path);
        }
        for name in ["run.json", "report.html"] {
            let path = file(&format!("with-another-{name}/{name}"));
            assert_eq!(refused(path.parent().unwrap()), path);
            assert_eq!(std::fs::read_to_string(path).unwrap(), "a file");
        }
    }
}
