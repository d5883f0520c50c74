//! The studies that a scene declares, whatever their kind: cells whose results are bytes, and a
//! section of the report.

use super::is_of_reference;
use super::ledger::Ledger;
use crate::journal::JournalError;
use crate::progress::Progress;
use crate::sheet::{ReportError, Sheet};
use crate::study::cell::{Cell, Study, map_cells};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;
use std::time::Instant;

/// A study of a scene.
pub(super) trait Declared: Sync {
    /// Its name in scenes.
    fn name(&self) -> &'static str;

    /// Its name for people.
    fn title(&self) -> &'static str;

    /// The cells. Their keys begin with the name.
    fn cells(&self) -> Vec<Cell>;

    /// The bytes of what all cells need, estimated.
    fn shared_bytes(&self) -> f64;

    /// Computes what all cells need, once. Without it, each cell computes it for itself.
    fn prepare(&self, progress: &dyn Progress) -> Result<(), ReportError>;

    /// The result of a cell.
    fn compute(&self, index: usize, progress: &dyn Progress) -> Result<Vec<u8>, ReportError>;

    /// The section of the report, from the results of all cells.
    fn sheet(&self, parts: &[Vec<u8>]) -> Result<Sheet, ReportError>;
}

/// A study with the function that makes its section.
pub(super) struct Section<S: Study, F> {
    name: &'static str,
    title: &'static str,
    study: S,
    sheet: F,
    /// What all cells need, or why there is no reference.
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
    F: Fn(&S, Vec<S::Part>) -> Result<Sheet, ReportError> + Sync,
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

    fn compute(&self, index: usize, progress: &dyn Progress) -> Result<Vec<u8>, ReportError> {
        let own;
        let shared = match self.shared.get() {
            Some(shared) => shared,
            None => {
                own = self.share(progress)?;
                &own
            }
        };
        Ok(written(&match shared {
            Ok(shared) => Kept::Done(self.study.compute(shared, index, progress)?),
            Err(why) => Kept::NoReference(why.clone()),
        })?)
    }

    fn sheet(&self, parts: &[Vec<u8>]) -> Result<Sheet, ReportError> {
        let mut done = Vec::with_capacity(parts.len());
        for (part, cell) in parts.iter().zip(self.cells()) {
            match ciborium::from_reader(&part[..]) {
                Ok(Kept::Done(part)) => done.push(part),
                Ok(Kept::NoReference(why)) => return Err(ReportError::NoReference(why)),
                Err(why) => {
                    let why = why.to_string();
                    return Err(JournalError::Unreadable { key: cell.key, why }.into());
                }
            }
        }
        (self.sheet)(&self.study, done)
    }
}

impl<S, F> Section<S, F>
where
    S: Study,
    ReportError: From<S::Error>,
{
    /// What all cells need, or why there is no reference.
    fn share(&self, progress: &dyn Progress) -> Result<Result<S::Shared, String>, ReportError> {
        match self.study.share(progress).map_err(ReportError::from) {
            Ok(shared) => Ok(Ok(shared)),
            Err(ReportError::Study(error)) if is_of_reference(&error) => Ok(Err(error.to_string())),
            Err(error) => Err(error),
        }
    }
}

/// The bytes of a result (CBOR, RFC 8949), which keep every number to the bit.
fn written<P: Serialize>(part: &Kept<P>) -> Result<Vec<u8>, JournalError> {
    let mut bytes = Vec::new();
    ciborium::into_writer(part, &mut bytes)
        .map_err(|why| JournalError::Unwritten { why: why.to_string() })?;
    Ok(bytes)
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
        progress.begin(study.title(), pieces);
        study.prepare(progress)?;
        let compute = |index: usize| {
            let clock = Instant::now();
            let part = study.compute(index, progress)?;
            // What an interrupted run gives is not the result of the cell.
            if !progress.stopped() {
                ledger.keep(&cells[index].key, &part, clock.elapsed())?;
            }
            Ok::<_, ReportError>(part)
        };
        let found = map_cells(&cells, &wanted, compute)?;
        wanted.iter().zip(found).for_each(|(&index, part)| parts[index] = Some(part));
    }
    Ok(parts.into_iter().collect())
}
