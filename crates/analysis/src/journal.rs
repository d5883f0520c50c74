//! The journal of a command: its finished cells, so that work goes on where it stopped and several
//! commands share one study.
//!
//! Each command appends to its own file `parts/K-of-N.jsonl` below the folder of the results. The
//! first line is the [`Header`]. Each further line is a finished cell, its result in CBOR and
//! base64, with a checksum. A line is written at once, so that a command that is killed loses at
//! most the cells under way: what follows the last whole line is dropped. Long cells have lines of
//! their own now and then, from which they go on; the last counts. Files are locked while a command
//! uses them.

use crate::experiment::{Ledger, Task, under_way};
use crate::record::{remove_abandoned, temporary};
use crate::scene::Scene;
use crate::study::cell::Cell;
use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD as BASE64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{HashMap, HashSet};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use thiserror::Error;

/// The version of the format.
const SCHEMA: u32 = 2;
/// The folders of the journals of studies and of runs, below that of the results.
const PARTS: [&str; 2] = ["parts", "parts-of-run"];
/// The bytes of a checksum.
const CHECKSUM: usize = 8;

/// One of several commands that share a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, counted from 1.
    pub number: usize,
    /// The number of all.
    pub count: usize,
}

impl Shard {
    /// A command that computes a study alone.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// Its cells: the plan in order of falling cost, dealt out one by one.
    pub fn cells(self, plan: &[Cell]) -> impl Iterator<Item = &Cell> {
        let mut order: Vec<&Cell> = plan.iter().collect();
        order.sort_by(|a, b| b.cost.total_cmp(&a.cost));
        order.into_iter().skip(self.number - 1).step_by(self.count)
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const WRONG: &str = "a shard is K/N with 1 ≤ K ≤ N, such as 3/8";
        let (number, count) = text.split_once('/').ok_or(WRONG)?;
        match (number.parse(), count.parse()) {
            (Ok(number), Ok(count)) if 1 <= number && number <= count => Ok(Self { number, count }),
            _ => Err(WRONG),
        }
    }
}

/// What results must have in common to be joined.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The version of the format.
    pub journal: u32,
    /// The version of afterbay.
    pub version: String,
    /// The command.
    pub task: Task,
    /// SHA-256 of the scene.
    pub scene: String,
    /// The architecture and the operating system.
    pub target: String,
    /// The features of the processor that the program is built for. The last digits of results may
    /// depend on them.
    pub features: String,
}

impl Header {
    /// The header of a task on a scene.
    pub fn new(task: Task, hash: &str) -> Self {
        let features = [
            ("avx2", cfg!(target_feature = "avx2")),
            ("fma", cfg!(target_feature = "fma")),
            ("avx512f", cfg!(target_feature = "avx512f")),
            ("neon", cfg!(target_feature = "neon")),
        ];
        let has = features.iter().filter(|feature| feature.1).map(|feature| feature.0);
        Self {
            journal: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            task,
            scene: hash.into(),
            target: format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
            features: has.collect::<Vec<_>>().join(" "),
        }
    }

    /// What differs from another header, and how: both values.
    fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let pairs = [
            ("format of journals", self.journal.to_string(), other.journal.to_string()),
            ("version of afterbay", self.version.clone(), other.version.clone()),
            ("command", self.task.name().into(), other.task.name().into()),
            ("scene", self.scene.clone(), other.scene.clone()),
            ("machine", self.target.clone(), other.target.clone()),
            ("features of the processor", self.features.clone(), other.features.clone()),
        ];
        pairs.into_iter().find(|(_, ours, theirs)| ours != theirs)
    }
}

/// A finished cell.
#[derive(Serialize, Deserialize)]
struct Line {
    key: String,
    /// The time that the cell took, for those who plan the next study.
    seconds: f64,
    checksum: String,
    result: String,
}

impl Line {
    fn new(key: &str, result: &[u8], time: Duration) -> Self {
        let (checksum, result) = (checksum(key, result), BASE64.encode(result));
        Self { key: key.into(), seconds: time.as_secs_f64(), checksum, result }
    }

