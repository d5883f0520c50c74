//! The reservoir of a run. It keeps the parts of the increments that rounding would remove.
//!
//! An increment of w below half a rounding of w is lost, and a larger one loses a part. Near rest w
//! then stays constant while H falls, and K drifts. A run therefore sums w over a block of steps
//! from 0, and adds each sum s to the whole. The error of that sum ([`two_sum`]) is the start of
//! the next block. Over any number of steps w is off by one rounding of itself, and by the
//! roundings of the sums s. Blocks end at steps that do not depend on the observer, and so neither
//! does w.

use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar, Vector, two_sum};
use crate::quantity::Quantity;
use crate::system::State;

/// The number of steps of a block, and between two checks whether the state has come to rest. A
/// choice: fewer steps would make both cost more, and more steps would let s grow towards w.
pub const STEPS_OF_BLOCK: u64 = 1024;

/// The whole of w while a state holds the sum of its block; `None` if the state holds all of w.
pub(super) struct Reservoir<V>(Option<Parts<V>>);

struct Parts<V> {
    whole: V,
    /// Scratch space for whole + s.
    shown: V,
}

impl<V: Vector> Parts<V> {
    /// Computes whole + s.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if it overflows.
    #[inline(always)]
    fn add(&mut self, state: &State<V>) -> Result<(), StepFailure> {
        let shown = self.shown.as_mut_slice();
        let sums = self.whole.as_slice().iter().zip(state.w.as_slice());
        shown.iter_mut().zip(sums).for_each(|(shown, (&w, &s))| *shown = w + s);
        if shown.iter().all(|x| x.is_finite().all()) {
            return Ok(());
        }
        Err(StepFailure::non_finite(&[(Quantity::Reservoir, shown)]))
    }
}

impl<V: Vector> Reservoir<V> {
    /// If `in_parts`, takes w out of `state`, which receives the part that earlier blocks left.
    #[inline(always)]
    pub(super) fn begin(state: &mut State<V>, remainder: &V, in_parts: bool) -> Self {
        Self(in_parts.then(|| {
            let (whole, shown) = (state.w.clone(), state.w.clone());
            state.w.as_mut_slice().copy_from_slice(remainder.as_slice());
            Parts { whole, shown }
        }))
    }

    /// Passes the state with all of w to `look`.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if w overflows.
    #[inline(always)]
    pub(super) fn show<R>(
        &mut self,
        state: &mut State<V>,
        look: impl FnOnce(&State<V>) -> R,
    ) -> Result<R, StepFailure> {
        let Some(parts) = &mut self.0 else { return Ok(look(state)) };
        parts.add(state)?;
        let Parts { shown, .. } = parts;
        std::mem::swap(&mut state.w, shown);
        let seen = look(state);
        std::mem::swap(&mut state.w, shown);
        Ok(seen)
    }

    /// Ends a block: adds its sum to the whole.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if w overflows; nothing is added then.
    #[inline(always)]
    pub(super) fn end_block(&mut self, state: &mut State<V>) -> Result<(), StepFailure> {
        let Some(parts) = &mut self.0 else { return Ok(()) };
        parts.add(state)?;
        let sums = parts.whole.as_mut_slice().iter_mut().zip(state.w.as_mut_slice());
        sums.for_each(|(w, s)| [*w, *s] = two_sum(*w, *s));
        Ok(())
    }

    /// Puts the whole back into `state`, and the part that is not added to it into `remainder`.
    #[inline(always)]
    pub(super) fn end(self, state: &mut State<V>, remainder: &mut V) {
        if let Some(Parts { whole, .. }) = self.0 {
            remainder.as_mut_slice().copy_from_slice(state.w.as_slice());
            state.w = whole;
        }
    }
}
