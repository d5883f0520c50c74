//! Files of results: tables, figures, the report and the manifest of a run.

mod files;
mod foreign;
mod held;
mod outcome;
mod removal;

pub use files::writable;
pub(crate) use files::{remove_abandoned, temporary};
pub use held::Held;
pub use outcome::{Alike, RunOutcome};
pub(crate) use removal::remove;

use crate::chart::Drawing;
use crate::data::{self, DataError, DataFormat};
use crate::report::Report;
use afterbay_analysis::rows::RowsFile;
use files::{write_by, write_whole};
use foreign::foreign;
use rayon::prelude::*;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The kinds of files that are written.
#[derive(Clone, Copy, Debug)]
pub struct Files {
    /// The format of tables.
    pub tables: DataFormat,
    /// Whether each chart is written as a PNG file too, beside the SVG.
    pub png: bool,
}

impl Default for Files {
    /// Tables as CSV, and PNG files.
    fn default() -> Self {
        Self { tables: DataFormat::Csv, png: true }
    }
}

/// A file of the output, named relative to its folder.
#[derive(Clone, Debug, Default)]
pub struct Artifact {
    /// `data/local_orders.csv`, `figures/figure-3-1.svg`, ...
    pub name: String,
    /// The contents; of a long table, their beginning.
    pub text: String,
    /// The other rows of a long table.
    pub rows: Vec<RowsFile>,
    /// The chart of an SVG file, from which the PNG file beside it is drawn.
    pub picture: Option<Drawing>,
}

impl Artifact {
    /// A table. Floats are printed as the shortest text that reads back the same; missing values
    /// are empty.
    ///
    /// # Errors
    /// [`StorageError::Table`] if a row cannot be serialized as CSV.
    pub fn table<R: Serialize>(name: impl Into<String>, rows: &[R]) -> Result<Self, StorageError> {
        Self::written(name, rows, csv::Writer::from_writer(Vec::new()))
    }

    /// A table whose number of columns depends on the number of degrees of freedom. Rows contain
    /// vectors, and the header names each entry.
    ///
    /// # Errors
    /// [`StorageError::Table`] if a row cannot be serialized as CSV or differs from the header in
    /// length.
    pub fn wide_table<R: Serialize>(
        name: impl Into<String>,
        header: &[String],
        rows: &[R],
    ) -> Result<Self, StorageError> {
        let name = name.into();
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        match writer.write_record(header) {
            Ok(()) => Self::written(name, rows, writer),
            Err(source) => Err(StorageError::Table { name, source }),
        }
    }

    fn written<R: Serialize>(
        name: impl Into<String>,
        rows: &[R],
        mut writer: csv::Writer<Vec<u8>>,
    ) -> Result<Self, StorageError> {
        let name = name.into();
        let write = || -> Result<String, csv::Error> {
            rows.iter().try_for_each(|row| writer.serialize(row))?;
            let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
            Ok(String::from_utf8_lossy(&bytes).into_owned())
        };
        match write() {
            Ok(text) => Ok(Self { name, text, ..Self::default() }),
            Err(source) => Err(StorageError::Table { name, source }),
        }
    }
}

impl Artifact {
    /// Reads the contents, whether or not they are in memory.
    ///
    /// # Errors
    /// A file of rows that cannot be opened.
    pub fn open(&self) -> io::Result<impl Read + '_> {
        let mut rows: Box<dyn Read + '_> = Box::new(io::empty());
        for more in &self.rows {
            rows = Box::new(rows.chain(more.open()?));
        }
        Ok(self.text.as_bytes().chain(rows))
    }
}

/// The origin of the output: the data that reproduce it, and the machine on which it was made.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// Version of afterbay.
    pub version: &'static str,
    /// The command.
    pub command: &'static str,
    /// The scene that was run, with defaults filled in.
    pub scene: serde_json::Value,
    /// SHA-256 of the scene.
    pub hash: String,
    /// The processor.
    pub cpu: String,
    /// The number of threads.
    pub threads: usize,
    /// The outcome of every run.
    pub runs: Vec<RunOutcome>,
}

impl Manifest {
    /// The manifest of `scene`, run by `command` on this machine.
    pub fn new(command: &'static str, scene: serde_json::Value, runs: Vec<RunOutcome>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            command,
            hash: hash_of(&scene),
            scene,
            cpu: processor(),
            threads: rayon::current_num_threads(),
            runs,
        }
    }
}

/// The contents of `run.json`.
#[derive(Serialize)]
struct Record<'a> {
    #[serde(flatten)]
    manifest: &'a Manifest,
    /// The figures of all commands on this scene, as they are removed with its results.
    figures: BTreeSet<String>,
}

/// SHA-256 of a scene.
pub(crate) fn hash_of(scene: &serde_json::Value) -> String {
    let hash = Sha256::digest(scene.to_string().as_bytes());
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The name of the processor where the operating system gives it, else its architecture.
pub fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told
        .lines()
        .find(|line| line.starts_with("model name"))
        .and_then(|line| line.split(": ").nth(1));
    name.unwrap_or(std::env::consts::ARCH).to_owned()
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
    #[error("cannot write the table {name}: {source}")]
    Table {
        /// The table.
        name: String,
        /// The cause.
        source: csv::Error,
    },
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
