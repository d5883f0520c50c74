//! The studies that a scene declares, whatever their kind: cells whose results are bytes, and a
//! section of the report.

use super::is_of_reference;
use crate::journal::{JournalError, Ledger, checkpoint};
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::progress::{Progress, Weighted};
use afterbay_analysis::rows::Shelf;
use afterbay_analysis::study::cell::{Cell, Leg, Study, map_cells};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// The least time between two checkpoints of a cell. A command that is killed may lose the work of
/// this time and of a leg.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(10);
/// The least time between two checkpoints as a share of the time that the cell has taken, so that
/// the journal of a run of days stays small.
const SHARE_BETWEEN: f64 = 0.01;

/// A study of a scene.
pub(super) trait Declared: Sync {
    /// Its name in scenes.
    fn name(&self) -> &'static str;

    /// Its name for people.
    fn title(&self) -> &'static str;

    /// The cells. Their keys begin with the name.
    fn cells(&self) -> Vec<Cell>;

    /// The estimated size of the data that all cells need, in bytes.
    fn shared_bytes(&self) -> f64;

    /// Computes the data that all cells need, once. Without it, each cell computes them for itself.
    fn prepare(&self, progress: &dyn Progress) -> Result<(), ReportError>;

    /// The result of a cell with this key. A long cell continues from the checkpoint in the ledger,
    /// and keeps its own checkpoints there.
    fn compute(
        &self,
        index: usize,
        cell: (&str, &dyn Ledger),
        progress: &dyn Progress,
    ) -> Result<Vec<u8>, ReportError>;

    /// The section of the report, from the results of all cells, and their rows on the shelf.
    fn sheet(&self, parts: &[Vec<u8>], shelf: Option<&Shelf>) -> Result<Sheet, ReportError>;
}

/// A study with the function that makes its section.
pub(super) struct Section<S: Study, F> {
    name: &'static str,
    title: &'static str,
    study: S,
    sheet: F,
    /// The data that all cells need, or the reason for which there is no reference.
    shared: OnceLock<Result<S::Shared, String>>,
}

/// A study of any kind.
pub(super) type Boxed<'a> = Box<dyn Declared + 'a>;

/// A study with its name in scenes, its name for people, and the function that makes its section of
/// the results of all cells.
pub(super) fn section<'a, S, F>([name, title]: [&'static str; 2], study: S, sheet: F) -> Boxed<'a>
where
    S: Study + 'a,
    ReportError: From<S::Error>,
    F: Fn(&S, Vec<S::Part>) -> Result<Sheet, ReportError> + Sync + 'a,
{
    section_of_rows([name, title], study, move |study, parts, _| sheet(study, parts))
}

/// A [`section`] of results whose rows are on a shelf.
pub(super) fn section_of_rows<'a, S, F>(
    [name, title]: [&'static str; 2],
    study: S,
    sheet: F,
) -> Boxed<'a>
where
    S: Study + 'a,
    ReportError: From<S::Error>,
    F: Fn(&S, Vec<S::Part>, Option<&Shelf>) -> Result<Sheet, ReportError> + Sync + 'a,
{
    Box::new(Section { name, title, study, sheet, shared: OnceLock::new() })
}

/// The result of a cell, as it is kept.
#[derive(Serialize, Deserialize)]
enum Kept<P> {
    Done(P),
    /// The reference could not be computed, for this reason.
    NoReference(String),
}

