//! A map over steps and the values of one parameter.

use super::batch::{Batch, batches};
use super::error::MapError;
use super::exact::{Exact, of_start};
use super::image::Image;
use super::lanes::WIDTH;
use super::measure::Observations;
use super::piece::{Piece, Place, StabilityRow, Way, cells};
use super::reference::{Reference, References};
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::cell::map_queue;
use afterbay_core::{Grid, InputError};
use afterbay_methods::registry::{self, Row};
use rayon::prelude::*;
use std::cmp::Reverse;

/// The most steps of a run.
pub const MOST_STEPS: f64 = 1e7;

/// A map over steps and the values of one parameter.
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// The system and the initial state.
    pub problem: Problem,
    /// The parameter that is varied, see [`Model::with`](crate::Model::with).
    pub parameter: &'a str,
    /// The values of the parameter.
    pub values: &'a [f64],
    /// The steps.
    pub steps: &'a [f64],
    /// The time of a run, rounded up to whole steps, at least [`Map::least_steps`] of them.
    pub end: f64,
    /// The least number of steps of a run.
    pub least_steps: u64,
}

impl Map<'_> {
    /// The number of pieces of work reported to [`Progress`].
    pub fn pieces(&self, methods: usize) -> usize {
        self.values.len().div_ceil(WIDTH) * (1 + methods * self.steps.len())
    }

    /// The cells, ordered by method, value and step. If [`Progress::stopped`], cells that are not
    /// done are left out.
    ///
    /// # Errors
    /// [`MapError`]
    pub fn run(
        &self,
        methods: &[&'static Row],
        progress: &dyn Progress,
    ) -> Result<Vec<StabilityRow>, MapError> {
        self.judge(methods, &self.references(progress)?, progress)
    }

    /// The exact solutions by which the cells are judged.
    ///
    /// # Errors
    /// [`MapError`]
    pub fn references(&self, progress: &dyn Progress) -> Result<References, MapError> {
        let places = self.places()?;
        let observations = self.observations()?;
        let steps: Vec<(f64, &Observations)> =
            self.steps.iter().copied().zip(&observations).collect();
        let batches = batches(&steps);
        let of_groups = places
            .par_chunks(WIDTH)
            .map(|group| {
                let found = if progress.stopped() {
                    group.iter().map(|_| None).collect()
                } else {
                    let found = self.exact(group, &batches, progress)?;
                    found.into_iter().map(|found| (!progress.stopped()).then_some(found)).collect()
                };
                progress.advance();
                Ok(found)
            })
            .collect::<Result<Vec<Vec<_>>, MapError>>()?;
        Ok(References(of_groups.into_iter().flatten().collect()))
    }

    /// Judges the cells by references of this map. Cells without a reference are left out, and so
    /// are those that are not judged yet when `progress` asks to stop.
    ///
    /// # Errors
    /// [`MapError`]
    pub fn judge(
        &self,
        methods: &[&'static Row],
        references: &References,
        progress: &dyn Progress,
    ) -> Result<Vec<StabilityRow>, MapError> {
        self.judged(methods, references, progress, Way::Together)
    }

    /// Judges the cells one at a time, as a check of [`Map::judge`], which leaves out the same
    /// cells.
    ///
    /// # Errors
    /// [`MapError`]
    pub fn judge_alone(
        &self,
        methods: &[&'static Row],
        references: &References,
        progress: &dyn Progress,
    ) -> Result<Vec<StabilityRow>, MapError> {
        self.judged(methods, references, progress, Way::Alone)
    }

    fn places(&self) -> Result<Vec<Place>, MapError> {
        self.values.iter().map(|&value| self.place(value)).collect()
    }

    pub(super) fn place(&self, value: f64) -> Result<Place, MapError> {
        let model = self.problem.model.with(self.parameter, value)?;
        let problem = Problem { model, ..self.problem.clone() };
        problem.start::<f64>()?;
        let system = problem.model.system::<f64>()?;
        let image = Image::new(&problem.model.periods());
        Ok(Place { value, problem, system, image })
    }

    pub(super) fn observations(&self) -> Result<Vec<Observations>, InputError> {
        self.steps.iter().map(|&h| Ok(Observations::new(self.steps_of(h)?))).collect()
    }

    /// The number of steps of size h of a run.
    fn steps_of(&self, h: f64) -> Result<u64, InputError> {
        Grid::<f64>::of(h, self.least_steps)?;
        let steps = (self.end / h).ceil();
        if steps.is_nan() || steps > MOST_STEPS {
            return Err(InputError::Budget { steps, limit: MOST_STEPS });
        }
        Ok((steps as u64).max(self.least_steps))
    }

    /// The references of up to eight values, for all steps.
    fn exact(
        &self,
        group: &[Place],
        batches: &[Batch],
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Reference>>, MapError> {
        let mut all: Vec<Vec<(usize, Reference)>> = group.iter().map(|_| Vec::new()).collect();
        for batch in batches {
            for (all, found) in all.iter_mut().zip(self.exact_of(group, batch, progress)?) {
                all.extend(batch.steps.iter().copied().zip(found));
            }
        }
        let in_order = |mut of: Vec<(usize, Reference)>| {
            of.sort_by_key(|of| of.0);
            of.into_iter().map(|of| of.1).collect()
        };
        Ok(all.into_iter().map(in_order).collect())
    }

    /// The references of up to eight values, for a batch of steps.
    pub(super) fn exact_of(
        &self,
        group: &[Place],
        batch: &Batch,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Reference>>, MapError> {
        let rk4 = registry::find("rk4")
            .ok_or(InputError::Unsupported { method: "rk4", why: "it is not registered" })?;
        let values = std::array::from_fn(|k| group[k.min(group.len() - 1)].value);
        let problem = &group[0].problem;
        if let Some(lanes) = problem.model.bind_lanes(rk4, self.parameter, values)? {
            let images: Vec<_> = group.iter().map(|place| place.image.clone()).collect();
            let (run, system) = (&lanes.run, &*lanes.system);
            let exact = Exact { problem, run, system, batch, images: &images, progress };
            if let Some(mut found) = exact.references()? {
                found.truncate(group.len());
                return Ok(found);
            }
        }
        let each = |Place { problem, system, image, .. }: &Place| -> Result<_, MapError> {
            let (run, images) = (&problem.model.bind(rk4)?, std::slice::from_ref(image));
            let exact = Exact { problem, run, system: &**system, batch, images, progress };
            let found = exact.references()?.and_then(|lanes| lanes.into_iter().next());
            Ok(match found {
                Some(found) => found,
                None => of_start(problem, &**system, image, batch.steps.len())?,
            })
        };
        group.iter().map(each).collect()
    }

    fn judged(
        &self,
        methods: &[&'static Row],
        References(references): &References,
        progress: &dyn Progress,
        way: Way,
    ) -> Result<Vec<StabilityRow>, MapError> {
        let (places, observations) = (self.places()?, self.observations()?);
        let (values, steps) = (places.len(), self.steps.len());
        let groups = values.div_ceil(WIDTH);
        // The most expensive tasks come first, so that no long run is left for the end.
        let mut tasks: Vec<[usize; 3]> = (0..methods.len())
            .flat_map(|i| (0..steps).flat_map(move |j| (0..groups).map(move |k| [i, j, k])))
            .collect();
        tasks.sort_by_key(|&[_, j, _]| Reverse(observations[j].count));
        let judge = |[i, j, k]: [usize; 3]| -> Result<Vec<(usize, StabilityRow)>, MapError> {
            let range = k * WIDTH..values.min((k + 1) * WIDTH);
            let of_places = references.get(range.clone()).unwrap_or_default();
            let exact: Vec<_> = of_places.iter().filter_map(|of| of.as_ref()?.get(j)).collect();
            if progress.stopped() || exact.len() < range.len() {
                return Ok(Vec::new());
            }
            let (parameter, row) = (self.parameter, methods[i]);
            let (h, observations) = (self.steps[j], &observations[j]);
            let piece = Piece { parameter, row, h, observations, progress };
            let rows = cells(&piece, &places[range.clone()], &exact, way)?;
            if progress.stopped() {
                return Ok(Vec::new());
            }
            progress.advance();
            let first = (i * values + range.start) * steps + j;
            Ok(rows
                .into_iter()
                .enumerate()
                .map(|(lane, row)| (first + lane * steps, row))
                .collect())
        };
        Ok(in_order(map_queue(&tasks, judge)?))
    }
}

/// The rows of a map in the order of their places in the table.
pub(super) fn in_order(parts: Vec<Vec<(usize, StabilityRow)>>) -> Vec<StabilityRow> {
    let mut rows: Vec<(usize, StabilityRow)> = parts.into_iter().flatten().collect();
    rows.sort_by_key(|row| row.0);
    rows.into_iter().map(|row| row.1).collect()
}
