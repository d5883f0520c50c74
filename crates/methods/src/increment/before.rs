//! A copy of the state before a step, restored if the step fails.

use crate::commit::not_finite;
use afterbay_core::{Effort, Mask, Scalar, State, StepFailure, Vector};

/// (q, p, w) before the step.
#[derive(Clone, Debug)]
pub(crate) struct Before<V> {
    q: V,
    p: V,
    w: V,
}

impl<V: Vector> Before<V> {
    pub(crate) fn new(n: usize) -> Self {
        Self { q: V::zeros(n), p: V::zeros(n), w: V::zeros(n) }
    }

    /// Applies `sweeps` to the state. Restores the state if they fail or their result is not
    /// finite.
    #[inline(always)]
    pub(super) fn attempt(
        &mut self,
        state: &mut State<V>,
        sweeps: impl FnOnce(&mut State<V>) -> Result<Effort, StepFailure>,
    ) -> Result<Effort, StepFailure> {
        self.attempt_and(state, sweeps, |_, _| Ok(()))
    }

    /// Applies `sweeps` to the state. Restores the state if they fail or if `check`, given (q, p,
    /// w) before and after, fails.
    #[inline(always)]
    pub(crate) fn attempt_and(
        &mut self,
        state: &mut State<V>,
        sweeps: impl FnOnce(&mut State<V>) -> Result<Effort, StepFailure>,
        check: impl FnOnce([&[V::Scalar]; 3], [&[V::Scalar]; 3]) -> Result<(), StepFailure>,
    ) -> Result<Effort, StepFailure> {
        let Self { q, p, w } = self;
        q.as_mut_slice().copy_from_slice(state.q.as_slice());
        p.as_mut_slice().copy_from_slice(state.p.as_slice());
        w.as_mut_slice().copy_from_slice(state.w.as_slice());
        let outcome = sweeps(state).and_then(|effort| {
            let after = [&state.q, &state.p, &state.w].map(V::as_slice);
            finite(after)?;
            check([q.as_slice(), p.as_slice(), w.as_slice()], after)?;
            Ok(effort)
        });
        if outcome.is_err() {
            std::mem::swap(&mut state.q, q);
            std::mem::swap(&mut state.p, p);
            std::mem::swap(&mut state.w, w);
        }
        outcome
    }
}

/// Checks that (q, p, w) is finite, without a branch at every number.
fn finite<T: Scalar>(state: [&[T]; 3]) -> Result<(), StepFailure> {
    let all = |part: &[T]| {
        part.iter().fold(T::zero().is_finite(), |mask, x| mask.and(x.is_finite())).all()
    };
    if state.into_iter().all(all) { Ok(()) } else { Err(not_finite(state)) }
}