    /// The key and the result, if the line is whole.
    fn read(text: &str) -> Option<(String, Vec<u8>)> {
        let Self { key, checksum: claimed, result, .. } = serde_json::from_str(text).ok()?;
        let result = BASE64.decode(result).ok()?;
        (checksum(&key, &result) == claimed).then_some((key, result))
    }
}

fn checksum(key: &str, result: &[u8]) -> String {
    let digest = Sha256::new().chain_update(key).chain_update([0]).chain_update(result).finalize();
    digest[..CHECKSUM].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The content of a journal file.
struct Content {
    header: Option<Header>,
    cells: Vec<(String, Vec<u8>)>,
    /// The bytes up to the end of the last whole line.
    length: u64,
    /// Lines that are not whole.
    damaged: usize,
}

impl Content {
    fn read(path: &Path) -> Result<Self, JournalError> {
        let bytes = std::fs::read(path).map_err(JournalError::file(path))?;
        let length = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let text = String::from_utf8_lossy(&bytes[..length]);
        let mut lines = text.lines();
        let Some(first) = lines.next() else {
            let damaged = usize::from(!bytes.is_empty());
            return Ok(Self { header: None, cells: Vec::new(), length: 0, damaged });
        };
        let header = serde_json::from_str(first)
            .map_err(|why| JournalError::NoHeader { path: path.into(), why: why.to_string() })?;
        let lines: Vec<&str> = lines.collect();
        let read: Vec<_> = lines.par_iter().map(|line| Line::read(line)).collect();
        let torn = usize::from(length < bytes.len());
        let damaged = torn + read.iter().filter(|line| line.is_none()).count();
        let cells = read.into_iter().flatten().collect();
        Ok(Self { header: Some(header), cells, length: length as u64, damaged })
    }
}

/// How a command treats the cells that are in the journals of its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// It refuses to begin if some of its cells are finished and others are not.
    Fresh,
    /// It computes the cells that are missing.
    Resume,
    /// It forgets the cells that are there.
    Force,
}

/// The journal of a command, and the cells found in all journals of its folder.
#[derive(Debug)]
pub struct Journal {
    /// The file of this command; none for a merge, which computes nothing.
    file: Option<(PathBuf, Mutex<File>)>,
    found: HashMap<String, Vec<u8>>,
    /// The cells of this command.
    own: HashSet<String>,
    /// The number of own cells that are taken from journals.
    pub reused: usize,
    /// Lines that were not whole. Their cells are computed again.
    pub damaged: usize,
    /// Whether cells come from processors with different features.
    pub mixed: bool,
    /// Held as long as the folder is used.
    _lock: File,
}

impl Journal {
    /// Opens the journal of a command that computes the cells of `shard`.
    ///
    /// # Errors
    /// [`JournalError`] for a file that cannot be written, another command on the same cells, results
    /// of another scene or version, and an unfinished study if `start` is [`Start::Fresh`].
    pub fn open(
        folder: &Path,
        (task, scene): (Task, &Scene),
        (plan, shard): (&[Cell], Shard),
        start: Start,
    ) -> Result<Self, JournalError> {
        let parts = folder.join(PARTS[usize::from(task == Task::Run)]);
        std::fs::create_dir_all(&parts).map_err(JournalError::file(&parts))?;
        let whole = shard == Shard::WHOLE;
        let lock = lock(&parts, !whole)?;
        let path = parts.join(format!("{}-of-{}.jsonl", shard.number, shard.count));
        let open =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = open.map_err(JournalError::file(&path))?;
        held(&file, false, &path)?;
        if whole && start == Start::Force {
            forget(&parts)?;
        }
        let header = Header::new(task, &scene.hash());
        let own: HashSet<String> = shard.cells(plan).map(|cell| cell.key.clone()).collect();
        let mut found = Found::default();
        if start != Start::Force {
            found.read(&parts, &header)?;
        }
        let done = own.iter().filter(|key| found.cells.contains_key(*key)).count();
        let mut begin = start == Start::Force;
        let begun = found.cells.keys().any(|key| under_way(key).is_some_and(|of| own.contains(of)));
        if start == Start::Fresh && (done > 0 || begun) {
            if done < own.len() {
                let folder = folder.to_owned();
                return Err(JournalError::Unfinished { folder, done, all: own.len() });
            }
            // A finished study is computed anew.
            begin = true;
            if whole {
                forget(&parts)?;
            }
            found.cells.retain(|key, _| !own.contains(under_way(key).unwrap_or(key)));
        }
        let length = if begin { 0 } else { found.lengths.get(&path).copied().unwrap_or(0) };
        let placed = file.set_len(length).and_then(|()| file.seek(SeekFrom::Start(length)));
        placed.map_err(JournalError::file(&path))?;
        if length == 0 {
            let line = serde_json::to_string(&header).map_err(JournalError::unwritten)?;
            writeln!(file, "{line}").map_err(JournalError::file(&path))?;
        }
        keep_scene(&parts, scene)?;
        let Found { cells: found, damaged, mixed, .. } = found;
        let reused = if begin { 0 } else { done };
        let file = Some((path, Mutex::new(file)));
        Ok(Self { file, found, own, reused, damaged, mixed, _lock: lock })
    }

