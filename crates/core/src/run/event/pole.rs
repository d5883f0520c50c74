//! The distinction between a zero and a pole of a function that changes its sign.
//!
//! Near a pole, and at a jump, the function is no smaller than at the ends of the way. At a zero it
//! is smaller, unless the zero lies within roundings of an end. Its value there is a rounding:
//!
//! ```text
//! |f| ≤ 64 ε (|F| + |F| |t|/|Δt| + Σ |∂f/∂z_i| |z_i|)
//! ```
//!
//! F is the value at the end farther from the zero, at which the slopes of f are taken, Δt the time
//! from there to the zero, and z_i are the entries of the state. The second term covers methods
//! that end their steps at numbers of t.

use super::{EVENT_ROUNDINGS, Event, Within};
use crate::system::State;

/// The time after which a zero that lies within roundings of t has been left, in units of the
/// longest step in which all values may be roundings. A choice.
const FAR: f64 = 64.0;

/// A change of sign on the way between two states.
pub(super) struct Crossing<'a> {
    pub(super) way: [&'a State<Vec<f64>>; 2],
    /// The values with different signs.
    pub(super) values: [f64; 2],
    /// The share of the way before the change, and the state there.
    pub(super) share: f64,
    pub(super) there: &'a State<Vec<f64>>,
}

impl Crossing<'_> {
    /// Whether the function has a pole or a jump there.
    pub(super) fn is_pole(&self, event: &Event<'_>, within: Within<'_>) -> bool {
        let [before, after] = self.values.map(f64::abs);
        let found = event.value(self.there).abs();
        if 2.0 * found < before.min(after) {
            return false;
        }
        let [start, end] = self.way;
        let (h, grain) = (end.t - start.t, EVENT_ROUNDINGS * f64::EPSILON * end.t.abs());
        if h > grain {
            return found > self.rounding(event);
        }
        // All values in so short a step may be roundings. They are far larger after a zero.
        let far = within(FAR * grain / h);
        !far.is_ok_and(|far| event.value(&far).abs() > 2.0 * found)
    }

    /// The largest rounding of the function, if it is zero there.
    fn rounding(&self, event: &Event<'_>) -> f64 {
        let Self { way: [start, end], values: [before, after], share, there } = self;
        let (far, size) = if *share < 0.5 { (end, after) } else { (start, before) };
        let (mut probe, value) = ((*far).clone(), event.value(far));
        // Halfway to a pole the function is still finite.
        let mut term = |from: f64, to: f64, set: &dyn Fn(&mut State<Vec<f64>>, f64)| {
            let way = 0.5 * (to - from);
            set(&mut probe, from + way);
            let slope = (event.value(&probe) - value) / way;
            set(&mut probe, from);
            let size = (slope * to).abs();
            if size.is_finite() { size } else { 0.0 }
        };
        let mut sum = term(far.t, there.t, &|probe, t| probe.t = t);
        for j in 0..far.q.len() {
            sum += term(far.q[j], there.q[j], &|probe, q| probe.q[j] = q);
            sum += term(far.p[j], there.p[j], &|probe, p| probe.p[j] = p);
            sum += term(far.w[j], there.w[j], &|probe, w| probe.w[j] = w);
        }
        sum += size.abs() * (1.0 + (there.t / (there.t - far.t)).abs());
        EVENT_ROUNDINGS * f64::EPSILON * if sum.is_finite() { sum } else { 0.0 }
    }
}
