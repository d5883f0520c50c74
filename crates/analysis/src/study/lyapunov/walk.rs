//! A run along which displacements are taken.

use super::growth::{Divergence, Frame, Growth, Stop};
use crate::progress::{Piece, Progress};
use crate::study::Problem;
use crate::study::metric::difference;
use crate::study::outcome::Ending;
use crate::study::section::point;
use crate::study::tangent::Tangent;
use afterbay_core::{Grid, InputError, IntegrateError, State};
use afterbay_methods::registry::{Row, Run};
use std::ops::ControlFlow;

/// Steps between two looks at whether the user wants to stop.
const STEPS_BETWEEN_LOOKS: u64 = 1024;

/// A run under way.
pub(super) struct Walk<'a> {
    run: Run<f64>,
    tangent: Tangent,
    divergence: Divergence,
    frame: Frame,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
    periods: Vec<Option<f64>>,
    h: f64,
    state: State<Vec<f64>>,
    /// q and p where the measurement begins.
    pub(super) from: Vec<f64>,
    /// The steps done, and all that will be.
    done: u64,
    all: u64,
    progress: &'a dyn Progress,
}

impl<'a> Walk<'a> {
    /// A run that will take `all` steps of size h.
    pub(super) fn new(
        problem: &Problem,
        row: &'static Row,
        h: f64,
        all: u64,
        progress: &'a dyn Progress,
    ) -> Result<Self, InputError> {
        let (model, state) = (&problem.model, problem.start()?);
        let dof = model.degrees();
        let (run, tangent) = (model.bind(row)?, Tangent::new(model, row)?);
        let (divergence, frame) = (Divergence::new(model)?, Frame::new(2 * dof));
        let (periods, from, done) = (model.periods(), Vec::new(), 0);
        let walk = Self {
            run,
            tangent,
            divergence,
            frame,
            dof,
            periods,
            h,
            state,
            from,
            done,
            all,
            progress,
        };
        Ok(walk)
    }

    /// q and p of the state.
    pub(super) fn point(&self) -> Vec<f64> {
        point(&self.periods, self.dof, self.state.state_ref()).concat()
    }

    /// Takes steps. With `growth` the tangent vectors are taken along. The trajectory is that of
    /// the method in `f64`, as every other study has it; only the derivatives are taken in 106
    /// bits.
    ///
    /// # Errors
    /// The failure that ended the run before all steps were done.
    pub(super) fn take(
        &mut self,
        steps: u64,
        mut growth: Option<&mut Growth>,
        piece: &mut Piece<'_>,
    ) -> Result<(), Ending> {
        if steps == 0 {
            return Ok(());
        }
        self.rewind();
        let Self { run, tangent, divergence, frame, state, progress, h, done, all, .. } = self;
        let (periods, dof, from) = (&self.periods, self.dof, &self.from);
        let (grid, stride) =
            (Grid { h: *h, steps }, if growth.is_some() { 1 } else { STEPS_BETWEEN_LOOKS });
        let mut broken = Ok(());
        let result = run.run(grid, state, stride, &mut |step, state| {
            piece.report(*done + step, *all);
            if let Some(growth) = &mut growth {
                let at = point(periods, dof, state).concat();
                let off = difference(periods, from, &at).map(f64::abs);
                for (farthest, off) in growth.farthest.iter_mut().zip(off) {
                    *farthest = farthest.max(off);
                }
            }
            broken = match &mut growth {
                _ if step % STEPS_BETWEEN_LOOKS == 0 && progress.stopped() => {
                    Err(Stop::Run(IntegrateError::Interrupted))
                }
                Some(growth) if step < steps => frame
                    .step(tangent, divergence, grid.h, state, growth)
                    .map_err(|stop| stop.after(step)),
                _ => Ok(()),
            };
            if broken.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let result = result.map_err(Stop::Run).and(broken);
        let before = std::mem::replace(done, *done + steps);
        result.map_err(|stop| stop.after(before).ending())
    }

    /// Sets the motors of a drive to the time, which is not accumulated, and empties all accounts.
    /// Neither changes (q, p).
    fn rewind(&mut self) {
        let State { q, p, w, t } = &mut self.state;
        *t = self.h * self.done as f64;
        q[self.dof..].fill(*t);
        p[self.dof..].fill(0.0);
        w.fill(0.0);
    }
}
