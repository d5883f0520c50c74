//! Error estimates that are roundings of the slopes, which shorter steps do not reduce.
//!
//! An estimate is a sum of slopes whose weights cancel. Its rounding, a multiple of h ε |z'|, exceeds
//! the allowed error in long runs at small tolerances; under a drive the roundings of the time add
//! h ε |t| |∂z'/∂t|. Steps would shrink without end. The error of the method falls with a power of
//! h, and a rounding with h alone. Two steps of different lengths therefore tell which of them an
//! estimate is, if it is below the bound of its rounding:
//!
//! - A step is rejected, and the shorter one that follows has an estimate per unit of time that is
//!   not much smaller: both are roundings. The controller has chosen the shorter one for an error
//!   that falls with its power of h, so that the error of the method is within the tolerance. The
//!   step is accepted, and lengthened soon.
//! - The estimate per unit of time has fallen: the longer step shows the error of the method, and
//!   the shorter one has the right length. It is kept for a number of steps.
//!
//! Then a step of twice the length tests again.

/// The steps of one length until the next test, where the last one has shown the error of the
/// method. A choice.
const STEPS_A_TEST: u32 = 16;
/// The factor by which a step is longer for the next test. A choice.
const LENGTHENED: f64 = 2.0;
/// The least ratio of the estimates per unit of time of a shorter step and a longer one that are
/// rounding; an error of order r of a step of half the length has the ratio 2^(1-r). A choice.
const LEAST_RATIO: f64 = 0.5;
/// The largest ratio of an estimate per unit of time to the one tested, in steps of this length. A
/// choice: roundings vary.
const LARGEST_RATIO: f64 = 8.0;
/// The most by which a step may be longer than the one tested: by its own rounding. A choice.
const SAME_LENGTH: f64 = 1.01;

/// A step and its estimate per unit of time.
#[derive(Clone, Copy, Debug)]
struct Step {
    length: f64,
    rate: f64,
}

/// The last rejected step from the current state, and the last one tested.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SlopeRoundings {
    rejected: Option<Step>,
    tested: Option<Step>,
    /// The steps left until the next test.
    left: u32,
}

impl SlopeRoundings {
    /// Whether estimates may be rounding: a step was rejected here, or one has been tested.
    pub(crate) fn is_active(&self) -> bool {
        self.rejected.is_some() || self.tested.is_some()
    }

    /// Whether the estimate of a step, below the bound of its rounding, says nothing of its error,
    /// which is within the tolerance. `error` is relative to the allowed error. Returns the largest
    /// factor by which the next step may be longer.
    pub(crate) fn accepts(&mut self, length: f64, error: f64) -> Option<f64> {
        let step = Step { length, rate: error / length };
        if let Some(tested) = self.tested
            && self.left > 0
            && length <= SAME_LENGTH * tested.length
            && step.rate <= LARGEST_RATIO * tested.rate
        {
            self.left -= 1;
            return Some(if self.left == 0 { LENGTHENED } else { 1.0 });
        }
        // A lengthened step that is accepted is a test, too.
        let before = self.rejected.or(self.tested.filter(|_| error <= 1.0));
        let [longer, shorter] = match before {
            Some(before) if length < before.length => [before, step],
            Some(before) => [step, before],
            None => [step, step],
        };
        let is_rounding = before.is_some() && shorter.rate >= LEAST_RATIO * longer.rate;
        if is_rounding || (error <= 1.0 && self.rejected.is_some()) {
            let rate = if is_rounding { longer.rate.max(shorter.rate) } else { step.rate };
            self.tested = Some(Step { rate, ..step });
            self.left = if is_rounding { 1 } else { STEPS_A_TEST };
            return Some(1.0);
        }
        if error <= 1.0 {
            self.tested = None;
        } else {
            self.rejected = Some(step);
        }
        None
    }

    /// The estimate of a step is no rounding.
    pub(crate) fn end(&mut self) {
        *self = Self::default();
    }

    /// The state has moved.
    pub(crate) fn moved(&mut self) {
        self.rejected = None;
    }
}
