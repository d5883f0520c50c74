//! The scheme for one driven degree of freedom.
//!
//! ```text
//! q1 - q0 = h p̄/m        p1 - p0 = -h (ΔV/Δq + D̄ - F̄)        F̄ = F((q0 + q1)/2, t0 + h/2)
//! w1 - w0 = h D̄ p̄/m      s1 - s0 = h F̄ p̄/m
//! ```
//!
//! The motors ([`afterbay_core::Driven`]) move by half a step before the coordinate and by half a
//! step after it, so the force is that of the middle of the step, and the scheme stays symmetric.

use crate::commit::check;
use crate::coordinate::{Along, Coordinate};
use crate::increment::supply;
use afterbay_core::solver::Newton;
use afterbay_core::{
    Effort, InputError, Method, Scalar, Separable, State, StepFailure, Vector, validate,
};

/// The plain scheme for a driven system.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrivenModDg;

/// The new state.
#[derive(Clone, Debug)]
pub(super) struct Workspace<V> {
    q: V,
    p: V,
    w: V,
}

impl<V, S> Method<V, S> for DrivenModDg
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let refuse = |why| Err(InputError::Unsupported { method: "moddg", why });
        if system.dof() != 2 || system.motors() != 1 {
            return refuse("the scheme applies to one degree of freedom only");
        }
        if !system.has_exact_divided_differences() {
            return refuse("a driven system needs exact divided differences");
        }
        validate::masses(system)?;
        let zeros = || V::zeros(system.dof());
        Ok(Workspace { q: zeros(), p: zeros(), w: zeros() })
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
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { q, p, w } = workspace;
        let (q, p, w) = (q.as_mut_slice(), p.as_mut_slice(), w.as_mut_slice());
        q.copy_from_slice(state.q.as_slice());
        p.copy_from_slice(state.p.as_slice());
        w.copy_from_slice(state.w.as_slice());
        q[1..].iter_mut().for_each(|t| *t += h.half());
        let rate = h / system.mass(0);
        let reach = Scalar::abs(q[0]);
        let coordinate = Coordinate {
            dof: 0,
            q: q[0],
            p: p[0],
            steps: [rate, h, rate],
            reach,
            dissipative: true,
        };
        let moved = coordinate.advance(&Newton, Along { system, j: 0, q, p })?;
        let from = q[0];
        (q[0], p[0]) = (moved.q, moved.p);
        w[0] += moved.dw;
        supply(system, 0, [from, moved.q], [q, p, w]);
        q[1..].iter_mut().for_each(|t| *t += h.half());
        check([&*q, &*p, &*w])?;
        state.q.as_mut_slice().copy_from_slice(q);
        state.p.as_mut_slice().copy_from_slice(p);
        state.w.as_mut_slice().copy_from_slice(w);
        Ok(Effort { evaluations: moved.evaluations, iterations: moved.evaluations })
    }
}
