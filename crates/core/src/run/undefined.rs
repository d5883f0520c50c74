//! Steps that fail because the system has no values where they begin.

use crate::error::StepFailure;
use crate::numbers::{Scalar, Vector, first_not_finite};
use crate::quantity::Quantity;
use crate::system::{State, System};

/// A motion or a force beyond this has grown without bound: no unit makes it so large.
const HUGE: f64 = 1e60;

/// `failure`, or [`StepFailure::Undefined`] if H, a velocity or a force is NaN at the state from
/// which the step begins, or is not finite at the first state of a run. Later in a run they may
/// overflow because the motion grows: their terms are then infinite, and their sum may be NaN.
///
/// Inlined, it would slow down the time loop.
#[cold]
#[inline(never)]
pub(super) fn or_undefined<V, S>(
    system: &S,
    state: &State<V>,
    is_first: bool,
    failure: StepFailure,
) -> StepFailure
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    let [mut hq, mut hp, mut d] = [(); 3].map(|()| V::zeros(system.dof()));
    let (q, p) = (state.q.as_slice(), state.p.as_slice());
    system.gradient(q, p, hq.as_mut_slice(), hp.as_mut_slice());
    system.dissipation(q, p, hp.as_slice(), d.as_mut_slice());
    let energy = [system.energy(q, p)];
    let parts = [
        (Quantity::Slope, hq.as_slice()),
        (Quantity::Velocity, hp.as_slice()),
        (Quantity::Dissipation, d.as_slice()),
        (Quantity::Energy, &energy),
    ];
    let overflows = || [q, p, hq.as_slice()].into_iter().flatten().any(|x| x.to_f64().abs() > HUGE);
    for (quantity, part) in parts {
        if let Some((dof, value)) = first_not_finite(part)
            && (is_first || (value.is_nan() && !overflows()))
        {
            return StepFailure::Undefined { quantity, dof, value };
        }
    }
    failure
}
