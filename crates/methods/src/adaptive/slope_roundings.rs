//! Error estimates that are roundings of the slopes, which shorter steps do not reduce.
//!
//! An estimate is a sum of slopes whose weights cancel. Its rounding, a multiple of h ε |z'|,
//! exceeds the allowed error in long runs at small tolerances; under a drive the roundings of the
//! time add h ε |t| |∂z'/∂t|. Steps would shrink without end. The error of the method falls with a
//! power of h, and a rounding with h alone. Two steps of different lengths therefore tell which of
//! them an estimate is, if it is below the bound of its rounding:
//!
//! - A step is rejected, and the shorter one that follows has an estimate per unit of time that is
//!   not much smaller: both are roundings. The controller has chosen the shorter one for an error
//!   that falls with its power of h, so that the error of the method is within the tolerance. The
//!   step is accepted, and the next but one is lengthened.
//! - The estimate per unit of time has fallen: the longer step shows the error of the method, and
//!   the shorter one has the right length. It is kept for a number of steps.
//!
//! Then a step of twice the length tests again, in the first case twice that of the longer step.
//!
//! A rounding below the allowed error rejects no step, but the controller takes it for an error
//! near the tolerance, and shortens the steps. Where steps have become half as long and the
//! estimates per unit of time have not fallen, the same test is made of two accepted steps.

/// The steps of one length until the next test, where the last one has shown the error of the
/// method. A choice.
const STEPS_A_TEST: u32 = 16;
/// The factor by which a step is longer for the next test. A choice.
const LENGTHENED: f64 = 2.0;
/// A step shorter than the longest one before it by this factor is compared with it. A choice.
const SHORTENED: f64 = 0.5;
/// The least error that shortens the next steps. A choice: a shorter step whose error is less was
/// cut at a kink or at a given time.
const SHORTENING: f64 = 0.1;
/// The least ratio of the estimates per unit of time of a shorter step and a longer one that are
/// rounding; an error of order r of a step of half the length has the ratio 2^(1-r). A choice.
const LEAST_RATIO: f64 = 0.5;
/// The largest ratio of two lengths that tell a rounding from an error. At this ratio an error per
/// unit of time falls to a third if its order is 8, and a rounding stays. A choice, above the ratio
/// to which the controller shortens a step.
const SHORTER: f64 = 0.85;
/// The largest ratio of a rounding per unit of time to the one tested, in steps of this length. A
/// choice: roundings vary.
const LARGEST_RATIO: f64 = 8.0;
/// The most by which a step may be longer than the one tested: by the rounding of times.
const SAME_LENGTH: f64 = 1.01;

/// A step and its estimate, relative to the allowed error.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    length: f64,
    error: f64,
}

impl Step {
    fn rate(self) -> f64 {
        self.error / self.length
    }
}

/// A step that was tested.
#[derive(Clone, Copy, Debug)]
struct Tested {
    step: Step,
    /// Whether its estimate is rounding, and not the error of the method.
    is_rounding: bool,
    /// The steps left until the next test, and the length of that.
    left: u32,
    next_length: f64,
}

/// The steps with which the next is compared.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SlopeRoundings {
    /// The longest of the last steps within the tolerance.
    longest: Step,
    /// A longer step than the next, to compare with: the last one rejected from this state, or the
    /// longest one where the next is suspected.
    longer: Option<Step>,
    /// The last step that was tested.
    tested: Option<Tested>,
    /// The value of `tested` after the step that was accepted is taken.
    next: Option<Tested>,
}

impl SlopeRoundings {
    /// Whether estimates may be rounding: there is a longer step to compare with, or one that was
    /// tested.
    pub(crate) fn is_active(&self) -> bool {
        self.longer.is_some() || self.tested.is_some()
    }

    /// Whether a step within the tolerance is suspected: it is much shorter than one before, and
    /// its estimate has fallen as a rounding does. It is then compared with the longer one.
    #[inline]
    pub(crate) fn suspects(&mut self, length: f64, error: f64) -> bool {
        let longest = self.longest.length;
        if (SHORTENED * longest..=longest).contains(&length) {
            return false;
        }
        let step = Step { length, error };
        let longest = std::mem::replace(&mut self.longest, step);
        let suspects =
            length < longest.length && error >= SHORTENING && are_roundings(longest, step);
        if suspects {
            self.longer = Some(longest);
        }
        suspects
    }

