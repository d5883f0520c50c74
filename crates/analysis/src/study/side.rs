//! Numbers side by side, with access to each.

use afterbay_core::{Scalar, State, f64x8};

/// A number, or eight side by side with access to each.
pub(in crate::study) trait Side: Scalar {
    /// Replaces the number in lane k by x.
    fn with(self, k: usize, x: f64) -> Self;
    /// Built from the number of each lane.
    fn gather(each: impl Fn(usize) -> f64) -> Self {
        (0..Self::LANES).fold(Self::zero(), |all, k| all.with(k, each(k)))
    }
}

impl Side for f64 {
    fn with(self, _k: usize, x: f64) -> f64 {
        x
    }
}

impl Side for f64x8 {
    fn with(self, k: usize, x: f64) -> Self {
        let mut lanes = self.to_array();
        lanes[k] = x;
        Self::from(lanes)
    }
}

/// Lane k of many numbers.
pub(in crate::study) fn lane_of<T: Side>(all: &[T], k: usize) -> Vec<f64> {
    all.iter().map(|x| x.lane(k)).collect()
}

/// Puts numbers into lane k.
pub(in crate::study) fn put_lane<T: Side>(all: &mut [T], k: usize, one: &[f64]) {
    all.iter_mut().zip(one).for_each(|(x, &one)| *x = x.with(k, one));
}

/// The state in lane k.
pub(in crate::study) fn state_of<T: Side>(all: &State<Vec<T>>, k: usize) -> State<Vec<f64>> {
    State { q: lane_of(&all.q, k), p: lane_of(&all.p, k), w: lane_of(&all.w, k), t: all.t.lane(k) }
}

/// Puts a state into lane k.
pub(in crate::study) fn put_state<T: Side>(
    all: &mut State<Vec<T>>,
    k: usize,
    one: &State<Vec<f64>>,
) {
    let parts = [(&mut all.q, &one.q), (&mut all.p, &one.p), (&mut all.w, &one.w)];
    parts.into_iter().for_each(|(all, one)| put_lane(all, k, one));
    all.t = all.t.with(k, one.t);
}
