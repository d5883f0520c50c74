//! The state within a step at which a function of the state is zero.

use afterbay_core::solver::zero_within;
use afterbay_core::{State, StateRef};
use afterbay_methods::registry::Run;

/// The state between two states, h apart, at which `distance` is zero: the end of a shorter step
/// from the first. The distances of the two states have different signs.
pub(in crate::study) fn at_zero(
    run: &Run<f64>,
    h: f64,
    distance: impl Fn(StateRef<'_, f64>) -> f64,
    before: &State<Vec<f64>>,
    after: StateRef<'_, f64>,
) -> State<Vec<f64>> {
    let mut end = before.clone();
    copy(after, &mut end);
    at_zero_in_part(run, h, distance, before, [(0.0, before), (1.0, &end)])
}

/// [`at_zero`] between two states within the step from `start`, each at its share of h.
pub(in crate::study) fn at_zero_in_part(
    run: &Run<f64>,
    h: f64,
    distance: impl Fn(StateRef<'_, f64>) -> f64,
    start: &State<Vec<f64>>,
    [(from, before), (to, after)]: [(f64, &State<Vec<f64>>); 2],
) -> State<Vec<f64>> {
    let ends = (distance(before.state_ref()), distance(after.state_ref()));
    let within = |part: f64| {
        let share = from + part * (to - from);
        let there = step_part(run, share * h, start)?;
        Some((distance(there.state_ref()), there))
    };
    zero_within(ends, after.clone(), within).1
}

/// The state at the end of a shorter step; none if it fails.
pub(in crate::study) fn step_part(
    run: &Run<f64>,
    part: f64,
    start: &State<Vec<f64>>,
) -> Option<State<Vec<f64>>> {
    let mut there = start.clone();
    run.step(part, &mut there).ok()?;
    there.t = start.t + part;
    Some(there)
}

/// Copies a state.
pub(in crate::study) fn copy(from: StateRef<'_, f64>, to: &mut State<Vec<f64>>) {
    let parts = [(from.q, &mut to.q), (from.p, &mut to.p), (from.w, &mut to.w)];
    parts.into_iter().for_each(|(from, to)| to.copy_from_slice(from));
    to.t = from.t;
}
