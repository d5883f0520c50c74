//! The exact solution by RK4 over the whole time, with steps halved until no compared quantity
//! changes.
//!
//! One solution serves all methods and all steps h whose runs are about as long, at one value of
//! the parameter. It is not stored: it is observed on its way for all of them, between its own
//! steps by cubic interpolation of values and slopes. Eight values run side by side where the
//! system allows it. If one of them ceases to be finite, each runs alone.

use super::halves::Halves;
use super::image::Image;
use super::measure::{Observation, Observations, Scales, Statistics};
use super::verdict::{SHARE, TOLERANCE};
use super::walk::Walk;
use crate::progress::Progress;
use crate::study::Problem;
use crate::study::side::Side;
use afterbay_core::{Grid, InputError, IntegrateError, System};
use afterbay_methods::registry::Run;
use std::ops::ControlFlow;

/// The accuracy of the reference of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// Halving the step changes the compared quantities by at most a hundredth of what is allowed.
    Resolved,
    /// The compared quantities still change by more at the shortest step.
    Unsettled,
    /// The solution ceases to be finite.
    Leaves,
}

/// The exact solution, as runs are compared with it.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    pub(super) standing: Standing,
    /// Whether it is resolved at each station.
    pub(super) followed: bool,
    /// Whether a step is too long to resolve the motion.
    pub(super) leaps: bool,
    /// Whether no coordinate moves, although forces that are roundings act.
    pub(super) rests: bool,
    pub(super) scales: Scales<f64>,
    /// The mean of A over the second half.
    pub(super) size: f64,
    pub(super) halves: Halves<f64>,
}

/// The references of a map, for each value and step.
#[derive(Clone, Debug)]
pub struct References(pub(super) Vec<Option<Vec<Reference>>>);

impl Reference {
    /// Whether another solution, whose start is displaced, stays near the place where this one
    /// rests.
    fn stays_with(&self, displaced: &Self) -> bool {
        let reach: f64 = self.scales.centre.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = |(a, b): (&f64, &f64)| (a - b).abs() <= GROWN * DISPLACED * reach;
        self.scales.track.places().zip(displaced.scales.track.places()).all(off)
    }

    /// Whether a run has the size and the place of this solution.
    pub(super) fn is_as_large(&self, statistics: &Statistics<f64>) -> bool {
        let means = statistics.halves.last_mean().iter().zip(&self.scales.track.origin);
        let mean: Vec<f64> = means.map(|(off, origin)| off + origin).collect();
        self.agrees(statistics.size, &mean, [TOLERANCE, SHARE])
    }

    /// Whether size and mean agree within the given tolerance and share.
    pub(super) fn agrees(&self, size: f64, mean: &[f64], [tolerance, share]: [f64; 2]) -> bool {
        let Scales { by_reach, centre, .. } = &self.scales;
        let square =
            |parts: &mut dyn Iterator<Item = f64>| parts.map(|x| x * x).sum::<f64>() * by_reach;
        // Rounding keeps a state of rest from being quieter than this.
        let rounding = (1024.0 * f64::EPSILON).powi(2) * square(&mut centre.iter().copied());
        let [found, exact] = [size, self.size].map(|size| size.max(rounding).max(1e-300).ln());
        let off = square(&mut mean.iter().zip(centre).map(|(mean, centre)| mean - centre));
        (found - exact).abs() <= tolerance * (1.0 + exact.abs()) && off.sqrt() <= share
    }
}

/// The steps of the first solution, whatever the unit of time, and the most steps of the last.
const LEAST_STEPS: u64 = 1 << 12;
const MOST_STEPS: u64 = 1 << 21;

/// The change on halving the step at which a solution is resolved, as a share of what a verdict
/// allows: for size and mean, and for the components at the stations. RK4 with half the step has a
/// sixteenth of the error.
const SETTLED: f64 = 0.01;
const STEADY: f64 = 0.1;
/// A rest under forces that are roundings is known if a displacement of this share of q grows by at
/// most this factor. Short steps keep q at rest even where it is unstable, since they add less
/// than a rounding to it.
const DISPLACED: f64 = 1.0 / (1 << 20) as f64;
const GROWN: f64 = 256.0;
/// The number of steps between two checks whether to stop.
const PAUSE: u64 = 1024;

/// An observation of the solution, for one step of a batch.
pub(super) struct Event {
    pub(super) t: f64,
    pub(super) step: usize,
    pub(super) observation: Observation,
}

/// Steps of the map whose runs end at about the same time. Longer runs would ask for longer steps
/// of RK4.
pub(super) struct Batch {
    /// Their indices in the map.
    pub(super) steps: Vec<usize>,
    /// Their observations in order of time.
    events: Vec<Event>,
}

/// The largest ratio of the lengths of two runs in a batch.
const SPAN: f64 = 4.0;

/// Groups all steps of a map into batches.
pub(super) fn batches(steps: &[(f64, &Observations)]) -> Vec<Batch> {
    let end = |&i: &usize| steps[i].0 * steps[i].1.count as f64;
    let mut order: Vec<usize> = (0..steps.len()).collect();
    order.sort_by(|a, b| end(a).total_cmp(&end(b)));
    let mut batches = Vec::new();
    while let Some(first) = order.first() {
        let most = SPAN * end(first);
        let rest = order.split_off(order.partition_point(|i| end(i) <= most).max(1));
        let of_step = |(step, &i): (usize, &usize)| {
            let (h, observations) = steps[i];
            observations.all().map(move |(n, observation)| Event {
                t: h * n as f64,
                step,
                observation,
            })
        };
        let mut events: Vec<Event> = order.iter().enumerate().flat_map(of_step).collect();
        events.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.step.cmp(&b.step)));
        batches.push(Batch { steps: std::mem::replace(&mut order, rest), events });
    }
    batches
}

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
            if let Some(found) = &mut found
                && (mark_resolved(found, before.as_deref()) || last)
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

    /// The references by RK4 with `count` steps, from q displaced by a share; `None` if a number is
    /// not finite.
    fn solution(
        &self,
        end: f64,
        count: u64,
        displaced: f64,
    ) -> Result<Option<Vec<Vec<Reference>>>, InputError> {
        let mut state = self.problem.start::<T>()?;
        state.q.iter_mut().for_each(|q| *q += *q * T::from_f64(displaced));
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
            Ok(_) => Ok(Some((0..T::LANES).map(|k| walk.references(k, &image(k))).collect())),
            Err(IntegrateError::Input(error)) => Err(error),
            Err(IntegrateError::Run(_) | IntegrateError::Interrupted) => Ok(None),
        }
    }
}

/// Marks the references that agree with the ones before as resolved. Returns whether all are.
fn mark_resolved(found: &mut [Vec<Reference>], before: Option<&[Vec<Reference>]>) -> bool {
    let Some(before) = before else { return false };
    let mut all = true;
    for (found, before) in found.iter_mut().flatten().zip(before.iter().flatten()) {
        let mean = &found.scales.centre;
        if found.leaps {
            all = false;
            continue;
        }
        if before.agrees(found.size, mean, [SETTLED * TOLERANCE, SETTLED * SHARE]) {
            found.standing = Standing::Resolved;
        }
        found.followed = before.scales.track.agrees(&found.scales.track, STEADY);
        all &= found.standing == Standing::Resolved && found.followed;
    }
    all
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
