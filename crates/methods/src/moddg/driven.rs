//! The scheme for one degree of freedom with motors.
//!
//! ```text
//! q1 - q0 = h p̄/m        p1 - p0 = -h (ΔV/Δq + D̄ - F̄)        F̄ = F((q0 + q1)/2, t0 + h/2)
//! w1 - w0 = h D̄ p̄/m      s1 - s0 = h F̄ p̄/m
//! ```
//!
//! The motors ([`afterbay_core::Driven`], [`afterbay_core::Clocked`]) move by half a step before
//! the coordinate and by half a step after it, so V, D and F are those of the middle of the step,
//! and the scheme stays symmetric. With V(q, t) the energy pumped is
//!
//! ```text
//! s_t1 - s_t0 = V(q0, t0 + h/2) - V(q0, t0) + V(q1, t1) - V(q1, t0 + h/2)
//! ```

use crate::increment::before::Before;
use crate::increment::{Stride, balanced, sweep};
use afterbay_core::{
    Effort, InputError, Method, Scalar, Separable, State, StepFailure, Vector, validate,
};
use std::iter::once;

/// The plain scheme for a system with motors.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrivenModDg;

/// The coordinate of a system of one degree of freedom, and its first motor.
const COORDINATE: usize = 0;
const FIRST_MOTOR: usize = 1;

impl<V, S> Method<V, S> for DrivenModDg
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    type Workspace = Before<V>;

    fn workspace(&self, system: &S) -> Result<Before<V>, InputError> {
        if system.dof() - system.motors() != 1 {
            let why = "the scheme applies to one degree of freedom only";
            return Err(InputError::Unsupported { method: "moddg", why });
        }
        validate::masses(system)?;
        Ok(Before::new(system.dof()))
    }

    fn is_memoryless(&self) -> bool {
        true
    }

    fn refuses_singularities(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        before: &mut Before<V>,
    ) -> Result<Effort, StepFailure> {
        let moves = |state: &mut State<V>| {
            let largest_q = Scalar::abs(state.q.as_slice()[COORDINATE]);
            let [half, whole] = [h.half(), h].map(|h| Stride { h, largest_q });
            let motors = FIRST_MOTOR..state.dof();
            sweep(system, half, FIRST_MOTOR, state, motors.clone())?;
            let effort = sweep(system, whole, FIRST_MOTOR, state, once(COORDINATE))?;
            sweep(system, half, FIRST_MOTOR, state, motors)?;
            Ok(effort)
        };
        before.attempt_and(state, moves, |before, after| balanced(system, before, after))
    }
}
