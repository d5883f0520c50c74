//! The first guess of a cycle, from a run of the method.
//!
//! If the system depends on the time, a state is taken once in each of its periods, and the guess
//! is a state and the number of periods after which it repeats. Otherwise the run goes on from a
//! state z* until it crosses the plane through z* normal to its velocity near z*, in the same
//! direction. A run that comes to rest, or does not come back, has no guess.

use super::CycleFailure;
use crate::Model;
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::attractor::{Attractor, Kind, max_norm};
use crate::study::section::{Section, nearest};
use afterbay_core::{Grid, InputError, IntegrateError, State, StateRef};
use afterbay_methods::registry::{Row, Run};
use std::ops::ControlFlow;

/// The periods in time of a system within which states must repeat twice.
const PERIODS: u64 = 64;
/// The largest distance of a return, relative to the extent of the motion. Newton's method
/// converges from it.
const CLOSE: f64 = 0.02;
/// The extent of a motion at rest, relative to the distance it came.
const AT_REST: f64 = 1e-8;
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

/// The guess from a run of a method with steps of nearly h, after a transient.
///
/// # Errors
/// The failure of a step, and the reasons for which there is no guess.
pub(super) fn guess(
    problem: &Problem,
    row: &'static Row,
    h: f64,
    (transient, multiple): (f64, Option<u64>),
    progress: &dyn Progress,
) -> Result<Guess, CycleFailure> {
    if !(transient > 0.0 && transient.is_finite()) {
        return Err(InputError::End { end: transient }.into());
    }
    let model = &problem.model;
    let (run, state) = (model.bind(row)?, problem.start()?);
    let walk = Walk { run, state, dof: model.degrees(), done: 0, progress };
    if model.motors().is_empty() {
        walk.free(model, h, transient)
    } else {
        walk.driven(model, h, (transient, multiple))
    }
}

struct Walk<'a> {
    run: Run<f64>,
    state: State<Vec<f64>>,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
    done: u64,
    progress: &'a dyn Progress,
}

impl Walk<'_> {
    fn driven(
        mut self,
        model: &Model,
        h: f64,
        (transient, multiple): (f64, Option<u64>),
    ) -> Result<Guess, CycleFailure> {
        let grid = Section::Stroboscopic { interval: None }.grid(model, h)?;
        let period = grid.h * grid.steps as f64;
        let first = self.point().concat();
        for _ in 0..(transient / period).ceil() as u64 {
            self.period(grid)?;
        }
        let from = self.point().concat();
        let extent = self.period(grid)?;
        self.is_in_motion(extent, &first, &from)?;
        let multiple = match multiple {
            Some(multiple) => multiple,
            None => {
                let mut points = vec![self.point().concat()];
                for _ in 0..2 * PERIODS {
                    self.period(grid)?;
                    points.push(self.point().concat());
                }
                let attractor = Attractor::of(points, &model.periods(), max_norm(&first));
                match attractor.map(|attractor| attractor.kind) {
                    Some(Kind::Period(multiple)) => multiple as u64,
                    _ => return Err(CycleFailure::NoPeriod { periods: PERIODS }),
                }
            }
        };
        let (z, period) = (self.point().concat(), period * multiple as f64);
        Ok(Guess { z, period, multiple: Some(multiple) })
    }

    /// Takes one period in time, and puts the clock and the motors back to its start. Returns the
    /// largest |q_j - q_j0| or |p_j - p_j0| on the way.
    fn period(&mut self, grid: Grid<f64>) -> Result<f64, CycleFailure> {
        let (from, dof) = (self.point(), self.dof);
        let mut extent = 0.0_f64;
        self.take(grid, &mut |_, state| {
            for (now, from) in [(state.q, &from[0]), (state.p, &from[1])] {
                let off = now[..dof].iter().zip(from).map(|(x, from)| (x - from).abs());
                extent = off.fold(extent, f64::max);
            }
            ControlFlow::Continue(())
        })?;
        let State { q, p, w, t } = &mut self.state;
        q[self.dof..].fill(0.0);
        p[self.dof..].fill(0.0);
        w.fill(0.0);
        *t = 0.0;
        Ok(extent)
    }

    /// Checks that a motion of this extent, which started at `first` and came to `from`, is not at
    /// rest.
    ///
    /// # Errors
    /// [`CycleFailure::AtRest`]
    fn is_in_motion(&self, extent: f64, first: &[f64], from: &[f64]) -> Result<(), CycleFailure> {
        let came = from.iter().zip(first).map(|(a, b)| a - b).collect::<Vec<_>>();
        if extent <= AT_REST * max_norm(&came).max(max_norm(from)) {
            let (q, p) = from.split_at(self.dof);
            return Err(CycleFailure::AtRest { q: q.to_vec(), p: p.to_vec() });
        }
        Ok(())
    }

    fn point(&self) -> [Vec<f64>; 2] {
        [&self.state.q, &self.state.p].map(|part| part[..self.dof].to_vec())
    }

    fn take(
        &mut self,
        grid: Grid<f64>,
        see: &mut dyn FnMut(u64, StateRef<'_, f64>) -> ControlFlow<()>,
    ) -> Result<(), CycleFailure> {
        let (done, progress) = (self.done, self.progress);
        self.run.run(grid, &mut self.state, 1, &mut |step, state| {
            if step % STEPS_BETWEEN_LOOKS == 0 && progress.stopped() {
                return ControlFlow::Break(());
            }
            see(done + step, state)
        })?;
        self.done += grid.steps;
        if progress.stopped() { Err(IntegrateError::Interrupted.into()) } else { Ok(()) }
    }

    fn free(mut self, model: &Model, h: f64, transient: f64) -> Result<Guess, CycleFailure> {
        let grid = Grid::<f64>::of(h, (transient / h).ceil() as u64)?;
        let first = self.point().concat();
        self.take(grid, &mut |_, _| ControlFlow::Continue(()))?;
        let from = self.point().concat();
        let turns = model.periods();
        let off = |state: StateRef<'_, f64>| -> Vec<f64> {
            let now = state.q.iter().chain(state.p).zip(&from).map(|(x, from)| x - from);
            let turned = |(i, off): (usize, f64)| match turns.get(i).copied().flatten() {
                Some(period) => nearest(off, period),
                _ => off,
            };
            now.enumerate().map(turned).collect()
        };
        let mut normal: Option<Vec<f64>> = None;
        let (mut extent, mut closest) = (0.0_f64, f64::INFINITY);
        let mut before: Option<(Vec<f64>, f64)> = None;
        let mut found = None;
        let start = self.done;
        self.take(grid, &mut |step, state| {
            let off = off(state);
            extent = extent.max(max_norm(&off));
            let Some(normal) = &normal else {
                normal = (step > start).then(|| off.clone());
                return ControlFlow::Continue(());
            };
            let height: f64 = normal.iter().zip(&off).map(|(n, x)| n * x).sum();
            if let Some((last, below)) = before.replace((off.clone(), height))
                && below < 0.0
                && height >= 0.0
            {
                let share = below / (below - height);
                let there: Vec<f64> =
                    last.iter().zip(&off).map(|(a, b)| a + share * (b - a)).collect();
                let distance = max_norm(&there) / extent;
                closest = closest.min(distance);
                if distance <= CLOSE {
                    found = Some(((step - start - 1) as f64 + share) * h);
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        })?;
        self.is_in_motion(extent, &first, &from)?;
        let time = h * grid.steps as f64;
        let period = found.ok_or(CycleFailure::NoReturn { nearest: closest, time })?;
        Ok(Guess { z: from, period, multiple: None })
    }
}
