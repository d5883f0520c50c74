//! A copy of the state before a step, restored if the step fails.

use afterbay_core::{Effort, Mask, Quantity, Scalar, State, StepFailure, Vector};

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
            finite(state)?;
            let after = [&state.q, &state.p, &state.w].map(V::as_slice);
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

/// Checks that the state is finite.
fn finite<V: Vector>(state: &State<V>) -> Result<(), StepFailure> {
    let parts = [
        (Quantity::Coordinate, state.q.as_slice()),
        (Quantity::Momentum, state.p.as_slice()),
        (Quantity::Reservoir, state.w.as_slice()),
    ];
    let all = |part: &[V::Scalar]| {
        part.iter().fold(V::Scalar::zero().is_finite(), |mask, x| mask.and(x.is_finite())).all()
    };
    if parts.iter().all(|(_, part)| all(part)) {
        Ok(())
    } else {
        Err(StepFailure::non_finite(&parts))
    }
}
