//! The rows of a long table while they are computed: whole blocks in a file beside the journal, and
//! less than a block in memory and in the lines of the journal.

use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The bytes of a block. A choice: what a checkpoint writes is small, and so is the number of
/// blocks.
const BLOCK: usize = 1 << 16;

/// The folder of the files of rows, and the command that writes them. A command reads the rows of
/// all commands in the folder, and writes only files with its prefix.
#[derive(Debug)]
pub struct Shelf {
    folder: PathBuf,
    /// The start of the names of its own files.
    prefix: String,
}

impl Shelf {
    /// The files in a folder whose names begin with `prefix` are those of this command.
    pub fn new(folder: &Path, prefix: &str) -> Self {
        Self { folder: folder.into(), prefix: prefix.into() }
    }

    /// The name of the file for the rows of a run.
    fn name(&self, run: &str) -> String {
        format!("{}{run}.rows", self.prefix)
    }
}

/// An error in keeping the rows of a table.
#[derive(Debug, Error)]
pub enum RowsError {
    /// A file could not be read or written.
    #[error("cannot use {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A row cannot be written as CSV.
    #[error("a result cannot be written: {why}")]
    Unwritten {
        /// The reason, in words.
        why: String,
    },
}

impl RowsError {
    fn file(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }

    fn unwritten(why: impl ToString) -> Self {
        Self::Unwritten { why: why.to_string() }
    }
}

/// The rows of a table in CSV, without a header.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    /// Their number.
    pub count: u64,
    /// The first of them, in a file.
    stored: Option<Stored>,
    /// The others.
    held: String,
}

/// The valid part of a file. The rest was written after the last line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Stored {
    name: String,
    bytes: u64,
    checksum: Checksum,
}

/// A checksum of all bytes so far (FNV-1a with 64 bits, of Fowler, Noll and Vo).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Checksum(u64);

impl Checksum {
    const START: Self = Self(0xcbf2_9ce4_8422_2325);
    const PRIME: u64 = 0x100_0000_01b3;

    fn and(self, bytes: &[u8]) -> Self {
        Self(
            bytes
                .iter()
                .fold(self.0, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(Self::PRIME)),
        )
    }
}

impl Rows {
    /// All rows, if none of them is in a file.
    pub fn text(&self) -> Option<&str> {
        self.stored.is_none().then_some(&*self.held)
    }

    /// The rows, to be read from the file on the shelf and from memory.
    pub fn located(self, shelf: Option<&Shelf>) -> RowsFile {
        let folder = shelf.map_or(Path::new(""), |shelf| &shelf.folder);
        let stored = self.stored.map(|stored| {
            let Stored { name, bytes, checksum } = stored;
            (folder.join(name), bytes, checksum)
        });
        RowsFile { stored, held: self.held }
    }
}

/// Rows that are read from a file and from memory.
#[derive(Clone, Debug)]
pub struct RowsFile {
    stored: Option<(PathBuf, u64, Checksum)>,
    held: String,
}

impl RowsFile {
    /// Reads all rows. A file that was changed is an error at its end.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn open(&self) -> io::Result<impl Read + '_> {
        let stored: Box<dyn Read> = match &self.stored {
            None => Box::new(io::empty()),
            Some((path, bytes, checksum)) => {
                let told = |why: io::Error| {
                    io::Error::new(why.kind(), format!("{}: {why}", path.display()))
                };
                let file = File::open(path).map_err(told)?;
                let file = BufReader::with_capacity(BLOCK, file).take(*bytes);
                let sum = Checksum::START;
                Box::new(Checked { file, path, sum, expected: *checksum })
            }
        };
        Ok(stored.chain(self.held.as_bytes()))
    }
}

/// Reads a file and compares its checksum at the end.
struct Checked<'a> {
    file: io::Take<BufReader<File>>,
    path: &'a Path,
    sum: Checksum,
    expected: Checksum,
}

impl Read for Checked<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(into)?;
        self.sum = self.sum.and(&into[..count]);
        if count == 0 && !into.is_empty() && self.sum != self.expected {
            let why = format!("{} was changed; compute it anew with --force", self.path.display());
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        Ok(count)
    }
}

/// Appends rows, and writes a block to the file when it is full.
pub struct RowWriter {
    rows: csv::Writer<Vec<u8>>,
    count: u64,
    stored: Option<Stored>,
    file: Option<File>,
    /// The path of the file; none if all rows stay in memory.
    path: Option<PathBuf>,
    failure: Option<RowsError>,
}

impl RowWriter {
    /// Goes on behind rows. Without a shelf, all rows stay in memory.
    ///
    /// # Errors
    /// A file that cannot be written, or lacks some of the rows.
    pub fn after(rows: Rows, run: &str, shelf: Option<&Shelf>) -> Result<Self, RowsError> {
        let Rows { count, mut stored, held } = rows;
        let name = shelf.map(|shelf| shelf.name(run)).unwrap_or_default();
        let path = shelf.map(|shelf| shelf.folder.join(&name));
        let mut file = None;
        if let (Some(stored), Some(shelf), Some(path)) = (&mut stored, shelf, &path) {
            let found = reopened(stored, &name, path, &shelf.folder);
            file = Some(found.map_err(RowsError::file(path))?);
        }
        let rows = writer(held.into_bytes());
        Ok(Self { rows, count, stored, file, path, failure: None })
    }

