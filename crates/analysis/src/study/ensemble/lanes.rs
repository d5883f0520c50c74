//! Eight runs side by side, over whole intervals of a stroboscopic section.

use super::{Ensemble, Job, Watch, alone};
use crate::Lanes;
use crate::study::ranges::Ranges;
use crate::study::section::rewind;
use crate::study::side::{Side, put_state, state_of};
use afterbay_core::{Grid, InputError, IntegrateError, Scalar, State, StateRef, f64x8};
use std::ops::ControlFlow;

/// The number of lanes.
const WIDTH: usize = 8;
/// The least number of runs for which lanes are used.
const FEWEST: usize = 3;

/// Takes the runs of a group side by side, as long as there are enough of them. Those left over
/// have no ending.
pub(super) fn together<W: Watch>(
    ensemble: &Ensemble<'_>,
    jobs: &mut [Job<W>],
) -> Result<(), InputError> {
    let Some(first) = jobs.first().filter(|_| jobs.len() >= FEWEST) else { return Ok(()) };
    let (dof, steps) = (first.dof, first.grid.steps);
    let (mut group, mut paths) = (Group::of(&first.state), Ranges::nothing(dof));
    let mut bound = None;
    while let Some(changed) = group.fill(jobs) {
        if changed || bound.is_none() {
            bound = bind(ensemble, jobs, group.job_in)?;
        }
        let Some(Lanes { run, .. }) = &bound else { return Ok(()) };
        let grid = Grid { h: f64x8::gather(|lane| jobs[group.job_in[lane]].grid.h), steps };
        paths.clear();
        let see = &mut |_, all: StateRef<'_, f64x8>| {
            paths.see(all);
            ControlFlow::Continue(())
        };
        let good = match run.run(grid, &mut group.all, 1, see) {
            Ok(_) => steps,
            Err(IntegrateError::Run(error)) => error.step - 1,
            Err(IntegrateError::Input(error)) => return Err(error),
            Err(IntegrateError::Interrupted) => return Ok(()),
        };
        for lane in (0..WIDTH).filter(|&lane| group.owned[lane]) {
            let job = &mut jobs[group.job_in[lane]];
            job.state = state_of(&group.all, lane);
            job.path.join(&paths.lane(lane));
            if good < steps {
                alone::finish(job, good)?;
            }
            if job.ending.is_none() {
                job.state.t = job.grid.h * steps as f64;
                job.arrive(ensemble.progress);
                job.begin_interval();
                put_state(&mut group.all, lane, &job.state);
            }
        }
        rewind(&mut group.all.q, &mut group.all.t, dof);
    }
    Ok(())
}

/// The runs in the lanes.
struct Group {
    all: State<Vec<f64x8>>,
    /// The run in each lane.
    job_in: [usize; WIDTH],
    /// Whether the lane is the run's own: lanes without a run repeat another's.
    owned: [bool; WIDTH],
    /// The first run that has no lane yet.
    next: usize,
}

impl Group {
    fn of(State { q, p, w, t }: &State<Vec<f64>>) -> Self {
        let splat = |part: &[f64]| part.iter().map(|&x| f64x8::from_f64(x)).collect();
        let all = State { q: splat(q), p: splat(p), w: splat(w), t: f64x8::from_f64(*t) };
        Self { all, job_in: [0; WIDTH], owned: [false; WIDTH], next: 0 }
    }

    fn put<W>(&mut self, lane: usize, job: usize, jobs: &[Job<W>]) {
        self.job_in[lane] = job;
        put_state(&mut self.all, lane, &jobs[job].state);
    }

    /// Gives the lanes of runs that have ended to the next runs. Returns whether a lane has another
    /// run than before, and `None` if too few runs are left.
    fn fill<W>(&mut self, jobs: &[Job<W>]) -> Option<bool> {
        let mut changed = false;
        for lane in 0..WIDTH {
            if self.owned[lane] && jobs[self.job_in[lane]].ending.is_none() {
                continue;
            }
            self.owned[lane] = self.next < jobs.len();
            if self.owned[lane] {
                self.put(lane, self.next, jobs);
                (self.next, changed) = (self.next + 1, true);
            }
        }
        if self.owned.iter().filter(|owned| **owned).count() < FEWEST {
            return None;
        }
        let running = self.job_in[self.owned.iter().position(|owned| *owned)?];
        for lane in 0..WIDTH {
            if !self.owned[lane] {
                changed |= self.job_in[lane] != running;
                self.put(lane, running, jobs);
            }
        }
        Some(changed)
    }
}

/// Binds the method to the systems of the runs in the lanes.
fn bind<W>(
    ensemble: &Ensemble<'_>,
    jobs: &[Job<W>],
    job_in: [usize; WIDTH],
) -> Result<Option<Lanes>, InputError> {
    let values = job_in.map(|job| jobs[job].member.value);
    jobs[job_in[0]].member.model.bind_lanes(ensemble.row, ensemble.parameter, values)
}

const _: () = assert!(WIDTH == f64x8::LANES);
