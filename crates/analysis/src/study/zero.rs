//! The state within a step at which a function of the state is zero.

use afterbay_core::{State, StateRef};
use afterbay_methods::registry::Run;

/// The most corrections of the length of the step. Bisection alone would take 53.
const MOST_CORRECTIONS: usize = 100;

/// The state between two states, h apart, at which `distance` is zero: the end of a shorter step from
/// the first. Regula falsi with the rule of Illinois (Dowell and Jarratt 1971) finds its length to
/// rounding.
pub(in crate::study) fn at_zero(
    run: &Run<f64>,
    h: f64,
    distance: impl Fn(StateRef<'_, f64>) -> f64,
    (before, mut off): (&State<Vec<f64>>, f64),
    (after, mut beyond): (StateRef<'_, f64>, f64),
) -> State<Vec<f64>> {
    let mut found = before.clone();
    copy(after, &mut found);
    let (mut low, mut high, mut nearest) = (0.0, 1.0, beyond.abs());
    let mut moved = None;
    for _ in 0..MOST_CORRECTIONS {
        let share: f64 = (low * beyond - high * off) / (beyond - off);
        if nearest == 0.0 || !(low < share && share < high) {
            break;
        }
        let mut state = before.clone();
        // Where the shorter step fails, the nearest state so far is taken.
        if run.step(share * h, &mut state).is_err() {
            break;
        }
        state.t = before.t + share * h;
        let now = distance(state.state_ref());
        let is_beyond = (now > 0.0) == (beyond > 0.0);
        if is_beyond {
            (high, beyond) = (share, now);
            off *= if moved == Some(true) { 0.5 } else { 1.0 };
        } else {
            (low, off) = (share, now);
            beyond *= if moved == Some(false) { 0.5 } else { 1.0 };
        }
        moved = Some(is_beyond);
        if now.abs() < nearest {
            (nearest, found) = (now.abs(), state);
        }
    }
    found
}

/// Copies a state.
pub(in crate::study) fn copy(from: StateRef<'_, f64>, to: &mut State<Vec<f64>>) {
    let parts = [(from.q, &mut to.q), (from.p, &mut to.p), (from.w, &mut to.w)];
    parts.into_iter().for_each(|(from, to)| to.copy_from_slice(from));
    to.t = from.t;
}
