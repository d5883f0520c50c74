//! The first guess of a cycle, from a run of the method.
//!
//! If the system depends on the time, a state is taken once in each of its periods, and the guess
//! is a state and the number of periods after which it repeats. Otherwise the run goes on from a
//! state z* until it crosses the plane through z* normal to its velocity near z*, in the same
//! direction. A step of the run that crosses it is taken again in part, to end in the plane: on a
//! chord between the ends of a coarse step the distance from z* would be too large. A run that
//! comes to rest, or does not come back, has no guess.

use super::CycleFailure;
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::attractor::first_return;
use crate::study::metric::Metric;
use crate::study::motion::Motion;
use crate::study::section::{Section, point};
use crate::study::zero::at_zero;
use afterbay_core::{Grid, InputError, IntegrateError, State, StateRef};
use afterbay_methods::registry::{Row, Run};
use std::ops::ControlFlow;

/// The periods in time of a system within which states must repeat twice.
const PERIODS: u64 = 64;
/// The largest distance of a return. Newton's method converges from it.
const CLOSE: f64 = 0.02;
/// Steps between two looks at whether the user wants to stop.
const STEPS_BETWEEN_LOOKS: u64 = 1024;

/// A state near a cycle and its period.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    /// q and p.
    pub(super) z: Vec<f64>,
    /// The period.
    pub(super) period: f64,
    /// The periods in time of the system in it; none for a system that does not depend on time.
    pub(super) multiple: Option<u64>,
}

/// The guess from a run of a method with steps of nearly h, after a transient. `multiple` is the
/// number of periods of the drive in that of the cycle, if it is known.
///
/// # Errors
/// The failure of a step, and the reasons for which there is no guess.
pub(super) fn guess(
    problem: &Problem,
    row: &'static Row,
    h: f64,
    transient: f64,
    multiple: Option<u64>,
    progress: &dyn Progress,
) -> Result<Guess, CycleFailure> {
    if !(transient > 0.0 && transient.is_finite()) {
        return Err(InputError::End { end: transient }.into());
    }
    let model = &problem.model;
    let (run, state) = (model.bind(row)?, problem.start()?);
    let (dof, periods) = (model.degrees(), model.periods());
    let walk = Walk { run, state, dof, periods, motion: Motion::new(dof), done: 0, progress };
    if model.motors().is_empty() {
        walk.free(&model.bind(row)?, h, transient)
    } else {
        let grid = Section::Stroboscopic { interval: None }.grid_of(row, model, h)?;
        walk.driven(grid, transient, multiple)
    }
}

/// Receives the number of a step, the state after it, and the motion until then.
type See<'a> = dyn FnMut(u64, StateRef<'_, f64>, &Motion) -> ControlFlow<()> + 'a;

struct Walk<'a> {
    run: Run<f64>,
    state: State<Vec<f64>>,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
    /// The periods of the coordinates that have one.
    periods: Vec<Option<f64>>,
    motion: Motion,
    done: u64,
    progress: &'a dyn Progress,
}

