//! Solutions by Taylor series, each computed twice.
//!
//! The defect of every stride is enclosed in an interval, so that no feature of the field is
//! missed. A second run takes other strides, and is perturbed at each by as much as a stride of the
//! first may err. The distance of the two runs thus contains the growth of truncation errors and
//! roundings, in chaos as well. The doubt is twice that distance.

use crate::measured::Doubt;
use crate::progress::Progress;
use crate::solution::twice_apart;
use crate::{Model, Solution};
use afterbay_core::taylor::{InUnits, Pace};
use afterbay_core::{Flow, InputError, IntegrateError, Scalar, State, StateRef};
use afterbay_systems::catalog::{Enclosure, Expandable};
use rayon::prelude::*;
use std::sync::Arc;

/// The least number of times at which the two runs are compared, since they may meet by chance at a
/// single one.
const COMPARED: usize = 256;

/// The largest |log2 h| of a step in the unit 1. A choice: series have 24 terms, so that a
/// coefficient is below 2^960 beside the state, if the motion is 2^10 times faster than the step.
const FAR: f64 = 30.0;

/// The number of progress reports of one solution.
const REPORTS: usize = 200;

/// The most strides of a run, for about half a minute of work on `dof` degrees of freedom.
pub(crate) fn most_strides<T: Scalar>(dof: usize) -> usize {
    let most = if T::IS_EXTENDED { 20_000 } else { 100_000 };
    most / dof.max(1)
}

impl Model {
    /// The solution from `start` at the times `i h`, i = 0..=count, with its doubt. Uses the exact
    /// flow where the system has one, and Taylor series otherwise.
    ///
    /// # Errors
    /// [`InputError::Length`] where `start` does not fit the system, [`InputError::SolutionEnds`]
    /// where the solution ceases to be finite, and [`IntegrateError::Interrupted`].
    pub fn solution<T: Expandable>(
        &self,
        start: &State<Vec<T>>,
        h: T,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Solution<T>, IntegrateError> {
        match self.system::<T>()?.exact_flow() {
            Some(flow) => by_flow(self, &*flow, start, h, count, progress),
            None => by_series(self, start, h, count, progress),
        }
    }
}

/// The solution by the exact flow φ. Its doubt comes from comparing φ(t) with φ(2t/3) ∘ φ(t/3),
/// which differs by roundings only.
fn by_flow<T: Scalar>(
    model: &Model,
    flow: &dyn Flow<T>,
    start: &State<Vec<T>>,
    h: T,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<T>, IntegrateError> {
    let (dof, motors) = (flow.dof(), model.motors());
    start.check(dof)?;
    let at = |i: usize| {
        if progress.stopped() {
            return Err(IntegrateError::Interrupted);
        }
        let t = T::from_f64(i as f64) * h;
        let (mut state, mut twice) = (start.clone(), start.clone());
        flow.carry(t, &mut state);
        state.check(dof).map_err(|_| InputError::SolutionEnds { t: state.t.to_f64() })?;
        let third = t * T::from_f64(1.0 / 3.0);
        flow.carry(third, &mut twice);
        flow.carry(t - third, &mut twice);
        let doubt = twice_apart(state.state_ref(), twice.state_ref(), &motors);
        Ok((state, doubt))
    };
    // All states are computed before the first failure is looked for, so that the earliest is
    // reported.
    let states: Vec<_> = (0..=count).into_par_iter().map(at).collect();
    let mut solution = Solution::with_room(model, count + 1);
    for found in states {
        let (state, doubt) = found?;
        solution.push(state.state_ref());
        solution.doubt_last(doubt);
    }
    Ok(solution)
}

/// The unit of time in which series are computed at steps h: 1, or the power of two next to a step
/// far from 1.
fn unit_of_time(h: f64) -> f64 {
    let power = h.abs().log2().round();
    let is_far = power.abs() > FAR && power.abs() < f64::from(f64::MAX_EXP);
    if is_far { power.exp2() } else { 1.0 }
}

/// The solution by Taylor series at the times `i h`, i = 0..=count.
fn by_series<T: Expandable>(
    model: &Model,
    start: &State<Vec<T>>,
    h: T,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<T>, IntegrateError> {
    let between = COMPARED.div_ceil(count.max(1));
    let (fine_h, fine_count) = (h / T::from_f64(between as f64), count * between);
    let unit = unit_of_time(fine_h.to_f64());
    let (mut system, mut ranges) = model.expanded::<T>()?;
    if unit != 1.0 {
        system = Arc::new(InUnits::new(system, unit));
        ranges = Arc::new(InUnits::new(ranges, unit));
    }
    let (dof, defect) = (system.dof(), Enclosure::new(ranges));
    let [scale, inverse] = [unit, unit.recip()].map(T::from_f64);
    let times = (fine_h * inverse, fine_count);
    let scaled = State {
        w: start.w.iter().map(|&w| w * scale).collect(),
        t: start.t * inverse,
        ..start.clone()
    };
    let run = |pace: Pace, reports: bool| -> Result<Option<Solution<T>>, InputError> {
        let mut states = Solution::with_room(model, fine_count + 1);
        let pace = pace.within(most_strides::<T>(dof));
        let mut w = vec![T::zero(); dof];
        let mut see = |state: StateRef<'_, T>| {
            w.iter_mut().zip(state.w).for_each(|(w, &scaled)| *w = scaled * inverse);
            states.push(StateRef { w: &w, t: state.t * scale, ..state });
            if reports && states.len() % fine_count.div_ceil(REPORTS).max(1) == 0 {
                progress.reference(states.len() as f64 / (fine_count + 1) as f64);
            }
        };
        let stop = || progress.stopped();
        let route = T::follow((&*system, &defect), &scaled, times, pace, &stop, &mut see);
        let route = route.map_err(|error| match error {
            InputError::SolutionEnds { t } => InputError::SolutionEnds { t: t * unit },
            error => error,
        })?;
        Ok((!route.interrupted).then_some(states))
    };
    let (states, check) = rayon::join(|| run(Pace::FULL, true), || run(Pace::CHECK, false));
    let (Some(states), Some(check)) = (states?, check?) else {
        return Err(IntegrateError::Interrupted);
    };
    let mut solution = Solution::with_room(model, count + 1);
    let mut doubt = Doubt::default();
    for (i, (state, check)) in states.states().zip(check.states()).enumerate() {
        doubt = doubt.larger(twice_apart(state, check, solution.motors()));
        if i % between == 0 {
            solution.push(state);
            solution.doubt_last(doubt);
        }
    }
    Ok(solution)
}
