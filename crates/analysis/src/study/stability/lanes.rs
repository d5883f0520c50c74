//! Eight cells side by side, with the endings they have alone.
//!
//! A step that fails in one lane fails in all and changes no state. The step is then taken cell by
//! cell to find the one that fails. This cell ends as it would alone, and a running cell takes its
//! lane. While such steps follow each other, increasing numbers of steps are taken cell by cell, up
//! to a thousand, before lanes are tried again. Endings are the same to the bit with two
//! exceptions: the last digits of exp and sin differ in lanes, and numbers below 1e-290 come to
//! rest a few steps earlier or later.

use super::alone::{Course, Ending, Traveller, Vehicle, alone};
use super::measure::{Scales, Seen};
use super::reference::Reference;
use crate::Lanes;
use crate::study::Problem;
use crate::study::side::{put_state, state_of};
use afterbay_core::{InputError, Scalar, System, f64x8};
use afterbay_methods::registry::{Row, Run};

/// The number of lanes.
pub(super) const WIDTH: usize = 8;
/// The most steps taken cell by cell before lanes are tried again.
const LONGEST: u64 = 1024;
/// The least number of running cells for which lanes are used.
const FEWEST: usize = 3;

/// One of the cells that run side by side: one method, one step, neighbouring values.
pub(super) struct Cell<'a> {
    pub(super) problem: &'a Problem,
    pub(super) value: f64,
    pub(super) run: &'a Run<f64>,
    pub(super) system: &'a dyn System<f64>,
    pub(super) exact: &'a Reference,
}

impl Cell<'_> {
    fn vehicle(&self) -> Vehicle<'_, f64> {
        Vehicle { run: self.run, system: self.system, scales: &self.exact.scales }
    }

    /// Runs the cell alone.
    pub(super) fn alone(&self, course: Course<'_>) -> Result<Ending, InputError> {
        alone(self.problem, &self.vehicle(), course)
    }
}

/// Runs up to eight cells side by side; `None` if the method has no such form.
pub(super) fn together(
    cells: &[Cell<'_>],
    row: &Row,
    parameter: &str,
    course: Course<'_>,
) -> Result<Option<Vec<Ending>>, InputError> {
    let Some(first) = cells.first().filter(|_| (FEWEST..=WIDTH).contains(&cells.len())) else {
        return Ok(None);
    };
    // The cell in each lane. If there are fewer cells than lanes, the last one is repeated.
    let mut seats: [usize; WIDTH] = std::array::from_fn(|k| k.min(cells.len() - 1));
    let Some(mut bound) = bind(cells, seats, row, parameter)? else { return Ok(None) };
    let state = first.problem.start::<f64x8>()?;
    let seen = Seen::nothing(state.dof(), &bound.scales.track.image);
    let mut all = Traveller { state, seen };
    let mut endings: Vec<Option<Ending>> = cells.iter().map(|_| None).collect();
    let (count, mut at, mut burst) = (course.looks.count, 0, 1);
    while at < count {
        let Lanes { run, system } = &bound.lanes;
        let vehicle = Vehicle { run, system: &**system, scales: &bound.scales };
        let Some(broken) = vehicle.carry(course, &mut all, at, count)? else { break };
        burst =
            if broken.good < at.saturating_add(4 * burst) { (4 * burst).min(LONGEST) } else { 1 };
        at = broken.good;
        let mut to = count.min(at + burst);
        let mut stays = true;
        for (i, ending) in endings.iter_mut().enumerate().filter(|(_, ending)| ending.is_none()) {
            let Some(lane) = seats.iter().position(|&seat| seat == i) else { continue };
            let mut one =
                Traveller { state: state_of(&all.state, lane), seen: all.seen.lane(lane) };
            match cells[i].vehicle().carry(course, &mut one, at, to)? {
                None => {
                    for lane in (0..WIDTH).filter(|&lane| seats[lane] == i) {
                        put_state(&mut all.state, lane, &one.state);
                        all.seen.put(lane, &one.seen);
                    }
                }
                broken => {
                    *ending = Some(one.ended(count, broken));
                    stays = false;
                }
            }
        }
        if !stays {
            let living: Vec<usize> = (0..cells.len()).filter(|&i| endings[i].is_none()).collect();
            if living.len() < FEWEST {
                for i in living {
                    let Some(lane) = seats.iter().position(|&seat| seat == i) else { continue };
                    let mut one =
                        Traveller { state: state_of(&all.state, lane), seen: all.seen.lane(lane) };
                    let broken = cells[i].vehicle().carry(course, &mut one, to, count)?;
                    endings[i] = Some(one.ended(count, broken));
                }
                to = count;
            } else {
                let from = seats;
                for lane in (0..WIDTH).filter(|&lane| endings[from[lane]].is_some()) {
                    let Some(other) = from.iter().position(|&seat| seat == living[0]) else {
                        continue;
                    };
                    seats[lane] = living[0];
                    let state = state_of(&all.state, other);
                    put_state(&mut all.state, lane, &state);
                    let seen = all.seen.lane(other);
                    all.seen.put(lane, &seen);
                }
                match bind(cells, seats, row, parameter)? {
                    Some(anew) => bound = anew,
                    None => return Ok(None),
                }
            }
        }
        at = to;
    }
    let ended = endings.into_iter().enumerate().map(|(i, ending)| {
        ending.unwrap_or_else(|| {
            let lane = seats.iter().position(|&seat| seat == i).unwrap_or(0);
            Ending { seen: all.seen.lane(lane), steps_done: count, failure: None }
        })
    });
    Ok(Some(ended.collect()))
}

/// Cells bound to lanes.
struct Bound {
    lanes: Lanes,
    scales: Scales<f64x8>,
}

fn bind(
    cells: &[Cell<'_>],
    seats: [usize; WIDTH],
    row: &Row,
    parameter: &str,
) -> Result<Option<Bound>, InputError> {
    let values = seats.map(|seat| cells[seat].value);
    let Some(lanes) = cells[seats[0]].problem.model.bind_lanes(row, parameter, values)? else {
        return Ok(None);
    };
    let scales = Scales::beside(|k| &cells[seats[k]].exact.scales);
    Ok(scales.map(|scales| Bound { lanes, scales }))
}

const _: () = assert!(WIDTH == f64x8::LANES);
