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
    let Some(mut group) = Group::new(cells, row, parameter, schedule)? else { return Ok(None) };
    let (count, mut at, mut burst) = (schedule.observations.count, 0, 1);
    while at < count {
        let Some(good) = group.advance(at)? else { break };
        burst = if good < at.saturating_add(4 * burst) { (4 * burst).min(LONGEST) } else { 1 };
        at = count.min(good + burst);
        if !group.each_alone(good, at)? {
            let running = group.running();
            if running.len() < FEWEST {
                group.finish_alone(&running, at)?;
                break;
            }
            if !group.refill(running[0], row, parameter)? {
                return Ok(None);
            }
        }
    }
    Ok(Some(group.ended()))
}

/// Cells that run side by side.
struct Group<'a> {
    cells: &'a [Cell<'a>],
    schedule: Schedule<'a>,
    /// The cell in each lane. If there are fewer cells than lanes, the last one is repeated.
    cell_in: [usize; WIDTH],
    bound: Bound,
    all: ObservedRun<f64x8>,
    /// The ending of each cell that has ended.
    endings: Vec<Option<Ending>>,
}

impl<'a> Group<'a> {
    fn new(
        cells: &'a [Cell<'a>],
        row: &Row,
        parameter: &str,
        schedule: Schedule<'a>,
    ) -> Result<Option<Self>, InputError> {
        let Some(first) = cells.first().filter(|_| (FEWEST..=WIDTH).contains(&cells.len())) else {
            return Ok(None);
        };
        let cell_in = std::array::from_fn(|k| k.min(cells.len() - 1));
        let Some(bound) = bind(cells, cell_in, row, parameter)? else { return Ok(None) };
        let state = first.problem.start::<f64x8>()?;
        let statistics = Statistics::nothing(state.dof(), &bound.scales.track.image);
        let all = ObservedRun { state, statistics };
        let endings = cells.iter().map(|_| None).collect();
        Ok(Some(Self { cells, schedule, cell_in, bound, all, endings }))
    }

    fn count(&self) -> u64 {
        self.schedule.observations.count
    }

    fn lane_of(&self, cell: usize) -> Option<usize> {
        self.cell_in.iter().position(|&other| other == cell)
    }

    /// The cells that have not ended.
    fn running(&self) -> Vec<usize> {
        (0..self.cells.len()).filter(|&i| self.endings[i].is_none()).collect()
    }

    /// Takes all steps after `at` side by side. Returns the number of good steps if one fails.
    fn advance(&mut self, at: u64) -> Result<Option<u64>, InputError> {
        let Lanes { run, system } = &self.bound.lanes;
        let method = BoundMethod { run, system: &**system, scales: &self.bound.scales };
        let count = self.schedule.observations.count;
        let broken = method.advance(self.schedule, &mut self.all, at, count)?;
        Ok(broken.map(|broken| broken.good))
    }

    /// Takes the steps after `from` up to `to` cell by cell. Returns whether no cell ends there.
    fn each_alone(&mut self, from: u64, to: u64) -> Result<bool, InputError> {
        let mut stays = true;
        for i in self.running() {
            let Some(lane) = self.lane_of(i) else { continue };
            let mut one = self.all.lane(lane);
            match self.cells[i].method().advance(self.schedule, &mut one, from, to)? {
                None => {
                    for lane in (0..WIDTH).filter(|&lane| self.cell_in[lane] == i) {
                        self.all.put(lane, &one);
                    }
                }
                broken => {
                    self.endings[i] = Some(one.ended(self.count(), broken));
                    stays = false;
                }
            }
        }
        Ok(stays)
    }

    /// Takes all steps after `from` cell by cell.
    fn finish_alone(&mut self, running: &[usize], from: u64) -> Result<(), InputError> {
        for &i in running {
            let Some(lane) = self.lane_of(i) else { continue };
            let mut one = self.all.lane(lane);
            let method = self.cells[i].method();
            let broken = method.advance(self.schedule, &mut one, from, self.count())?;
            self.endings[i] = Some(one.ended(self.count(), broken));
        }
        Ok(())
    }

    /// Gives the lanes of cells that have ended to one that runs. Returns whether the method can
    /// run in these lanes.
    fn refill(&mut self, running: usize, row: &Row, parameter: &str) -> Result<bool, InputError> {
        let from = self.cell_in;
        let Some(other) = self.lane_of(running) else { return Ok(true) };
        for lane in (0..WIDTH).filter(|&lane| self.endings[from[lane]].is_some()) {
            self.cell_in[lane] = running;
            self.all.put(lane, &self.all.lane(other));
        }
        match bind(self.cells, self.cell_in, row, parameter)? {
            Some(bound) => self.bound = bound,
            None => return Ok(false),
        }
        Ok(true)
    }

    /// The endings of all cells. Those that have not ended have taken all steps.
    fn ended(mut self) -> Vec<Ending> {
        let endings = std::mem::take(&mut self.endings);
        let ended = endings.into_iter().enumerate().map(|(i, ending)| {
            ending.unwrap_or_else(|| {
                let statistics = self.all.statistics.lane(self.lane_of(i).unwrap_or(0));
                Ending { statistics, steps_done: self.count(), failure: None }
            })
        });
        ended.collect()
    }
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