    /// Opens the journals of all shards of a folder, to join their cells. Also returns the command
    /// and the scene. A folder without studies is asked for runs.
    ///
    /// # Errors
    /// [`JournalError`] where there is nothing to join, a command still runs, or journals belong to
    /// different scenes or versions.
    pub fn join(folder: &Path, task: Task) -> Result<(Self, Task, Scene), JournalError> {
        let nothing = || JournalError::Nothing { folder: folder.into() };
        let [study, run] = PARTS.map(|name| folder.join(name));
        let parts = if task == Task::Run || !study.is_dir() { run } else { study };
        if !parts.is_dir() {
            return Err(nothing());
        }
        let lock = lock(&parts, false)?;
        let scene = kept_scene(&parts)?.ok_or_else(nothing)?;
        let first = files(&parts, "jsonl")?.into_iter().next().ok_or_else(nothing)?;
        let header = Content::read(&first)?.header.ok_or_else(nothing)?;
        let header = Header { scene: scene.hash(), ..header };
        let expected = Header::new(header.task, &header.scene);
        let mut found = Found::default();
        found.read(&parts, &Header { features: header.features.clone(), ..expected })?;
        let Found { cells: found, damaged, mixed, .. } = found;
        let reused = found.keys().filter(|key| under_way(key).is_none()).count();
        let own = HashSet::new();
        let journal = Self { file: None, found, own, reused, damaged, mixed, _lock: lock };
        Ok((journal, header.task, scene))
    }

    /// The number of cells of this command.
    pub fn cells(&self) -> usize {
        self.own.len()
    }

    /// The cells of a plan that no journal has.
    pub fn missing<'a>(&'a self, plan: &'a [Cell]) -> impl Iterator<Item = &'a Cell> {
        plan.iter().filter(|cell| !self.found.contains_key(&cell.key))
    }
}

impl Ledger for Journal {
    fn recall(&self, key: &str) -> Option<Vec<u8>> {
        self.found.get(key).cloned()
    }

    fn takes(&self, key: &str) -> bool {
        self.own.contains(key)
    }

    fn keep(&self, key: &str, result: &[u8], time: Duration) -> Result<(), JournalError> {
        let Some((path, file)) = &self.file else { return Ok(()) };
        let mut line =
            serde_json::to_vec(&Line::new(key, result, time)).map_err(JournalError::unwritten)?;
        line.push(b'\n');
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&line).map_err(JournalError::file(path))
    }
}

/// The cells of all journals of a folder.
#[derive(Default)]
struct Found {
    cells: HashMap<String, Vec<u8>>,
    /// The bytes of each file up to the end of its last whole line.
    lengths: HashMap<PathBuf, u64>,
    damaged: usize,
    mixed: bool,
}

impl Found {
    /// Reads all journals and refuses those of another scene, command or version.
    fn read(&mut self, parts: &Path, header: &Header) -> Result<(), JournalError> {
        for path in files(parts, "jsonl")? {
            let content = Content::read(&path)?;
            self.lengths.insert(path.clone(), content.length);
            let Some(theirs) = content.header else { continue };
            let features = theirs.features.clone();
            self.mixed |= features != header.features;
            if let Some((what, ours, theirs)) =
                (Header { features, ..header.clone() }).difference(&theirs)
            {
                return Err(JournalError::Foreign { path, what, ours, theirs });
            }
            self.damaged += content.damaged;
            self.cells.extend(content.cells);
        }
        Ok(())
    }
}