impl<S, F> Declared for Section<S, F>
where
    S: Study,
    ReportError: From<S::Error>,
    F: Fn(&S, Vec<S::Part>, Option<&Shelf>) -> Result<Sheet, ReportError> + Sync,
{
    fn name(&self) -> &'static str {
        self.name
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn cells(&self) -> Vec<Cell> {
        let named = |cell: Cell| Cell { key: format!("{}/{}", self.name, cell.key), ..cell };
        self.study.cells().into_iter().map(named).collect()
    }

    fn shared_bytes(&self) -> f64 {
        self.study.shared_bytes()
    }

    fn prepare(&self, progress: &dyn Progress) -> Result<(), ReportError> {
        if self.shared.get().is_none() {
            let _ = self.shared.set(self.share(progress)?);
        }
        Ok(())
    }

    fn compute(
        &self,
        index: usize,
        (key, ledger): (&str, &dyn Ledger),
        progress: &dyn Progress,
    ) -> Result<Vec<u8>, ReportError> {
        let own;
        let shared = match self.shared.get() {
            Some(shared) => shared,
            None => {
                own = self.share(progress)?;
                &own
            }
        };
        let shared = match shared {
            Ok(shared) => shared,
            Err(why) => return Ok(written(&Kept::<S::Part>::NoReference(why.clone()))?),
        };
        let key = checkpoint(key);
        let mut so_far = match ledger.recall(&key) {
            Some(kept) => Some(read(&key, &kept)?),
            None => None,
        };
        so_far.iter().for_each(|part| progress.earlier(self.study.fraction_done(part)));
        let shelf = ledger.shelf();
        let (begin, mut kept) = (Instant::now(), Instant::now());
        loop {
            let part = match self.study.advance(shared, index, so_far.take(), progress, shelf)? {
                Leg::Last(part) => return Ok(written(&Kept::Done(part))?),
                Leg::Further(part) => part,
            };
            let between = BETWEEN_CHECKPOINTS.max(begin.elapsed().mul_f64(SHARE_BETWEEN));
            if kept.elapsed() >= between || progress.stopped() {
                ledger.keep(&key, &written(&part)?, begin.elapsed())?;
                kept = Instant::now();
            }
            if progress.stopped() {
                return Ok(written(&Kept::Done(part))?);
            }
            so_far = Some(part);
        }
    }

    fn sheet(&self, parts: &[Vec<u8>], shelf: Option<&Shelf>) -> Result<Sheet, ReportError> {
        let mut done = Vec::with_capacity(parts.len());
        for (part, cell) in parts.iter().zip(self.cells()) {
            match read(&cell.key, part)? {
                Kept::Done(part) => done.push(part),
                Kept::NoReference(why) => return Err(ReportError::NoReference(why)),
            }
        }
        (self.sheet)(&self.study, done, shelf)
    }
}

impl<S, F> Section<S, F>
where
    S: Study,
    ReportError: From<S::Error>,
{
    /// The data that all cells need, or the reason for which there is no reference.
    fn share(&self, progress: &dyn Progress) -> Result<Result<S::Shared, String>, ReportError> {
        match self.study.share(progress).map_err(ReportError::from) {
            Ok(shared) => Ok(Ok(shared)),
            Err(ReportError::Study(error)) if is_of_reference(&error) => Ok(Err(error.to_string())),
            Err(error) => Err(error),
        }
    }
}

/// The bytes of a result (CBOR, RFC 8949), which keep every number to the bit.
fn written<P: Serialize>(part: &P) -> Result<Vec<u8>, JournalError> {
    let mut bytes = Vec::new();
    ciborium::into_writer(part, &mut bytes)
        .map_err(|why| JournalError::Unwritten { why: why.to_string() })?;
    Ok(bytes)
}

/// Reads back what was [`written`] for a cell.
fn read<P: DeserializeOwned>(key: &str, bytes: &[u8]) -> Result<P, JournalError> {
    ciborium::from_reader(bytes)
        .map_err(|why| JournalError::Unreadable { key: key.into(), why: why.to_string() })
}

