//! The journal of a command: its finished cells, so that work goes on where it stopped and several
//! commands share one study.
//!
//! Each command appends to its own file `parts/K-of-N.jsonl` below the folder of the results. The
//! first line is the [`Header`]. Each further line is a finished cell, its result in CBOR and
//! base64, with a checksum. A line is written at once, and an incomplete last line is dropped, so
//! that a command that is killed loses at most the cells under way. A long cell also has lines with
//! checkpoints; it continues from the last of them. The rows of a long trajectory are in files
//! beside the journal ([`Shelf`]), and the lines state how many of these rows are valid. Files are
//! locked while a command uses them.

mod error;
mod folder;
mod header;
mod ledger;
mod line;
mod shard;
mod takeover;

pub use error::JournalError;
pub use header::Header;
pub use ledger::{Afresh, Ledger, checkpoint, under_way};
pub use shard::Shard;
pub use takeover::{other_scene, take_over};

use crate::scene::{Scene, Task};
use afterbay_analysis::rows::Shelf;
use afterbay_analysis::study::cell::Cell;
use folder::{files, forget, held, keep_scene, kept_scene, lock, remove};
use line::{Content, Line};
use std::collections::{HashMap, HashSet};
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use takeover::{Beside, remove_others};

/// Cuts a journal off behind the bytes that count. An empty one begins with its header.
fn cut(file: &mut File, length: u64, header: &Header, path: &Path) -> Result<(), JournalError> {
    let placed = file.set_len(length).and_then(|()| file.seek(SeekFrom::Start(length)));
    placed.map_err(JournalError::file(path))?;
    if length == 0 {
        let line = serde_json::to_string(header).map_err(JournalError::unwritten)?;
        writeln!(file, "{line}").map_err(JournalError::file(path))?;
    }
    Ok(())
}

/// The folders of the journals of studies and of runs, below that of the results.
const PARTS: [&str; 2] = ["parts", "parts-of-run"];

/// The treatment of cells that are already in the journals of the folder.
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
    /// The number of own cells that this command has finished.
    kept: AtomicUsize,
    /// Lines that were not whole. Their cells are computed again.
    pub damaged: usize,
    /// Whether cells come from processors with different features.
    pub mixed: bool,
    shelf: Shelf,
    /// Held as long as the folder is used.
    _lock: File,
    _beside: Option<Beside>,
}

/// The journals of all shards of a folder, and what they belong to.
#[derive(Debug)]
pub struct Joined {
    /// The cells of all journals.
    pub journal: Journal,
    /// The command that was run.
    pub task: Task,
    /// Its scene.
    pub scene: Scene,
}

impl Journal {
    /// Opens the journal of a command that computes the cells of `shard`. With [`Start::Force`],
    /// the results of another scene in the folder are removed.
    ///
    /// # Errors
    /// [`JournalError`] for a file that cannot be written, another command on the same cells or in
    /// the same folder, parts of another scene or version, and an unfinished study if `start` is
    /// [`Start::Fresh`].
    pub fn open(
        folder: &Path,
        (task, scene): (Task, &Scene),
        (plan, shard): (&[Cell], Shard),
        start: Start,
    ) -> Result<Self, JournalError> {
        let mut places = PARTS.map(|name| folder.join(name));
        if task == Task::Run {
            places.reverse();
        }
        let [parts, others] = places;
        std::fs::create_dir_all(&parts).map_err(JournalError::file(&parts))?;
        let whole = shard == Shard::WHOLE;
        let lock = lock(&parts, !whole)?;
        let beside = Beside::lock(others, !whole)?;
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
            found.read(&parts, &header, None)?;
        } else if !whole {
            // The parts of other commands stay, and are joined with this one.
            let mut others = Found::default();
            others.read(&parts, &header, Some(&path))?;
            if others.lengths.values().all(|&length| length == 0) {
                remove(&parts, "toml")?;
            }
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
        if start == Start::Force {
            beside.iter().try_for_each(|beside| beside.forget_others(&header.scene))?;
            remove_others(folder, &header.scene)?;
        }
        let length = if begin { 0 } else { found.lengths.get(&path).copied().unwrap_or(0) };
        cut(&mut file, length, &header, &path)?;
        keep_scene(&parts, scene)?;
        let Found { cells: found, damaged, mixed, .. } = found;
        let reused = if begin { 0 } else { done };
        let file = Some((path, Mutex::new(file)));
        let shelf = Shelf::new(&parts, &format!("{}-of-{}.", shard.number, shard.count));
        let kept = AtomicUsize::new(0);
        let (_lock, _beside) = (lock, beside);
        Ok(Self { file, found, own, reused, kept, damaged, mixed, shelf, _lock, _beside })
    }

    /// Opens the journals of all shards of a folder, to join their cells. A folder without studies
    /// is asked for runs.
    ///
    /// # Errors
    /// [`JournalError`] where there is nothing to join, a command still runs, or journals belong to
    /// different scenes or versions.
    pub fn join(folder: &Path, task: Task) -> Result<Joined, JournalError> {
        let nothing = || JournalError::Nothing { folder: folder.into(), task };
        let [study, run] = PARTS.map(|name| folder.join(name));
        let parts = if task == Task::Run || !study.is_dir() { run } else { study };
        if !parts.is_dir() {
            return Err(nothing());
        }
        let lock = lock(&parts, false)?;
        let mut header = None;
        for path in files(&parts, "jsonl")? {
            // A command that was refused, or killed at its start, leaves an empty journal.
            header = header.or(Content::read(&path)?.header);
        }
        let header = header.ok_or_else(nothing)?;
        let scene =
            kept_scene(&parts)?.ok_or_else(|| JournalError::NoScene { parts: parts.clone() })?;
        let header = Header { scene: scene.hash(), ..header };
        let expected = Header::new(header.task, &header.scene);
        let mut found = Found::default();
        found.read(&parts, &Header { features: header.features.clone(), ..expected }, None)?;
        let Found { cells: found, damaged, mixed, .. } = found;
        let reused = found.keys().filter(|key| under_way(key).is_none()).count();
        let (own, shelf) = (HashSet::new(), Shelf::new(&parts, ""));
        let (file, kept) = (None, AtomicUsize::new(0));
        let (_lock, _beside) = (lock, None);
        let journal =
            Self { file, found, own, reused, kept, damaged, mixed, shelf, _lock, _beside };
        Ok(Joined { journal, task: header.task, scene })
    }

    /// The number of cells of this command.
    pub fn cells(&self) -> usize {
        self.own.len()
    }

    /// The number of cells of this command that are finished, by it or before it.
    pub fn finished(&self) -> usize {
        self.reused + self.kept.load(Ordering::Relaxed)
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
        file.write_all(&line).map_err(JournalError::file(path))?;
        self.kept.fetch_add(usize::from(under_way(key).is_none()), Ordering::Relaxed);
        Ok(())
    }

    fn shelf(&self) -> Option<&Shelf> {
        Some(&self.shelf)
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
    /// Reads all journals but one, and refuses those of another scene, command or version.
    fn read(
        &mut self,
        parts: &Path,
        header: &Header,
        except: Option<&Path>,
    ) -> Result<(), JournalError> {
        let all = files(parts, "jsonl")?.into_iter();
        for path in all.filter(|path| Some(path.as_path()) != except) {
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