    /// Appends a row. Breaks once it could not be written.
    pub fn push<R: Serialize>(&mut self, row: &R) -> ControlFlow<()> {
        if self.failure.is_some() {
            return ControlFlow::Break(());
        }
        match self.append(row) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.failure = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    fn append<R: Serialize>(&mut self, row: &R) -> Result<(), RowsError> {
        self.rows.serialize(row).map_err(RowsError::unwritten)?;
        self.count += 1;
        self.rows.flush().map_err(RowsError::unwritten)?;
        if self.rows.get_ref().len() < BLOCK {
            return Ok(());
        }
        let Some(path) = &self.path else { return Ok(()) };
        let failed = RowsError::file(path);
        self.store().map_err(failed)
    }

    /// Moves the rows in memory to the file.
    fn store(&mut self) -> io::Result<()> {
        let Some(path) = &self.path else { return Ok(()) };
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(File::create(path)?),
        };
        let block = self.rows.get_ref();
        file.write_all(block)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let stored =
            self.stored.get_or_insert(Stored { name, bytes: 0, checksum: Checksum::START });
        stored.bytes += block.len() as u64;
        stored.checksum = stored.checksum.and(block);
        self.rows = writer(Vec::with_capacity(2 * BLOCK));
        Ok(())
    }

    /// The rows so far.
    ///
    /// # Errors
    /// The failure of the first row that could not be written.
    pub fn finish(self) -> Result<Rows, RowsError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        let held = self.rows.into_inner().map_err(RowsError::unwritten)?;
        let held = String::from_utf8(held).map_err(RowsError::unwritten)?;
        Ok(Rows { count: self.count, stored: self.stored, held })
    }
}

/// Appends rows in CSV to a text.
fn writer(text: Vec<u8>) -> csv::Writer<Vec<u8>> {
    csv::WriterBuilder::new().has_headers(false).from_writer(text)
}

/// Opens the file of a command behind the rows that count. Those of another command are copied.
fn reopened(stored: &mut Stored, name: &str, path: &Path, folder: &Path) -> io::Result<File> {
    let theirs = folder.join(&stored.name);
    let found = std::fs::metadata(&theirs)?.len();
    if found < stored.bytes {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    if stored.name != name {
        let mut file = File::create(path)?;
        io::copy(&mut File::open(theirs)?.take(stored.bytes), &mut file)?;
        name.clone_into(&mut stored.name);
        return Ok(file);
    }
    let mut file = OpenOptions::new().write(true).open(path)?;
    file.set_len(stored.bytes)?;
    file.seek(SeekFrom::End(0))?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(rows: &RowsFile) -> io::Result<String> {
        let mut text = String::new();
        rows.open()?.read_to_string(&mut text)?;
        Ok(text)
    }

    /// The rows from one number up to another, appended to those before them.
    fn more(rows: Rows, numbers: std::ops::Range<u64>, shelf: Option<&Shelf>) -> Rows {
        let mut writer = RowWriter::after(rows, "moddg", shelf).expect("a file");
        for n in numbers {
            assert!(writer.push(&("moddg", n, n as f64 / 7.0)).is_continue());
            let held = writer.rows.get_ref().len();
            assert!(shelf.is_none() || held < BLOCK, "{held} bytes are held after {n} rows");
        }
        writer.finish().expect("rows")
    }

    #[test]
    fn rows_of_any_number_hold_less_than_a_block() {
        let folder = tempfile::tempdir().expect("a folder");
        let shelf = Shelf::new(folder.path(), "1-of-1.");
        let rows = more(Rows::default(), 0..200_000, Some(&shelf));
        assert_eq!((rows.count, rows.text()), (200_000, None));
        assert!(rows.held.len() < BLOCK);
        let alone = more(Rows::default(), 0..200_000, None);
        let (found, whole) = (text(&rows.located(Some(&shelf))), alone.text().expect("no file"));
        assert!(whole.len() > 60 * BLOCK);
        assert!(found.expect("text") == whole, "the rows differ");
    }

    #[test]
    fn what_was_written_after_the_last_checkpoint_is_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        let [first, second] = ["1-of-2.", "2-of-2."].map(|name| Shelf::new(folder.path(), name));
        let kept = more(Rows::default(), 0..10_000, Some(&first));
        let lost = more(kept.clone(), 50_000..70_000, Some(&first));
        assert!(lost.stored.as_ref().map(|x| x.bytes) > kept.stored.as_ref().map(|x| x.bytes));
        let expected = more(Rows::default(), 0..20_000, None).held;
        // Another command goes on with a copy, and leaves the file as it is.
        for shelf in [&second, &first] {
            let resumed = more(kept.clone(), 10_000..20_000, Some(shelf));
            assert!(text(&resumed.located(Some(shelf))).expect("text") == expected);
            if std::ptr::eq(shelf, &second) {
                assert_eq!(
                    text(&lost.clone().located(Some(&first))).expect("rows").lines().count(),
                    30_000
                );
            }
        }
    }

    #[test]
    fn rows_that_were_changed_or_cut_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let shelf = Shelf::new(folder.path(), "");
        let rows = more(Rows::default(), 0..10_000, Some(&shelf));
        let path = folder.path().join("moddg.rows");
        let whole = std::fs::read(&path).expect("a file");
        let mut changed = whole.clone();
        changed[70_000] ^= 1;
        for bytes in [&changed, &whole[..whole.len() - 1].to_vec()] {
            std::fs::write(&path, bytes).expect("a file");
            let error = text(&rows.clone().located(Some(&shelf))).expect_err("an error");
            assert!(error.to_string().contains("moddg.rows was changed"), "{error}");
        }
        assert!(RowWriter::after(rows.clone(), "moddg", Some(&shelf)).is_err());
        std::fs::remove_file(&path).expect("it is removed");
        assert!(text(&rows.located(Some(&shelf))).is_err());
    }
}
