//! The exact solution by RK4 over the whole time, with steps halved until no compared quantity
//! changes.
//!
//! One solution serves all methods and all steps h whose runs are about as long, at one value of
//! the parameter. It is not stored: it is observed on its way for all of them, between its own
//! steps by cubic interpolation of values and slopes. Eight values run side by side where the
//! system allows it. If one of them ceases to be finite, each runs alone.

use super::batch::Batch;
use super::image::Image;
use super::reference::{DISPLACED, Reference, Standing};
use super::thresholds::{SHARE, TOLERANCE};
use super::walk::Walk;
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::side::Side;
use afterbay_core::{Grid, InputError, IntegrateError, System};
use afterbay_methods::registry::Run;
use std::ops::ControlFlow;

/// The steps of the first solution, whatever the unit of time, and the most steps of the last.
const LEAST_STEPS: u64 = 1 << 12;
const MOST_STEPS: u64 = 1 << 21;

/// The change on halving the step at which a solution is resolved, as a share of what a verdict
/// allows: for size and mean, and for the components at the stations. RK4 with half the step has a
/// sixteenth of the error.
const SETTLED: f64 = 0.01;
const STEADY: f64 = 0.1;
/// The number of steps between two checks whether to stop.
const PAUSE: u64 = 1024;

/// One value or eight, with the batch of steps for which references are computed.
pub(super) struct Exact<'a, T: Side> {
    pub(super) problem: &'a Problem,
    pub(super) run: &'a Run<T>,
    pub(super) system: &'a dyn System<T>,
    pub(super) batch: &'a Batch,
    /// The image of each lane.
    pub(super) images: &'a [Image<f64>],
    pub(super) progress: &'a dyn Progress,
}

impl<T: Side> Exact<'_, T> {
    /// The references of every lane and step. `None` if a solution ceases to be finite, if the
    /// lanes compare different components, or if the user asked to stop.
    pub(super) fn references(&self) -> Result<Option<Vec<Vec<Reference>>>, InputError> {
        let Some(end) = self.batch.events.last().map(|event| event.t) else {
            return Ok(Some(vec![vec![]; T::LANES]));
        };
        let mut count = LEAST_STEPS;
        let mut before: Option<Vec<Vec<Reference>>> = None;
        loop {
            let last = count >= MOST_STEPS;
            let mut found = self.solution(end, count, 0.0)?;
            if let (Some(found), Some(before)) = (&mut found, &before) {
                self.find_floors(found, end, count)?;
                mark_resolved(found, before);
            }
            if let Some(found) = &mut found
                && (last || found.iter().flatten().all(Reference::is_resolved))
            {
                self.doubt_rests(found, end, count)?;
                return Ok(Some(std::mem::take(found)));
            }
            if last || self.progress.stopped() {
                return Ok(None);
            }
            before = found;
            count *= 2;
        }
    }

    /// Finds the sizes below which roundings decide: another solution, whose start is displaced,
    /// decays to another size there.
    fn find_floors(
        &self,
        found: &mut [Vec<Reference>],
        end: f64,
        count: u64,
    ) -> Result<(), InputError> {
        if !found.iter().flatten().any(Reference::has_decayed) {
            return Ok(());
        }
        let displaced = self.solution(end, count, DISPLACED)?.unwrap_or_default();
        for (found, displaced) in found.iter_mut().flatten().zip(displaced.iter().flatten()) {
            found.find_floor(displaced);
        }
        Ok(())
    }

    /// Marks those that rest where a displacement grows as not settled: roundings decide when the
    /// motion leaves.
    fn doubt_rests(
        &self,
        found: &mut [Vec<Reference>],
        end: f64,
        count: u64,
    ) -> Result<(), InputError> {
        if !found.iter().flatten().any(|found| found.rests) {
            return Ok(());
        }
        let beside = self.solution(end, count, DISPLACED)?.unwrap_or_default();
        let mut beside = beside.iter().flatten();
        for found in found.iter_mut().flatten() {
            let near = |beside: &Reference| found.stays_with(beside);
            if !beside.next().is_some_and(near) && found.rests {
                found.standing = Standing::Unsettled;
            }
        }
        Ok(())
    }

    /// The references by RK4 with `count` steps, from q and p displaced by a share; `None` if a
    /// number is not finite.
    fn solution(
        &self,
        end: f64,
        count: u64,
        displaced: f64,
    ) -> Result<Option<Vec<Vec<Reference>>>, InputError> {
        let mut state = self.problem.start::<T>()?;
        let numbers = state.q.iter_mut().chain(&mut state.p);
        numbers.for_each(|x| *x += *x * T::from_f64(displaced));
        let dof = state.dof();
        let length = end / count as f64;
        let image = |k: usize| self.images[k.min(self.images.len() - 1)].clone();
        let Some(beside) = Image::beside(image) else { return Ok(None) };
        let mut walk = Walk::new(self.system, beside, dof, self.batch.steps.len());
        let mut events = self.batch.events.iter().peekable();
        let ended = self.run.run(Grid::<T>::of(length, count)?, &mut state, 1, &mut |n, state| {
            walk.arrive(state);
            // The last step reaches the end only up to rounding.
            let t = if n < count { length * n as f64 } else { f64::INFINITY };
            while let Some(event) = events.next_if(|event| n > 0 && event.t <= t) {
                walk.observe(event, event.t / length - (n - 1) as f64, length);
            }
            if n % PAUSE == 0 && self.progress.stopped() {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        match ended {
            Ok(_) if self.progress.stopped() => Ok(None),
            Ok(_) => {
                let of = |k| walk.references(k, &image(k));
                let mut found: Vec<Vec<_>> = (0..T::LANES).map(of).collect();
                found.iter_mut().flatten().for_each(|found| found.allow_roundings(count));
                Ok(Some(found))
            }
            Err(IntegrateError::Input(error)) => Err(error),
            Err(IntegrateError::Run(_) | IntegrateError::Interrupted) => Ok(None),
        }
    }
}

/// Marks the references that agree with those of half as many steps as resolved, and keeps those
/// that were resolved: further steps only add roundings.
fn mark_resolved(found: &mut [Vec<Reference>], before: &[Vec<Reference>]) {
    for (found, before) in found.iter_mut().flatten().zip(before.iter().flatten()) {
        if before.is_resolved() {
            found.clone_from(before);
        } else if !found.leaps {
            let allowed = [SETTLED * TOLERANCE, SETTLED * SHARE];
            if found.agrees(before.size, &before.scales.centre, allowed) {
                found.standing = Standing::Resolved;
            }
            found.followed = before.scales.track.agrees(&found.scales.track, STEADY);
        }
    }
}

/// References where the solution ceases to be finite. Their sizes are those of the start.
pub(super) fn of_start(
    problem: &Problem,
    system: &dyn System<f64>,
    image: &Image<f64>,
    steps: usize,
) -> Result<Vec<Reference>, InputError> {
    let state = problem.start::<f64>()?;
    let mut walk = Walk::new(system, image.clone(), state.dof(), 1);
    walk.arrive(state.state_ref());
    let of_start = walk.of_start(0, image);
    let leaves = |start: Reference| Reference { standing: Standing::Leaves, ..start };
    Ok(of_start.map_or(Vec::new(), |start| vec![leaves(start); steps]))
}
