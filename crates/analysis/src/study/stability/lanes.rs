//! Eight cells side by side, with the endings they have alone.
//!
//! A step that fails in one lane fails in all and changes no state. The step is then taken cell by
//! cell to find the one that fails. This cell ends as it would alone, and a running cell takes its
//! lane. While such steps follow each other, increasing numbers of steps are taken cell by cell, up
//! to a thousand, before lanes are tried again. Endings are the same to the bit with two
//! exceptions: the last digits of exp and sin differ in lanes, and numbers below 1e-290 come to
//! rest a few steps earlier or later.

use super::alone::{BoundMethod, Ending, ObservedRun, Schedule, alone};
use super::measure::{Scales, Statistics};
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
    fn method(&self) -> BoundMethod<'_, f64> {
        BoundMethod { run: self.run, system: self.system, scales: &self.exact.scales }
    }

    /// Runs the cell alone.
    pub(super) fn alone(&self, schedule: Schedule<'_>) -> Result<Ending, InputError> {
        alone(self.problem, &self.method(), schedule)
    }
}

impl ObservedRun<f64x8> {
    /// Lane k.
    fn lane(&self, k: usize) -> ObservedRun<f64> {
        ObservedRun { state: state_of(&self.state, k), statistics: self.statistics.lane(k) }
    }

    /// Replaces lane k.
    fn put(&mut self, k: usize, one: &ObservedRun<f64>) {
        put_state(&mut self.state, k, &one.state);
        self.statistics.put(k, &one.statistics);
    }
}

/// Runs up to eight cells side by side; `None` if the method has no such form.
pub(super) fn together(
    cells: &[Cell<'_>],
    row: &Row,
    parameter: &str,
    schedule: Schedule<'_>,
) -> Result<Option<Vec<Ending>>, InputError> {
    let Some(first) = cells.first().filter(|_| (FEWEST..=WIDTH).contains(&cells.len())) else {
        return Ok(None);
    };
    // The cell in each lane. If there are fewer cells than lanes, the last one is repeated.
    let mut cell_in: [usize; WIDTH] = std::array::from_fn(|k| k.min(cells.len() - 1));
    let Some(mut bound) = bind(cells, cell_in, row, parameter)? else { return Ok(None) };
    let state = first.problem.start::<f64x8>()?;
    let statistics = Statistics::nothing(state.dof(), &bound.scales.track.image);
    let mut all = ObservedRun { state, statistics };
    let mut endings: Vec<Option<Ending>> = cells.iter().map(|_| None).collect();
    let (count, mut at, mut burst) = (schedule.observations.count, 0, 1);
    while at < count {
        let Lanes { run, system } = &bound.lanes;
        let method = BoundMethod { run, system: &**system, scales: &bound.scales };
        let Some(broken) = method.advance(schedule, &mut all, at, count)? else { break };
        burst =
            if broken.good < at.saturating_add(4 * burst) { (4 * burst).min(LONGEST) } else { 1 };
        at = broken.good;
        let mut to = count.min(at + burst);
        let mut stays = true;
        for (i, ending) in endings.iter_mut().enumerate().filter(|(_, ending)| ending.is_none()) {
            let Some(lane) = cell_in.iter().position(|&cell| cell == i) else { continue };
            let mut one = all.lane(lane);
            match cells[i].method().advance(schedule, &mut one, at, to)? {
                None => {
                    for lane in (0..WIDTH).filter(|&lane| cell_in[lane] == i) {
                        all.put(lane, &one);
                    }
                }
                broken => {
                    *ending = Some(one.ended(count, broken));
                    stays = false;
                }
            }
        }
        if !stays {
            let running: Vec<usize> = (0..cells.len()).filter(|&i| endings[i].is_none()).collect();
            if running.len() < FEWEST {
                for i in running {
                    let Some(lane) = cell_in.iter().position(|&cell| cell == i) else { continue };
                    let mut one = all.lane(lane);
                    let broken = cells[i].method().advance(schedule, &mut one, to, count)?;
                    endings[i] = Some(one.ended(count, broken));
                }
                to = count;
            } else {
                let from = cell_in;
                for lane in (0..WIDTH).filter(|&lane| endings[from[lane]].is_some()) {
                    let Some(other) = from.iter().position(|&cell| cell == running[0]) else {
                        continue;
                    };
                    cell_in[lane] = running[0];
                    all.put(lane, &all.lane(other));
                }
                match bind(cells, cell_in, row, parameter)? {
                    Some(anew) => bound = anew,
                    None => return Ok(None),
                }
            }
        }
        at = to;
    }
    let ended = endings.into_iter().enumerate().map(|(i, ending)| {
        ending.unwrap_or_else(|| {
            let lane = cell_in.iter().position(|&cell| cell == i).unwrap_or(0);
            Ending { statistics: all.statistics.lane(lane), steps_done: count, failure: None }
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
    cell_in: [usize; WIDTH],
    row: &Row,
    parameter: &str,
) -> Result<Option<Bound>, InputError> {
    let values = cell_in.map(|cell| cells[cell].value);
    let Some(lanes) = cells[cell_in[0]].problem.model.bind_lanes(row, parameter, values)? else {
        return Ok(None);
    };
    let scales = Scales::beside(|k| &cells[cell_in[k]].exact.scales);
    Ok(scales.map(|scales| Bound { lanes, scales }))
}

const _: () = assert!(WIDTH == f64x8::LANES);