/// The files of a folder with an extension, by name.
fn files(parts: &Path, extension: &str) -> Result<Vec<PathBuf>, JournalError> {
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

/// Removes all journals and scenes of a folder, but not the locks.
fn forget(parts: &Path) -> Result<(), JournalError> {
    for extension in ["jsonl", "toml"] {
        for path in files(parts, extension)? {
            // The file of this command is open and locked: it is emptied instead.
            let emptied = OpenOptions::new().write(true).truncate(true).open(&path);
            emptied.map_err(JournalError::file(&path))?;
            if extension == "toml" {
                std::fs::remove_file(&path).map_err(JournalError::file(&path))?;
            }
        }
    }
    Ok(())
}

/// Stores the scene with all files it names, for a merge.
fn keep_scene(parts: &Path, scene: &Scene) -> Result<(), JournalError> {
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
fn kept_scene(parts: &Path) -> Result<Option<Scene>, JournalError> {
    let Some(path) = files(parts, "toml")?.into_iter().next() else { return Ok(None) };
    let text = std::fs::read_to_string(&path).map_err(JournalError::file(&path))?;
    let mut scene = Scene::read_in(parts, &text).map_err(|error| JournalError::Scene {
        path: path.clone(),
        why: error.problem.to_string(),
    })?;
    let name = path.file_stem().map(|name| name.to_string_lossy().into_owned());
    scene.title = scene.title.or(name);
    Ok(Some(scene))
}

/// Locks a folder of journals: shards share it, all others have it alone.
fn lock(parts: &Path, shared: bool) -> Result<File, JournalError> {
    let path = parts.join("lock");
    let open = OpenOptions::new().write(true).create(true).truncate(false).open(&path);
    let file = open.map_err(JournalError::file(&path))?;
    held(&file, shared, &path)?;
    Ok(file)
}

/// Locks a file until it is closed. File systems without locks go without.
fn held(file: &File, shared: bool, path: &Path) -> Result<(), JournalError> {
    match if shared { file.try_lock_shared() } else { file.try_lock() } {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(JournalError::Busy { path: path.into() }),
        Err(TryLockError::Error(error)) if error.kind() == std::io::ErrorKind::Unsupported => {
            Ok(())
        }
        Err(TryLockError::Error(source)) => Err(JournalError::File { path: path.into(), source }),
    }
}

/// What is wrong with a journal.
#[derive(Debug, Error)]
pub enum JournalError {
    /// A file could not be read or written.
    #[error("cannot use {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Another command uses the journal.
    #[error("another command is at work on these cells: {} is locked", path.display())]
    Busy {
        /// The locked file.
        path: PathBuf,
    },
    /// Some cells are finished and others are not.
    #[error("{} holds unfinished work: {done} of {all} cells are done", folder.display())]
    Unfinished {
        /// The folder of the results.
        folder: PathBuf,
        /// The cells that are done.
        done: usize,
        /// All cells.
        all: usize,
    },
    /// A journal of something else.
    #[error("{} has another {what}: {theirs}, here {ours}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What differs.
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
        /// Why.
        why: String,
    },
    /// There are no journals.
    #[error("{} has no parts of a study", folder.display())]
    Nothing {
        /// The folder.
        folder: PathBuf,
    },
    /// The scene of a journal cannot be read.
    #[error("the scene {} is not valid: {why}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// A result cannot be read.
    #[error("the result of the cell {key} cannot be read: {why}")]
    Unreadable {
        /// The cell.
        key: String,
        /// Why.
        why: String,
    },
    /// A result cannot be put in words.
    #[error("a result cannot be written: {why}")]
    Unwritten {
        /// Why.
        why: String,
    },
}

impl JournalError {
    fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }

    fn unwritten(why: impl ToString) -> Self {
        Self::Unwritten { why: why.to_string() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(bytes: &[u8]) -> Result<Content, JournalError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("1-of-1.jsonl");
        std::fs::write(&path, bytes).expect("it is written");
        Content::read(&path)
    }

    /// A journal of cells, and the ends of its lines.
    fn journal(cells: &[(String, Vec<u8>)]) -> (Vec<u8>, Vec<usize>) {
        let header = serde_json::to_string(&Header::new(Task::Study, "ab")).expect("a header");
        let mut bytes = (header + "\n").into_bytes();
        let mut ends = vec![bytes.len()];
        for (key, result) in cells {
            let line = Line::new(key, result, Duration::from_millis(1));
            bytes.extend(serde_json::to_vec(&line).expect("a line"));
            bytes.push(b'\n');
            ends.push(bytes.len());
        }
        (bytes, ends)
    }

    fn cells() -> impl Strategy<Value = Vec<(String, Vec<u8>)>> {
        let cell = (".*", prop::collection::vec(any::<u8>(), 0..40));
        prop::collection::vec(cell, 0..6)
    }

    /// The number of cases of a test: 256, unless the environment asks for another.
    fn cases_asked() -> ProptestConfig {
        let asked = std::env::var("AFTERBAY_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok());
        ProptestConfig { cases: asked.unwrap_or(256), ..ProptestConfig::default() }
    }

    #[test]
    fn the_corpus_is_read_or_refused() {
        let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/journals");
        let mut count = 0;
        for file in std::fs::read_dir(corpus).expect("the corpus") {
            let path = file.expect("a file").path();
            // None has a line with a right checksum.
            if let Ok(content) = Content::read(&path) {
                assert!(content.cells.is_empty(), "{}", path.display());
            }
            count += 1;
        }
        assert!(count > 5, "{count}");
    }

    proptest! {
        #![proptest_config(cases_asked())]

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            if let Ok(content) = read(&bytes) {
                prop_assert!(content.cells.is_empty());
            }
        }

        #[test]
        fn a_torn_journal_has_the_cells_of_its_whole_lines(cells in cells(), share in 0.0..1.0) {
            let (bytes, ends) = journal(&cells);
            let cut = (share * bytes.len() as f64) as usize;
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            let content = read(&bytes[..cut]).expect("a journal");
            prop_assert_eq!(content.header.is_some(), whole > 0);
            prop_assert_eq!(content.length, whole.checked_sub(1).map_or(0, |at| ends[at]) as u64);
            prop_assert_eq!(&content.cells[..], &cells[..whole.saturating_sub(1)]);
        }

        #[test]
        fn a_changed_byte_is_never_a_changed_result(
            cells in cells(),
            share in 0.0..1.0,
            byte in any::<u8>(),
        ) {
            let (mut bytes, ends) = journal(&cells);
            let at = ends[0] + (share * (bytes.len() - ends[0]) as f64) as usize;
            if at < bytes.len() {
                bytes[at] = byte;
                let content = read(&bytes).expect("the header is whole");
                prop_assert!(content.cells.iter().all(|cell| cells.contains(cell)));
            }
        }

        #[test]
        fn shards_have_each_cell_once(
            costs in prop::collection::vec(0.0..9.0, 0..40),
            count in 1_usize..9,
        ) {
            let cell = |(index, &cost): (usize, &f64)| Cell::new(index.to_string(), cost);
            let plan: Vec<Cell> = costs.iter().enumerate().map(cell).collect();
            let mut found: Vec<&str> = (1..=count)
                .flat_map(|number| Shard { number, count }.cells(&plan).collect::<Vec<_>>())
                .map(|cell| &*cell.key)
                .collect();
            let mut all: Vec<&str> = plan.iter().map(|cell| &*cell.key).collect();
            found.sort_unstable();
            all.sort_unstable();
            prop_assert_eq!(found, all);
        }
    }

    #[test]
    fn numbers_are_kept_to_the_bit() {
        let numbers =
            [0.1, -0.0, f64::NAN, f64::INFINITY, -f64::MIN_POSITIVE / 4.0, 1e-320, 0.1 + 0.2];
        let mut bytes = Vec::new();
        ciborium::into_writer(&numbers.map(Some), &mut bytes).expect("it is written");
        let read: [Option<f64>; 7] = ciborium::from_reader(&bytes[..]).expect("it is read");
        for (number, read) in numbers.iter().zip(read) {
            assert_eq!(read.map(f64::to_bits), Some(number.to_bits()));
        }
    }
}
