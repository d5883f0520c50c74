//! Eight runs side by side, over whole intervals of a stroboscopic section.

use super::{Ensemble, Job, Watch, alone};
use crate::Lanes;
use crate::study::section::rewind;
use crate::study::side::{Side, put_state, state_of};
use afterbay_core::{Grid, InputError, IntegrateError, Scalar, State, f64x8};

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
    let splat = |part: &[f64]| part.iter().map(|&x| f64x8::from_f64(x)).collect();
    let State { q, p, w, t } = &first.state;
    let mut all = State { q: splat(q), p: splat(p), w: splat(w), t: f64x8::from_f64(*t) };
    // The run in each lane, and whether the lane is its own: lanes without a run repeat another's.
    let (mut job_in, mut owned) = ([0; WIDTH], [false; WIDTH]);
    let mut next = 0;
    let mut bound = None;
    loop {
        let mut changed = false;
        for lane in 0..WIDTH {
            if owned[lane] && jobs[job_in[lane]].ending.is_none() {
                continue;
            }
            owned[lane] = next < jobs.len();
            if owned[lane] {
                (job_in[lane], changed) = (next, true);
                put_state(&mut all, lane, &jobs[next].state);
                next += 1;
            }
        }
        let Some(running) = (0..WIDTH).find(|&lane| owned[lane]) else { return Ok(()) };
        if (0..WIDTH).filter(|&lane| owned[lane]).count() < FEWEST {
            return Ok(());
        }
        for lane in (0..WIDTH).filter(|&lane| !owned[lane]) {
            changed |= job_in[lane] != job_in[running];
            job_in[lane] = job_in[running];
            put_state(&mut all, lane, &jobs[job_in[running]].state);
        }
        if changed || bound.is_none() {
            bound = bind(ensemble, jobs, job_in)?;
        }
        let Some(Lanes { run, .. }) = &bound else { return Ok(()) };
        let grid = Grid { h: f64x8::gather(|lane| jobs[job_in[lane]].grid.h), steps };
        let good =
            match run.run(grid, &mut all, steps, &mut |_, _| std::ops::ControlFlow::Continue(())) {
                Ok(_) => steps,
                Err(IntegrateError::Run(error)) => error.step - 1,
                Err(IntegrateError::Input(error)) => return Err(error),
                Err(IntegrateError::Interrupted) => return Ok(()),
            };
        for lane in (0..WIDTH).filter(|&lane| owned[lane]) {
            let job = &mut jobs[job_in[lane]];
            job.state = state_of(&all, lane);
            if good < steps {
                alone::finish(job, steps - good)?;
            }
            if job.ending.is_none() {
                job.state.t = job.grid.h * steps as f64;
                job.arrive(ensemble.progress);
                job.begin_interval();
                put_state(&mut all, lane, &job.state);
            }
        }
        rewind(&mut all.q, &mut all.t, dof);
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
