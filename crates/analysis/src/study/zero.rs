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
    let ends = (distance(before.state_ref()), distance(after));
    let mut end = before.clone();
    copy(after, &mut end);
    let within = |share: f64| {
        let mut there = before.clone();
        run.step(share * h, &mut there).ok()?;
        there.t = before.t + share * h;
        Some((distance(there.state_ref()), there))
    };
    zero_within(ends, end, within).1
}

/// Copies a state.
pub(in crate::study) fn copy(from: StateRef<'_, f64>, to: &mut State<Vec<f64>>) {
    let parts = [(from.q, &mut to.q), (from.p, &mut to.p), (from.w, &mut to.w)];
    parts.into_iter().for_each(|(from, to)| to.copy_from_slice(from));
    to.t = from.t;
}