/// The results of the cells of a study in their order: those that the ledger has, and those that
/// this command computes. None if there are others.
///
/// # Errors
/// Invalid input, and an interruption before the reference is known.
pub(super) fn results(
    study: &dyn Declared,
    ledger: &dyn Ledger,
    progress: &dyn Progress,
) -> Result<Option<Vec<Vec<u8>>>, ReportError> {
    let cells = study.cells();
    let mut parts: Vec<Option<Vec<u8>>> =
        cells.iter().map(|cell| ledger.recall(&cell.key)).collect();
    let missing = |&index: &usize| parts[index].is_none() && ledger.takes(&cells[index].key);
    let wanted: Vec<usize> = (0..cells.len()).filter(missing).collect();
    if !wanted.is_empty() {
        let pieces = wanted.iter().map(|&index| cells[index].pieces).sum();
        let cost: f64 = wanted.iter().map(|&index| cells[index].cost).sum();
        progress.begin(study.title(), pieces);
        study.prepare(progress)?;
        let compute = |index: usize| {
            let (clock, cell) = (Instant::now(), &cells[index]);
            let weighted = Weighted::new(progress, cell.cost / cost, cell.pieces);
            let part = study.compute(index, (&cell.key, ledger), &weighted)?;
            // The result of an interrupted run is not the result of the cell.
            if !progress.stopped() {
                ledger.keep(&cell.key, &part, clock.elapsed())?;
            }
            Ok::<_, ReportError>(part)
        };
        let found = map_cells(&cells, &wanted, compute)?;
        wanted.iter().zip(found).for_each(|(&index, part)| parts[index] = Some(part));
    }
    Ok(parts.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_analysis::progress::Silent;
    use std::collections::HashMap;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// A study of one cell that counts its five legs.
    #[derive(Default)]
    struct Count {
        computed: AtomicU64,
    }

    impl Study for Count {
        type Shared = ();
        type Part = u64;
        type Error = ReportError;

        fn cells(&self) -> Vec<Cell> {
            vec![Cell::new("cell".into(), 5.0)]
        }

        fn share(&self, _progress: &dyn Progress) -> Result<(), ReportError> {
            Ok(())
        }

        fn compute(&self, (): &(), _: usize, _: &dyn Progress) -> Result<u64, ReportError> {
            Ok(0)
        }

        fn fraction_done(&self, legs: &u64) -> f64 {
            *legs as f64 / 5.0
        }

        fn advance(
            &self,
            (): &(),
            _index: usize,
            so_far: Option<u64>,
            progress: &dyn Progress,
            _shelf: Option<&Shelf>,
        ) -> Result<Leg<u64>, ReportError> {
            self.computed.fetch_add(1, Ordering::Relaxed);
            progress.advance();
            let legs = so_far.unwrap_or(0) + 1;
            Ok(if legs == 5 { Leg::Last(legs) } else { Leg::Further(legs) })
        }
    }

    #[derive(Default)]
    struct Kept(Mutex<HashMap<String, Vec<u8>>>);

    impl Ledger for Kept {
        fn recall(&self, key: &str) -> Option<Vec<u8>> {
            self.0.lock().expect("a map").get(key).cloned()
        }

        fn takes(&self, _key: &str) -> bool {
            true
        }

        fn keep(&self, key: &str, result: &[u8], _time: Duration) -> Result<(), JournalError> {
            self.0.lock().expect("a map").insert(key.into(), result.into());
            Ok(())
        }
    }

    /// Asks to stop after three legs.
    #[derive(Default)]
    struct Impatient(AtomicU64);

    /// The share of the cost that is said to be done by an earlier command.
    #[derive(Default)]
    struct Earlier(Mutex<f64>);

    impl Progress for Earlier {
        fn begin(&self, _stage: &str, _total: usize) {}

        fn advance(&self) {}

        fn earlier(&self, share: f64) {
            *self.0.lock().expect("a share") += share;
        }
    }

    impl Progress for Impatient {
        fn begin(&self, _stage: &str, _total: usize) {}

        fn advance(&self) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }

        fn stopped(&self) -> bool {
            self.0.load(Ordering::Relaxed) >= 3
        }
    }

    type SheetOf = fn(&Count, Vec<u64>, Option<&Shelf>) -> Result<Sheet, ReportError>;

    fn study(study: Count) -> Section<Count, SheetOf> {
        let sheet: SheetOf = |_, _, _| Ok(Sheet::new("a study"));
        Section { name: "study", title: "a study", study, sheet, shared: OnceLock::new() }
    }

    #[test]
    fn a_stopped_cell_goes_on_after_its_last_leg() {
        let (ledger, first, second) =
            (Kept::default(), study(Count::default()), study(Count::default()));
        results(&first, &ledger, &Impatient::default()).expect("no error");
        assert_eq!(ledger.recall("study/cell"), None, "it is not finished");
        let at: u64 =
            read("", &ledger.recall("study/cell#").expect("a checkpoint")).expect("a number");
        assert_eq!(at, 3);
        let earlier = Earlier::default();
        let parts = results(&second, &ledger, &earlier).expect("no error").expect("all cells");
        assert_eq!(*earlier.0.lock().expect("a share"), 0.6, "three of five legs were done");
        assert_eq!(second.study.computed.load(Ordering::Relaxed), 2);
        assert_eq!(ledger.recall("study/cell").as_ref(), parts.first());
        let again = study(Count::default());
        results(&again, &ledger, &Silent).expect("no error");
        assert_eq!(
            again.study.computed.load(Ordering::Relaxed),
            0,
            "a finished cell is not computed"
        );
    }
}
