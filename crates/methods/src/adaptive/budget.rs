//! The error allowed for a step, given the tolerance of the run.

use crate::kernels::reductions::see_size;
use afterbay_core::{Scalar, State, Tolerance, Vector, larger_or_nan};
use std::array::from_fn;

/// The error allowed for a step relative to its share of the error of the run. With the default
/// [`target_error`](afterbay_core::StepControl::target_error) of 0.2 steps aim at a fifth of the
/// allowed error, that is, at their share. The value is calibrated, not derived: where errors have
/// one sign and are not damped, as on an oscillator without friction, the error at the end then
/// equals the tolerance, and over the test set it is nowhere above ten times the tolerance
/// (`adaptive_accuracy` in the tests prints both).
pub(crate) const SHARES: f64 = 5.0;
/// Roundings of q, p and w that are allowed for any step.
pub(crate) const ROUNDINGS: f64 = 4.0;
/// The number of entries processed side by side.
const LANES: usize = 8;

/// The tolerance of a run over a time span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    tolerance: Tolerance,
    span: f64,
    /// The degrees of freedom without the motors, whose coordinates are the time.
    free: usize,
    /// [`SHARES`] over the span.
    rate: f64,
    /// The time passed in steps, their number, and 1 over the number of the next.
    passed: f64,
    steps: f64,
    next: f64,
}

impl Budget {
    pub(crate) fn new(tolerance: &Tolerance, span: f64, free: usize) -> Self {
        Self {
            tolerance: *tolerance,
            span,
            free,
            rate: SHARES / span,
            passed: 0.0,
            steps: 0.0,
            next: 1.0,
        }
    }

    pub(crate) fn relative(&self) -> f64 {
        self.tolerance.relative
    }

    /// The share of the run's error that a step of this length is allowed.
    pub(crate) fn share_of(&self, length: f64) -> f64 {
        if self.span > 0.0 { SHARES * length / self.span } else { SHARES }
    }

    /// The share of the run's error for a step of mean length, where the mean includes the next
    /// step, of this length. The number of steps is least where all have the same error. The sum
    /// over the steps is about that of [`Self::share_of`], and it is larger where the first steps
    /// are the longest.
    #[inline]
    pub(crate) fn equal_share(&self, length: f64) -> f64 {
        if self.span > 0.0 { self.rate * (self.passed + length) * self.next } else { SHARES }
    }

    /// The errors of q, p and w allowed for a step of this length, by [`Self::equal_share`], and at
    /// least a few roundings.
    #[inline]
    pub(crate) fn allowed_of_equal_steps<V: Vector>(
        &self,
        state: &State<V>,
        length: f64,
    ) -> [f64; 3] {
        let share = self.equal_share(length);
        let Tolerance { relative, absolute, w_relative, w_absolute } = self.tolerance;
        let allowed = |size: f64, relative: f64, absolute: f64| {
            (share * (relative * size + absolute)).max(ROUNDINGS * V::Scalar::EPSILON * size)
        };
        let [size_q, size_p, size_w] = sizes(state, self.free);
        [
            allowed(size_q, relative, absolute),
            allowed(size_p, relative, absolute),
            allowed(size_w, w_relative, w_absolute),
        ]
    }

    /// Counts an accepted step.
    #[inline]
    pub(crate) fn spend(&mut self, length: f64) {
        self.passed += length;
        self.steps += 1.0;
        self.next = (self.steps + 1.0).recip();
    }

    /// The errors of q, p and w allowed at the end of the run, of which the given share is allowed
    /// for a step. A step is always allowed a few roundings of the state.
    #[inline]
    pub(crate) fn scales<V: Vector>(&self, state: &State<V>, share: f64) -> [f64; 3] {
        let rounding = ROUNDINGS * V::Scalar::EPSILON / share;
        scales(&self.tolerance, sizes(state, self.free), rounding)
    }
}

/// max |q_j| of the first `free` degrees of freedom, max |p_j| and max |w_j|.
#[inline(always)]
pub(crate) fn sizes<V: Vector>(state: &State<V>, free: usize) -> [f64; 3] {
    [largest_of_first(&state.q, free), largest(&state.p), largest(&state.w)]
}

/// The errors of q, p and w that a tolerance allows at these sizes, at least `rounding` times the
/// size.
#[inline(always)]
pub(crate) fn scales(tolerance: &Tolerance, sizes: [f64; 3], rounding: f64) -> [f64; 3] {
    let &Tolerance { relative, absolute, w_relative, w_absolute } = tolerance;
    let scale =
        |size: f64, relative: f64, absolute: f64| (relative * size + absolute).max(rounding * size);
    let [q, p, w] = sizes;
    [scale(q, relative, absolute), scale(p, relative, absolute), scale(w, w_relative, w_absolute)]
}

/// max |x_j| over the first `count` entries, or NaN if one of them is not finite.
#[inline(always)]
fn largest_of_first<V: Vector>(x: &V, count: usize) -> f64 {
    let entries = x.as_slice();
    if count == entries.len() {
        return largest(x);
    }
    let sizes = entries[..count].iter().map(|x| x.to_f64().abs());
    sizes.fold(0.0, larger_or_nan)
}

/// max |x_j|, or NaN if an entry is not finite.
#[inline(always)]
pub(crate) fn largest<V: Vector>(x: &V) -> f64 {
    let see = |found: [f64; 2], x: &V::Scalar| see_size(found, x.to_f64().abs());
    let nothing = [0.0; 2];
    let [most, poison] = if V::LEN.is_some() {
        x.as_slice().iter().fold(nothing, see)
    } else {
        let (blocks, rest) = x.as_slice().as_chunks::<LANES>();
        let lanes = blocks
            .iter()
            .fold([nothing; LANES], |lanes, block| from_fn(|lane| see(lanes[lane], &block[lane])));
        let most = lanes.iter().fold(0.0, |most: f64, lane| most.max(lane[0]));
        let poison = lanes.iter().map(|lane| lane[1]).sum();
        rest.iter().fold([most, poison], see)
    };
    most + poison
}
