//! Studies of attractors as lists of cells.

use super::cell::{Cell, Study};
use super::stability::MapError;
use crate::progress::Progress;
use afterbay_methods::registry::{REFERENCE, Row};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A piece of a study of a method with one step.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecePlan {
    /// The end of the key of its cell, behind the method and the step.
    pub key: String,
    /// Its cost in units of time over all runs.
    pub time: f64,
    /// The number of runs that it reports to [`Progress`].
    pub runs: usize,
}

/// The study of a method with one step. It consists of pieces that share nothing, at least one.
pub trait Dynamics: Sync {
    /// The result of a piece.
    type Piece: Serialize + DeserializeOwned + Send;
    /// The result of a method and a step.
    type Found;

    /// All pieces.
    fn pieces(&self) -> Vec<PiecePlan>;

    /// Computes a piece with steps of nearly h.
    ///
    /// # Errors
    /// Invalid input, such as a method that does not apply. A run that fails is a result.
    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        piece: usize,
        progress: &dyn Progress,
    ) -> Result<Self::Piece, MapError>;

    /// Joins all pieces of a method and a step.
    fn join(&self, row: &'static Row, h: f64, pieces: Vec<Self::Piece>) -> Self::Found;

    /// Computes all pieces with steps of nearly h, in parallel, and joins them.
    ///
    /// # Errors
    /// Those of [`Dynamics::piece`].
    fn run(
        &self,
        row: &'static Row,
        h: f64,
        progress: &dyn Progress,
    ) -> Result<Self::Found, MapError> {
        let each = |piece| self.piece(row, h, piece, progress);
        let pieces = (0..self.pieces().len()).into_par_iter().map(each);
        Ok(self.join(row, h, pieces.collect::<Result<_, _>>()?))
    }
}

/// The plan of a study of attractors: methods at several steps, beside a reference.
#[derive(Clone, Debug)]
pub struct DynamicsPlan<S> {
    /// The methods.
    pub methods: Vec<&'static Row>,
    /// The steps.
    pub steps: Vec<f64>,
    /// The step of the reference, if there is one.
    pub reference: Option<f64>,
    /// The study.
    pub study: S,
}

impl<S> DynamicsPlan<S> {
    /// Each method with each step, the reference first.
    pub fn settings(&self) -> impl Iterator<Item = (&'static Row, f64)> {
        let reference = self.reference.map(|h| (&REFERENCE, h)).into_iter();
        let each = self.methods.iter().flat_map(|&row| self.steps.iter().map(move |&h| (row, h)));
        reference.chain(each)
    }
}

impl<S: Dynamics> DynamicsPlan<S> {
    /// The result of each method with each step, from the results of all cells.
    pub fn gather(&self, parts: Vec<S::Piece>) -> Vec<S::Found> {
        let (mut parts, pieces) = (parts.into_iter(), self.study.pieces().len());
        let join = |(row, h)| self.study.join(row, h, parts.by_ref().take(pieces).collect());
        self.settings().map(join).collect()
    }
}

impl<S: Dynamics> Study for DynamicsPlan<S> {
    type Shared = ();
    type Part = S::Piece;
    type Error = MapError;

    fn cells(&self) -> Vec<Cell> {
        let pieces = self.study.pieces();
        let of_setting = |(row, h): (&'static Row, f64)| {
            pieces.iter().map(move |PiecePlan { key, time, runs }| {
                let key = format!("{}/h={h:?}{key}", row.name);
                Cell { pieces: *runs, ..Cell::new(key, time / h) }
            })
        };
        self.settings().flat_map(of_setting).collect()
    }

    fn share(&self, _progress: &dyn Progress) -> Result<(), MapError> {
        Ok(())
    }

    fn compute(
        &self,
        (): &(),
        index: usize,
        progress: &dyn Progress,
    ) -> Result<S::Piece, MapError> {
        let pieces = self.study.pieces().len();
        let settings: Vec<_> = self.settings().collect();
        let (row, h) = settings[index / pieces];
        self.study.piece(row, h, index % pieces, progress)
    }
}