    /// Whether a step is accepted because its estimate, which is below the bound of its rounding,
    /// is rounding. `error` is relative to the allowed error. Returns the largest factor by which
    /// the next step may be longer. Its length does not follow from this estimate.
    pub(crate) fn accepts(&mut self, length: f64, error: f64) -> Option<f64> {
        let step = Step { length, error };
        self.next = self.tested;
        if let Some(tested) = self.tested
            && tested.left > 0
            && length <= SAME_LENGTH * tested.step.length
            && (error <= 1.0
                || tested.is_rounding && step.rate() <= LARGEST_RATIO * tested.step.rate())
        {
            let left = tested.left - 1;
            self.next = Some(Tested { left, ..tested });
            // A step may have been shortened to end at a given time.
            let wanted = if left == 0 { tested.next_length } else { tested.step.length };
            return Some((wanted / length).max(1.0));
        }
        // A lengthened step that is accepted is a test, too.
        let lengthened = self.tested.filter(|_| error <= 1.0).map(|tested| tested.step);
        let before = self.longer.or(lengthened);
        let is_rounding = before.is_some_and(|before| are_roundings(before, step));
        if is_rounding || (error <= 1.0 && self.longer.is_some()) {
            let rate = before.map_or(step.rate(), |before| before.rate().max(step.rate()));
            let step = if is_rounding { Step { length, error: rate * length } } else { step };
            // A rounding within the tolerance gives no reason to wait.
            let left = match (is_rounding, error <= 1.0) {
                (true, true) => 0,
                (true, false) => 1,
                (false, _) => STEPS_A_TEST,
            };
            // The longer of two roundings was not too long.
            let longest = before.filter(|_| is_rounding).map_or(length, |it| it.length.max(length));
            let next_length = LENGTHENED * longest;
            self.next = Some(Tested { step, is_rounding, left, next_length });
            return Some(if left == 0 { next_length / length } else { 1.0 });
        }
        if error <= 1.0 {
            self.next = None;
        } else {
            self.longer = Some(step);
        }
        None
    }

    /// The estimate of a step is no rounding.
    pub(crate) fn end(&mut self) {
        *self = Self { longest: self.longest, ..Self::default() };
    }

    /// The step was taken.
    pub(crate) fn moved(&mut self) {
        *self = Self { longest: self.longest, tested: self.next, ..Self::default() };
    }
}

/// Whether the estimates of two steps fall as roundings do.
fn are_roundings(a: Step, b: Step) -> bool {
    let [longer, shorter] = if a.length > b.length { [a, b] } else { [b, a] };
    shorter.length <= SHORTER * longer.length && shorter.rate() >= LEAST_RATIO * longer.rate()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two attempts at one state, of which the second is half as long, and what is said of them.
    fn two(error: [f64; 2]) -> (SlopeRoundings, [Option<f64>; 2]) {
        let mut roundings = SlopeRoundings::default();
        let said = [roundings.accepts(1.0, error[0]), roundings.accepts(0.5, error[1])];
        roundings.moved();
        (roundings, said)
    }

    #[test]
    fn an_estimate_that_falls_with_h_is_rounding() {
        let (mut roundings, said) = two([6.0, 3.0]);
        assert_eq!(said, [None, Some(1.0)]);
        assert_eq!(roundings.accepts(0.5, 20.0), Some(4.0), "roundings vary");
        roundings.moved();
        assert_eq!(roundings.accepts(2.0, 14.0), None, "the next test");
        assert_eq!(roundings.accepts(1.0, 7.0), Some(1.0));
    }

    #[test]
    fn an_estimate_that_falls_with_a_power_of_h_is_an_error() {
        let (_, said) = two([1000.0, 1000.0 * 0.5_f64.powi(8)]);
        assert_eq!(said, [None, None], "too large, and an error");
        let (mut roundings, said) = two([100.0, 100.0 * 0.5_f64.powi(8)]);
        assert_eq!(said, [None, Some(1.0)], "within the tolerance");
        assert_eq!(roundings.accepts(0.5, 2.0), None, "too large");
    }

    #[test]
    fn a_rounding_within_the_tolerance_is_suspected_where_it_shortens_the_steps() {
        let mut roundings = SlopeRoundings::default();
        let suspected = [(1.0, 0.8), (0.6, 0.5), (0.4, 0.3)]
            .map(|(length, error)| roundings.suspects(length, error));
        assert_eq!(suspected, [false, false, true]);
        assert_eq!(roundings.accepts(0.4, 0.3), Some(5.0), "to twice the longest");
        roundings.moved();
        assert_eq!(roundings.accepts(2.0, 1.4), None, "the next test");
    }

    #[test]
    fn neither_an_error_nor_a_step_that_was_cut_short_is_suspected() {
        for (length, error) in [(0.4, 0.1), (1e-9, 0.09)] {
            let mut roundings = SlopeRoundings::default();
            assert!(!roundings.suspects(1.0, 0.8));
            assert!(!roundings.suspects(length, error), "{length}");
        }
    }

    #[test]
    fn steps_of_the_length_found_are_kept_until_the_next_test() {
        let (mut roundings, _) = two([100.0, 100.0 * 0.5_f64.powi(8)]);
        for left in (0..STEPS_A_TEST).rev() {
            let expected = if left == 0 { LENGTHENED } else { 1.0 };
            assert_eq!(roundings.accepts(0.5, 0.6), Some(expected), "{left}");
            roundings.moved();
        }
    }

    #[test]
    fn a_step_that_was_cut_short_does_not_shorten_the_next() {
        let (mut roundings, _) = two([100.0, 100.0 * 0.5_f64.powi(8)]);
        assert_eq!(roundings.accepts(0.125, 0.1), Some(4.0));
    }
}
