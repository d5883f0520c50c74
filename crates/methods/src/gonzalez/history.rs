//! A first guess from the steps before.
//!
//! Δz is smooth in time: the parabola through the last three gives the next up to h⁴, and the Jacobian that served them still
//! contracts. Both are used only where a step goes on from the very state, to the bit, that the last one led to, with the
//! same h; anything else starts afresh. What they give is a start: the solution is found to rounding from any.

use super::equation::Workspace;
use afterbay_core::{Scalar, State, Vector};

/// Steps that a guess is made from.
const ENOUGH: u32 = 3;
/// Corrections more than the first step with a Jacobian needed that make it worth another.
const WORN: u32 = 1;
/// The least share of itself a correction is said to leave where that was not seen, but concluded from the step before,
/// and what is added to that each time.
const UNSURE: (f64, f64) = (1.0 / 4096.0, 1.1);

/// What is remembered of the steps before.
#[derive(Clone, Debug)]
pub(super) struct History<V: Vector> {
    /// Δz of the last step but one, and of the one before
    before: [[V; 2]; 2],
    /// Steps in a row, up to [`ENOUGH`]
    steps: u32,
    h: V::Scalar,
    /// Corrections needed when the Jacobian was new, once known
    least: Option<u32>,
    pub(super) worn: bool,
    /// What a correction left of itself in the last step
    rate: f64,
    /// Too long ago that it was seen
    blind: bool,
}

impl<V: Vector> History<V> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || [V::zeros(n), V::zeros(n)];
        Self {
            before: [zeros(), zeros()],
            steps: 0,
            h: V::Scalar::zero(),
            least: None,
            worn: false,
            rate: f64::NAN,
            blind: false,
        }
    }

    /// Starts afresh.
    pub(super) fn forget(&mut self) {
        self.steps = 0;
    }

    /// What a correction leaves of itself, as far as the last step tells.
    pub(super) fn rate(&self) -> f64 {
        if self.rate <= UNSURE.0 { UNSURE.0 } else { f64::NAN }
    }

    /// What corrections left of themselves: at most `rate`, or `seen` above the noise.
    pub(super) fn rated(&mut self, rate: f64, seen: f64) {
        self.rate = if seen.is_nan() { self.rate.min(rate) * UNSURE.1 } else { seen };
        self.blind = seen.is_nan() && self.rate > UNSURE.0;
    }

    /// A step that was taken; with a guess, the number of corrections it needed.
    pub(super) fn record(&mut self, h: V::Scalar, guessed: Option<u32>) {
        (self.steps, self.h) = ((self.steps + 1).min(ENOUGH), h);
        match (guessed, self.least) {
            (None, _) => (self.least, self.worn) = (None, false),
            (Some(_), _) if self.worn => (self.least, self.worn) = (guessed, false),
            (Some(corrections), Some(least)) => self.worn = corrections > least + WORN,
            (Some(_), None) => self.least = guessed,
        }
    }
}

impl<V: Vector> Workspace<V> {
    /// Guesses Δz from the steps that led to `state`, if there are enough.
    pub(super) fn guess(&mut self, h: V::Scalar, state: &State<V>) -> bool {
        let History { before, steps, h: last, blind, .. } = &mut self.history;
        let goes_on =
            *last == h && self.q.as_slice() == state.q.as_slice() && self.p.as_slice() == state.p.as_slice();
        if !goes_on || *blind {
            *steps = 0;
        }
        let known = *steps >= ENOUGH;
        let [[q, p], [q_old, p_old]] = before;
        for (now, before, old) in [(&mut self.dq, q, q_old), (&mut self.dp, p, p_old)] {
            if known {
                extrapolate(old.as_mut_slice(), before.as_slice(), now.as_slice());
            }
            std::mem::swap(before, old);
            std::mem::swap(now, before);
        }
        known
    }
}

/// Puts the next of a, b, c on a parabola in the place of a.
fn extrapolate<T: Scalar>(a: &mut [T], b: &[T], c: &[T]) {
    let three = T::from_f64(3.0);
    for ((a, &b), &c) in a.iter_mut().zip(b).zip(c) {
        *a = three.mul_add(c - b, *a);
    }
}
