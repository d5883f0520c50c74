//! Studies as lists of cells: pieces of work that share nothing. A cell has a key that is the same
//! in every command, so that cells can be computed on several machines, kept, and joined.

use crate::progress::Progress;
use crate::rows::Shelf;
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A cell of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The name of its computation, such as `energy/moddg`.
    pub key: String,
    /// Its estimated cost: steps times degrees of freedom. Steps that follow from a tolerance are
    /// guessed.
    pub cost: f64,
    /// Whether it measures a time. Nothing runs beside it then.
    pub timed: bool,
    /// The pieces that it reports to [`Progress`].
    #[serde(skip)]
    pub pieces: usize,
}

impl Cell {
    /// A cell of one piece.
    pub fn new(key: String, cost: f64) -> Self {
        Self { key, cost, timed: false, pieces: 1 }
    }
}

/// A study that consists of cells.
pub trait Study: Sync {
    /// The data that all cells need, such as a reference.
    type Shared: Send + Sync;
    /// The result of a cell. It is the same to the bit when it is written and read back.
    type Part: Serialize + DeserializeOwned + Send;
    /// The error that prevents the study.
    type Error: Send;

    /// The cells, in the order in which their results are joined.
    fn cells(&self) -> Vec<Cell>;

    /// The estimated size of the data that all cells need, in bytes.
    fn shared_bytes(&self) -> f64 {
        0.0
    }

    /// Computes the data that all cells need.
    ///
    /// # Errors
    /// Invalid input, and a reference that cannot be computed.
    fn share(&self, progress: &dyn Progress) -> Result<Self::Shared, Self::Error>;

    /// Computes the cell of an index.
    ///
    /// # Errors
    /// Invalid input. A run that fails is a result.
    fn compute(
        &self,
        shared: &Self::Shared,
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Self::Part, Self::Error>;

    /// The fraction of a cell that a result contains: less than 1 for one between two legs.
    fn fraction_done(&self, _part: &Self::Part) -> f64 {
        0.0
    }

    /// Computes the next leg of a long cell from the result of the legs before. The result does not
    /// depend on the commands that computed those legs. A cell without legs is computed as a whole.
    /// Rows that are too many for the memory go to files of the shelf.
    ///
    /// # Errors
    /// Those of [`Study::compute`].
    fn advance(
        &self,
        shared: &Self::Shared,
        index: usize,
        _so_far: Option<Self::Part>,
        progress: &dyn Progress,
        _shelf: Option<&Shelf>,
    ) -> Result<Leg<Self::Part>, Self::Error> {
        self.compute(shared, index, progress).map(Leg::Last)
    }
}

/// The result of one leg of a cell.
pub enum Leg<P> {
    /// The result of the cell, after its last leg.
    Last(P),
    /// The state from which the next leg continues.
    Further(P),
}

/// Computes a cell of several legs as a whole, or up to the leg in which it is stopped.
///
/// # Errors
/// Those of [`Study::advance`].
pub fn all_legs<S: Study>(
    study: &S,
    shared: &S::Shared,
    index: usize,
    progress: &dyn Progress,
) -> Result<S::Part, S::Error> {
    let mut so_far = None;
    loop {
        match study.advance(shared, index, so_far, progress, None)? {
            Leg::Further(part) if !progress.stopped() => so_far = Some(part),
            Leg::Last(part) | Leg::Further(part) => return Ok(part),
        }
    }
}

/// The bytes of a reference at this number of times: q, p and w of each degree of freedom, the
/// time, and the doubts.
pub(crate) fn reference_bytes(degrees: usize, times: f64) -> f64 {
    8.0 * times * (3.0 * degrees as f64 + 3.0)
}

/// Computes all cells of a study.
///
/// # Errors
/// The first error of the study.
pub(crate) fn compute_all<S: Study>(
    study: &S,
    progress: &dyn Progress,
) -> Result<Vec<S::Part>, S::Error> {
    let cells = study.cells();
    let shared = study.share(progress)?;
    let indices: Vec<usize> = (0..cells.len()).collect();
    map_cells(&cells, &indices, |index| study.compute(&shared, index, progress))
}

/// Maps cells in parallel, and those that are timed one after another behind the others. The
/// results are in the order of the indices.
///
/// # Errors
/// The error of a cell that fails.
pub fn map_cells<T: Send, E: Send>(
    cells: &[Cell],
    indices: &[usize],
    compute: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let place = |place: usize| &cells[indices[place]];
    let (timed, mut free): (Vec<usize>, Vec<usize>) =
        (0..indices.len()).partition(|&at| place(at).timed);
    // The most expensive cells come first, so that no thread is left with one at the end.
    free.sort_by(|&a, &b| place(b).cost.total_cmp(&place(a).cost));
    let mut done = map_queue(&free, |at| compute(indices[at]).map(|found| (at, found)))?;
    for at in timed {
        done.push((at, compute(indices[at])?));
    }
    done.sort_by_key(|done| done.0);
    Ok(done.into_iter().map(|done| done.1).collect())
}

/// Maps the entries of a queue in parallel: a thread takes the next entry when it has finished one.
/// The results are in no particular order.
pub(crate) fn map_queue<Q: Copy + Sync, T: Send, E: Send>(
    queue: &[Q],
    compute: impl Fn(Q) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let next = AtomicUsize::new(0);
    let work = |_| {
        let mut done = Vec::new();
        while let Some(&entry) = queue.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push(compute(entry)?);
        }
        Ok(done)
    };
    let workers = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1);
    let of_workers = workers.map(work).collect::<Result<Vec<_>, E>>()?;
    Ok(of_workers.into_iter().flatten().collect())
}