impl Walk<'_> {
    fn driven(
        mut self,
        grid: Grid<f64>,
        transient: f64,
        multiple: Option<u64>,
    ) -> Result<Guess, CycleFailure> {
        let period = grid.h * grid.steps as f64;
        for _ in 0..(transient / period).ceil() as u64 {
            self.period(grid)?;
        }
        self.motion.settle();
        self.period(grid)?;
        self.is_in_motion()?;
        let multiple = match multiple {
            Some(multiple) => multiple,
            None => {
                let mut points = vec![self.point()];
                for _ in 0..2 * PERIODS {
                    self.period(grid)?;
                    points.push(self.point());
                }
                let found = first_return(&points, &self.metric());
                found.ok_or(CycleFailure::NoPeriod { periods: PERIODS })? as u64
            }
        };
        let (z, period) = (self.point(), period * multiple as f64);
        Ok(Guess { z, period, multiple: Some(multiple) })
    }

    /// Takes one period in time, and puts the clock and the motors back to its start.
    fn period(&mut self, grid: Grid<f64>) -> Result<(), CycleFailure> {
        self.take(grid, &mut |_, _, _| ControlFlow::Continue(()))?;
        let State { q, p, w, t } = &mut self.state;
        q[self.dof..].fill(0.0);
        p[self.dof..].fill(0.0);
        w.fill(0.0);
        *t = 0.0;
        Ok(())
    }

    /// Checks that the motion after the transient is not at rest.
    ///
    /// # Errors
    /// [`CycleFailure::AtRest`]
    fn is_in_motion(&self) -> Result<(), CycleFailure> {
        if self.metric().is_at_rest() {
            let (q, p) = (self.state.q[..self.dof].to_vec(), self.state.p[..self.dof].to_vec());
            return Err(CycleFailure::AtRest { q, p });
        }
        Ok(())
    }

    /// The distance of states of the motion after the transient.
    fn metric(&self) -> Metric {
        self.motion.metric(&self.periods)
    }

    /// q and p.
    fn point(&self) -> Vec<f64> {
        point(&self.periods, self.dof, self.state.state_ref()).concat()
    }

    /// Takes steps, and shows each state.
    fn take(&mut self, grid: Grid<f64>, see: &mut See<'_>) -> Result<(), CycleFailure> {
        let Self { run, state, motion, done, progress, .. } = self;
        run.run(grid, state, 1, &mut |step, state| {
            if step % STEPS_BETWEEN_LOOKS == 0 && progress.stopped() {
                return ControlFlow::Break(());
            }
            motion.see(state);
            see(*done + step, state, motion)
        })?;
        *done += grid.steps;
        if progress.stopped() { Err(IntegrateError::Interrupted.into()) } else { Ok(()) }
    }

    /// `within` takes the parts of steps that end in the plane.
    fn free(mut self, within: &Run<f64>, h: f64, transient: f64) -> Result<Guess, CycleFailure> {
        let grid = Grid::<f64>::of(h, (transient / h).ceil() as u64)?;
        self.take(grid, &mut |_, _, _| ControlFlow::Continue(()))?;
        let plane = Plane { from: self.point(), of_run: self.metric(), dof: self.dof };
        let periods = self.periods.clone();
        self.motion.settle();
        let mut normal: Option<Vec<f64>> = None;
        // A motion is nowhere further from a state on it than its extent.
        let mut closest = 1.0_f64;
        let mut before: Option<(State<Vec<f64>>, f64)> = None;
        let mut found = None;
        let start = self.done;
        self.take(grid, &mut |step, state, motion| {
            let Some(normal) = &normal else {
                normal = (step > start).then(|| plane.normal(state));
                return ControlFlow::Continue(());
            };
            let height = plane.height(normal, state);
            if let Some((last, below)) = before.replace((owned(state), height))
                && below < 0.0
                && height >= 0.0
            {
                let of = |state: StateRef<'_, f64>| plane.height(normal, state);
                let there = at_zero(within, h, of, &last, state);
                let distance = motion.metric(&periods).largest(&plane.off(there.state_ref()));
                closest = closest.min(distance);
                if distance <= CLOSE {
                    found = Some((step - start - 1) as f64 * h + (there.t - last.t));
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        })?;
        self.is_in_motion()?;
        let time = h * grid.steps as f64;
        let period = found.ok_or(CycleFailure::NoReturn { nearest: closest, time })?;
        Ok(Guess { z: plane.from, period, multiple: None })
    }
}

fn owned(state: StateRef<'_, f64>) -> State<Vec<f64>> {
    let StateRef { q, p, w, t } = state;
    State { q: q.to_vec(), p: p.to_vec(), w: w.to_vec(), t }
}

/// Planes through a state.
struct Plane {
    /// The state z*.
    from: Vec<f64>,
    /// The distance of states of the whole run.
    of_run: Metric,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
}

impl Plane {
    /// z - z*
    fn off(&self, state: StateRef<'_, f64>) -> Vec<f64> {
        let z = point(self.of_run.periods(), self.dof, state).concat();
        self.of_run.difference(&self.from, &z).collect()
    }

    /// The normal of the plane in front of a state, in units of the run. An entry at rest does not
    /// count.
    fn normal(&self, state: StateRef<'_, f64>) -> Vec<f64> {
        let weight = |extent: f64| if extent > 0.0 { (extent * extent).recip() } else { 0.0 };
        let weights = self.of_run.moving_units().into_iter().map(weight);
        self.off(state).into_iter().zip(weights).map(|(x, weight)| x * weight).collect()
    }

    /// The height of a state above the plane.
    fn height(&self, normal: &[f64], state: StateRef<'_, f64>) -> f64 {
        normal.iter().zip(self.off(state)).map(|(n, x)| n * x).sum()
    }
}
