//! The cells of a method and a step at neighbouring values, as one piece of work.

use super::alone::Schedule;
use super::error::MapError;
use super::image::Image;
use super::lanes::{Cell, together};
use super::measure::Observations;
use super::reference::Reference;
use super::spectrum::spectral_radius;
use super::verdict::Verdict;
use crate::model::is_linear;
use crate::progress::Progress;
use crate::study::{Problem, outcome};
use crate::words::{Word, word};
use afterbay_core::{Abilities, InputError, Passive};
use afterbay_methods::registry::{Row, Run};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A row of `stability.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityRow {
    /// Name of the method.
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// Name of the parameter that is varied.
    pub parameter: String,
    /// The value of the parameter.
    pub value: f64,
    /// The verdict.
    pub verdict: Verdict,
    /// The spectral radius of one step, where it is linear.
    pub spectral_radius: Option<f64>,
    /// Steps done.
    pub steps_done: u64,
    /// The outcome of the run.
    #[serde(deserialize_with = "word")]
    pub outcome: Word,
}

/// A value of the parameter.
pub(super) struct Place {
    pub(super) value: f64,
    pub(super) problem: Problem,
    pub(super) system: Arc<dyn Abilities<f64>>,
    pub(super) image: Image<f64>,
}

/// Whether cells run side by side.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Together,
    Alone,
}

/// A method and a step, whose cells are those at the values of the parameter.
pub(super) struct Piece<'a> {
    pub(super) parameter: &'a str,
    pub(super) row: &'static Row,
    pub(super) h: f64,
    pub(super) observations: &'a Observations,
    pub(super) progress: &'a dyn Progress,
}

/// The cells of a piece at up to eight values.
pub(super) fn cells(
    &Piece { parameter, row, h, observations, progress }: &Piece<'_>,
    places: &[Place],
    exact: &[&Reference],
    way: Way,
) -> Result<Vec<StabilityRow>, MapError> {
    let runs =
        places.iter().map(|place| place.problem.model.bind(row)).collect::<Result<Vec<_>, _>>()?;
    let passivity = |place: &Place| place.system.dissipation_form().passive;
    let every_step = !row.passive && places.iter().any(|place| passivity(place) != Passive::No);
    let schedule = Schedule { h, observations, every_step, progress };
    let cells: Vec<Cell<'_>> = places
        .iter()
        .zip(&runs)
        .zip(exact)
        .map(|((place, run), &exact)| {
            let Place { value, problem, system, .. } = place;
            Cell { problem, value: *value, run, system: &**system, exact }
        })
        .collect();
    let side_by_side = match way {
        Way::Together => together(&cells, row, parameter, schedule)?,
        Way::Alone => None,
    };
    let endings = match side_by_side {
        Some(endings) => endings,
        None => cells.iter().map(|cell| cell.alone(schedule)).collect::<Result<_, _>>()?,
    };
    let judged = endings.into_iter().zip(places).zip(exact).zip(&runs);
    judged
        .map(|(((ending, place), exact), run)| {
            Ok(StabilityRow {
                method: row.name,
                h,
                parameter: parameter.to_owned(),
                value: place.value,
                verdict: Verdict::of(&ending, exact, passivity(place), row.keeps_k),
                spectral_radius: radius(place, run, h)?,
                steps_done: ending.steps_done,
                outcome: ending.failure.as_ref().map_or(outcome::COMPLETED, outcome::step_word),
            })
        })
        .collect()
}

fn radius(place: &Place, run: &Run<f64>, h: f64) -> Result<Option<f64>, InputError> {
    if is_linear(&place.system) { spectral_radius(run, place.system.dof(), h) } else { Ok(None) }
}
