//! The test of convergence of an iteration by the sizes of its updates.
//!
//! An iteration has converged if its next update is below rounding. Where updates shrink by the
//! factor r, the next one is at most r times the last, so it need not be computed. Updates shrink
//! until they are noise; an iteration whose updates no longer shrink has ended, either at the
//! rounding errors of its equations or without a solution.
//!
//! Newton's method for a scalar equation knows its slopes, and predicts the next update more
//! sharply (`newton/two_corrections.rs`).

use crate::numbers::{Mask, Scalar};

/// The largest update that counts as noise, in roundings of the terms of the equation. A choice.
pub(super) const UPDATE_ROUNDINGS: f64 = 64.0;

/// The updates of an iteration so far, lane by lane; usually relative to the size of the solution.
#[derive(Clone, Copy, Debug)]
pub struct Updates<T> {
    last: T,
    before: T,
    smallest: T,
    waited: u32,
}

impl<T: Scalar> Updates<T> {
    /// No update yet.
    #[inline(always)]
    pub fn none() -> Self {
        let unknown = T::from_f64(f64::NAN);
        Self { last: unknown, before: unknown, smallest: T::from_f64(f64::INFINITY), waited: 0 }
    }

    /// Records the size of an update.
    #[inline(always)]
    pub fn see(&mut self, update: T) {
        let shrinks = update.lt(self.smallest);
        self.waited = if shrinks.all() { 0 } else { self.waited + 1 };
        self.smallest = T::select(shrinks, update, self.smallest);
        (self.before, self.last) = (self.last, update);
    }

    /// The last update; NaN if there is none.
    #[inline(always)]
    pub fn last(&self) -> T {
        self.last
    }

    /// The smallest update; infinite if there is none.
    #[inline(always)]
    pub fn smallest(&self) -> T {
        self.smallest
    }

    /// The last update over the one before; NaN if there are less than two.
    #[inline(always)]
    pub fn ratio(&self) -> T {
        self.last / self.before
    }

    /// Whether the next update, predicted as [`Updates::ratio`] times the last, is at most `bound`.
    /// The comparison needs no division; it is true where the last two updates are 0.
    #[inline(always)]
    pub fn next_is_at_most(&self, bound: T) -> T::Mask {
        (self.last * self.last).le(bound * self.before)
    }

    /// Whether the last update did not shrink, lane by lane.
    #[inline(always)]
    pub fn grows(&self) -> T::Mask {
        self.before.le(self.last)
    }

    /// Whether none of the last `count` updates was the smallest so far in every lane.
    #[inline(always)]
    pub fn stalled(&self, count: u32) -> bool {
        self.waited >= count
    }

    /// The number of updates since the last one that was the smallest so far in every lane.
    #[inline(always)]
    pub(crate) fn waited(&self) -> u32 {
        self.waited
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::f64x8;

    fn after(updates: &[f64]) -> Updates<f64> {
        let mut seen = Updates::none();
        updates.iter().for_each(|&update| seen.see(update));
        seen
    }

    #[test]
    fn the_next_update_shrinks_by_the_last_factor() {
        assert!(!after(&[1e-3]).next_is_at_most(1e-16));
        assert!(!after(&[1e-3, 1e-9]).next_is_at_most(1e-16));
        assert!(after(&[1e-3, 1e-9]).next_is_at_most(1.01e-15));
        assert!(after(&[1e-3, 1e-9, 1e-15]).next_is_at_most(1e-16));
        assert!(after(&[1e-3, 0.0]).next_is_at_most(0.0) && after(&[0.0; 2]).next_is_at_most(0.0));
        assert!(!after(&[0.0]).next_is_at_most(0.0));
    }

    #[test]
    fn an_iteration_stalls_without_a_new_smallest_update() {
        assert!(!after(&[1.0, 0.5, 0.25]).stalled(1));
        assert!(after(&[1.0, 2.0, 1.5, 4.0]).stalled(3) && !after(&[1.0, 2.0, 1.5]).stalled(3));
        // A new smallest update restarts the count. NaN does not.
        assert!(!after(&[1.0, 2.0, 1.5, 0.5, 0.7, 0.6]).stalled(3));
        assert!(after(&[1.0, f64::NAN, f64::NAN]).stalled(2));
    }

    #[test]
    fn lanes_shrink_together() {
        let mut seen = Updates::none();
        seen.see(f64x8::from_f64(1.0));
        seen.see(f64x8::from_lanes(|k| if k < 7 { 0.5 } else { 2.0 }));
        assert!(seen.stalled(1) && seen.grows().any() && !seen.grows().all());
        assert_eq!(seen.smallest().lane(7), 1.0);
    }
}
