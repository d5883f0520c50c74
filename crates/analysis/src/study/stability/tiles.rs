//! A map as a list of cells: tiles of neighbouring values and of steps that share a reference.

use super::batch::{Batch, batches};
use super::error::MapError;
use super::lanes::WIDTH;
use super::map::{Map, in_order};
use super::measure::Observations;
use super::piece::{Piece, Place, StabilityRow, Way, cells};
use crate::progress::Progress;
use crate::study::cell::{Cell, Study};
use afterbay_methods::registry::Row;
use rayon::prelude::*;

/// The verdicts of methods over a map, in tiles.
pub struct Tiles<'a> {
    map: Map<'a>,
    methods: &'a [&'static Row],
    observations: Vec<Observations>,
    batches: Vec<Batch>,
}

impl<'a> Tiles<'a> {
    /// The tiles of a map.
    ///
    /// # Errors
    /// A step of too many runs.
    pub fn new(map: Map<'a>, methods: &'a [&'static Row]) -> Result<Self, MapError> {
        let observations = map.observations()?;
        let steps: Vec<(f64, &Observations)> =
            map.steps.iter().copied().zip(&observations).collect();
        let batches = batches(&steps);
        Ok(Self { map, methods, observations, batches })
    }

    /// The rows of the table, ordered by method, value and step, from the results of all tiles. The
    /// tiles of an interrupted study that were not computed have none.
    pub fn rows(&self, parts: Vec<Vec<(usize, StabilityRow)>>) -> Vec<StabilityRow> {
        in_order(parts)
    }

    /// The values and the batch of steps of a tile.
    fn tile(&self, index: usize) -> (std::ops::Range<usize>, &Batch) {
        let first = index / self.batches.len() * WIDTH;
        let batch = &self.batches[index % self.batches.len()];
        (first..self.map.values.len().min(first + WIDTH), batch)
    }
}

impl Study for Tiles<'_> {
    type Shared = ();
    /// Each row with its place in the table.
    type Part = Vec<(usize, StabilityRow)>;
    type Error = MapError;

    fn cells(&self) -> Vec<Cell> {
        let tiles = self.map.values.len().div_ceil(WIDTH) * self.batches.len();
        let cell = |index: usize| {
            let (values, batch) = self.tile(index);
            let (nth, from) = (index % self.batches.len() + 1, values.start + 1);
            let key = format!("values={from}-{}/steps={nth}", values.end);
            let steps: u64 = batch.steps.iter().map(|&j| self.observations[j].count).sum();
            let runs = values.len() * self.methods.len() * self.map.problem.model.degrees();
            let pieces = 1 + self.methods.len() * batch.steps.len();
            Cell { pieces, ..Cell::new(key, steps as f64 * runs as f64) }
        };
        (0..tiles).map(cell).collect()
    }

    fn share(&self, _progress: &dyn Progress) -> Result<(), MapError> {
        Ok(())
    }

    fn compute(
        &self,
        (): &(),
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Self::Part, MapError> {
        let (map, (values, batch)) = (&self.map, self.tile(index));
        let place = |&value: &f64| map.place(value);
        let places: Vec<Place> =
            map.values[values.clone()].iter().map(place).collect::<Result<_, _>>()?;
        let exact = map.exact_of(&places, batch, progress)?;
        progress.advance();
        let row = |&(i, at): &(usize, usize)| {
            let j = batch.steps[at];
            let (parameter, row) = (map.parameter, self.methods[i]);
            let (h, observations) = (map.steps[j], &self.observations[j]);
            let piece = Piece { parameter, row, h, observations, progress };
            let exact: Vec<_> = exact.iter().map(|of_steps| &of_steps[at]).collect();
            let found = match progress.stopped() {
                true => Vec::new(),
                false => cells(&piece, &places, &exact, Way::Together)?,
            };
            // The verdicts of runs that were interrupted mean nothing.
            if progress.stopped() {
                return Ok(Vec::new());
            }
            progress.advance();
            let first = (i * map.values.len() + values.start) * map.steps.len() + j;
            let placed = |(lane, row)| (first + lane * map.steps.len(), row);
            Ok(found.into_iter().enumerate().map(placed).collect())
        };
        let runs: Vec<(usize, usize)> = (0..self.methods.len())
            .flat_map(|i| (0..batch.steps.len()).map(move |at| (i, at)))
            .collect();
        let rows = runs.par_iter().map(row).collect::<Result<Vec<Vec<_>>, MapError>>()?;
        Ok(rows.into_iter().flatten().collect())
    }
}
