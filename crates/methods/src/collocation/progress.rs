//! The stopping criterion of an iteration.
//!
//! Changes shrink until they are noise. An iteration has converged if the next change would be
//! below rounding, or if changes of a few roundings no longer shrink. It is stopped as divergent if
//! larger changes no longer shrink.

use afterbay_core::solver::Updates;

/// The largest number of iterations.
pub(super) const MOST_ITERATIONS: u32 = 100;
/// An iteration has converged after this number of changes without a new smallest one, if the last
/// is at most [`CHANGE_ROUNDINGS`].
const STALLED_IN_NOISE: u32 = 3;
/// An iteration has converged after this number of changes without a new smallest one, if the last
/// is at most [`DIVERGENT_ROUNDINGS`]: slowly converging changes may pause temporarily.
const STALLED_ABOVE_NOISE: u32 = 10;
/// The largest change, in roundings, that may be due to the rounding of z.
const CHANGE_ROUNDINGS: f64 = 8.0;
/// The number of roundings above which changes that no longer shrink diverge.
const DIVERGENT_ROUNDINGS: f64 = 1024.0;
/// Changes up to this number of roundings may be noise.
const CLEAR_ROUNDINGS: f64 = 64.0;
/// The size of the next change, in roundings, below which it is omitted. A change omitted at every
/// step makes K drift by its size: with 1/64, K of a chain drifted in proportion to time. 1/512
/// takes 5 % more evaluations than 1/64.
const OMITTED_ROUNDINGS: f64 = 1.0 / 512.0;

/// The changes so far, relative to the size of z, in a scalar with unit roundoff ε.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress<'a> {
    updates: &'a Updates<f64>,
    epsilon: f64,
}

impl<'a> Progress<'a> {
    #[inline(always)]
    pub(super) fn of(updates: &'a Updates<f64>, epsilon: f64) -> Self {
        Self { updates, epsilon }
    }

    /// Whether the last change is above noise level.
    #[inline(always)]
    pub(super) fn is_clear(&self) -> bool {
        self.updates.last() > CLEAR_ROUNDINGS * self.epsilon
    }

    /// Whether the iteration has converged: changes that shrink by `rate` leave an error below
    /// rounding after the estimate `left`, or the changes are noise.
    #[inline(always)]
    pub(super) fn has_arrived(&self, rate: f64, left: f64) -> bool {
        let roundings = self.updates.last() / self.epsilon;
        self.updates.last() == 0.0
            || (rate < 0.5 && left * rate <= OMITTED_ROUNDINGS * self.epsilon)
            || (roundings <= CHANGE_ROUNDINGS && self.updates.stalled(STALLED_IN_NOISE))
            || (roundings <= DIVERGENT_ROUNDINGS && self.updates.stalled(STALLED_ABOVE_NOISE))
    }

    /// Whether the last change may be due to the rounding of z.
    #[inline(always)]
    pub(super) fn is_rounding(&self) -> bool {
        self.updates.last() <= CHANGE_ROUNDINGS * self.epsilon
    }

    /// Whether the last `count` changes were above noise level and none was a new smallest one.
    #[inline(always)]
    pub(super) fn diverges(&self, count: u32) -> bool {
        self.updates.stalled(count) && self.updates.last() > DIVERGENT_ROUNDINGS * self.epsilon
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit roundoff of `f64`.
    const EPSILON: f64 = f64::EPSILON / 2.0;

    fn after(changes: &[f64]) -> Updates<f64> {
        let mut updates = Updates::none();
        changes.iter().for_each(|&change| updates.see(change));
        updates
    }

    #[test]
    fn the_next_change_is_omitted_once_it_is_below_rounding() {
        let arrived = |changes: &[f64]| {
            let updates = after(changes);
            Progress::of(&updates, EPSILON).has_arrived(updates.ratio(), updates.last())
        };
        // The next changes are about 1e-15 and 1e-21.
        assert!(!arrived(&[1e-3, 1e-9]));
        assert!(arrived(&[1e-3, 1e-9, 1e-15]));
        // About 1e-18: below 1/64 of a rounding, above 1/512.
        assert!(!arrived(&[1e-6, 1e-12]));
        // A ratio near 1 predicts nothing.
        assert!(!arrived(&[1e-18 / 0.75, 1e-18]));
        assert!(arrived(&[1e-3, 0.0]));
    }

    #[test]
    fn small_changes_that_no_longer_shrink_are_noise() {
        let arrived = |roundings: f64, changes: usize| {
            let updates = after(&vec![roundings * EPSILON; changes]);
            let progress = Progress::of(&updates, EPSILON);
            assert!(!progress.diverges(3) || roundings > DIVERGENT_ROUNDINGS);
            progress.has_arrived(1.0, f64::INFINITY)
        };
        // The first change is the smallest; the wait begins with the second.
        assert!(!arrived(8.0, 3) && arrived(8.0, 4));
        assert!(!arrived(9.0, 10) && arrived(9.0, 11));
        assert!(!arrived(1025.0, 100));
    }

    #[test]
    fn large_changes_that_no_longer_shrink_diverge() {
        let diverges = |changes: &[f64]| Progress::of(&after(changes), EPSILON).diverges(3);
        assert!(diverges(&[1.0, 2.0, 1.5, 4.0]) && !diverges(&[1.0, 2.0, 1.5]));
        // Noise does not diverge.
        assert!(!diverges(&[1024.0 * EPSILON; 9]));
    }
}
