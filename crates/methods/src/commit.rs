//! The end of a step: the new state is checked and stored.

use crate::kernels::reductions::all_finite;
use afterbay_core::{Quantity, Scalar, State, StepFailure, Vector};

/// Stores q, p and w in `state`, w only for a system with dissipation.
///
/// # Errors
/// [`StepFailure::NonFinite`] if a number is not finite; `state` is then unchanged.
pub(crate) fn commit<V: Vector>(
    state: &mut State<V>,
    end: [&[V::Scalar]; 3],
    dissipative: bool,
) -> Result<(), StepFailure> {
    check(end)?;
    store(state, end, dissipative);
    Ok(())
}

/// Stores q, p and w, which are finite, in `state`, w only for a system with dissipation.
#[inline(always)]
pub(crate) fn store<V: Vector>(
    state: &mut State<V>,
    [q, p, w]: [&[V::Scalar]; 3],
    dissipative: bool,
) {
    state.q.assign(q);
    state.p.assign(p);
    if dissipative {
        state.w.assign(w);
    }
}

/// [`not_finite`] of copies, so that the vectors of a loop can stay in registers.
#[cold]
#[inline(never)]
pub(crate) fn not_finite_by_value<V: Vector>([q, p, w]: [V; 3]) -> StepFailure {
    not_finite([q.as_slice(), p.as_slice(), w.as_slice()])
}

/// The failure for the first of q, p and w that is not finite.
#[cold]
pub(crate) fn not_finite<T: Scalar>([q, p, w]: [&[T]; 3]) -> StepFailure {
    StepFailure::non_finite(&[
        (Quantity::Coordinate, q),
        (Quantity::Momentum, p),
        (Quantity::Reservoir, w),
    ])
}

/// Checks that q, p and w are finite.
///
/// # Errors
/// [`StepFailure::NonFinite`] for the first number that is not.
pub(crate) fn check<T: Scalar>(end: [&[T]; 3]) -> Result<(), StepFailure> {
    if end.iter().all(|part| all_finite(part)) { Ok(()) } else { Err(not_finite(end)) }
}
