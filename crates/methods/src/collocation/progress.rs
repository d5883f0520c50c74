//! Has an iteration arrived?
//!
//! Changes shrink until they are noise. An iteration ends where the next change would be lost,
//! where changes of a few roundings no longer shrink, and is given up where larger ones do not.

/// Iterations before one is given up.
pub(super) const LIMIT: u32 = 100;
/// Changes without a smaller one among them that end an iteration, within the first and the second
/// of [`NOISE`].
const PATIENCE: [u32; 2] = [3, 10];
/// The most that changes may be, in roundings, where they no longer shrink. Slow ones may rest on
/// the way.
const NOISE: [f64; 2] = [8.0, 1024.0];
/// A change of so many roundings may be noise.
const CLEAR: f64 = 64.0;
/// The next change that is not made, in roundings. Left out at every step, it is what K would drift
/// by.
const UNSEEN: f64 = 0.015625;

/// The changes so far, each relative to the size of z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    epsilon: f64,
    /// The last change.
    pub(super) last: f64,
    least: f64,
    /// Changes since the least.
    waited: u32,
    /// The last change over the one before.
    pub(super) ratio: f64,
}

impl Progress {
    /// Of a scalar with the unit roundoff `epsilon`.
    pub(super) fn new(epsilon: f64) -> Self {
        Self { epsilon, last: f64::NAN, least: f64::INFINITY, waited: 0, ratio: f64::NAN }
    }

    /// One more change.
    #[inline(always)]
    pub(super) fn see(&mut self, change: f64) {
        self.ratio = change / self.last;
        self.waited = if change < self.least { 0 } else { self.waited + 1 };
        self.least = self.least.min(change);
        self.last = change;
    }

    /// Is the last change more than noise?
    #[inline(always)]
    pub(super) fn is_clear(&self) -> bool {
        self.last > CLEAR * self.epsilon
    }

    /// Do changes that shrink by `rate` leave less than can be seen of what is `left`? Are they
    /// noise?
    #[inline(always)]
    pub(super) fn has_arrived(&self, rate: f64, left: f64) -> bool {
        let roundings = self.last / self.epsilon;
        self.last == 0.0
            || (rate < 0.5 && left * rate <= UNSEEN * self.epsilon)
            || (roundings <= NOISE[0] && self.waited >= PATIENCE[0])
            || (roundings <= NOISE[1] && self.waited >= PATIENCE[1])
    }

    /// Is the last change no more than roundings of z may make?
    #[inline(always)]
    pub(super) fn is_rounding(&self) -> bool {
        self.last <= NOISE[0] * self.epsilon
    }

    /// Has no change been smaller than all before for `patience` changes, none of them noise?
    #[inline(always)]
    pub(super) fn is_lost(&self, patience: u32) -> bool {
        self.waited >= patience && self.last > NOISE[1] * self.epsilon
    }
}
