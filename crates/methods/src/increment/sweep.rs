//! A sweep: every coordinate moves once along its edge, in a given order.

use super::driven::advance_driven;
use super::member::{Member, Stride, advance};
use crate::kernels::reductions::largest;
use afterbay_core::solver::Newton;
use afterbay_core::{Coupling, Effort, Scalar, Separable, State, StepFailure, Vector};

/// Updates every coordinate once, in the given order. Motors move with velocity 1.
#[inline]
pub(crate) fn sweep<V, S>(
    system: &S,
    stride: Stride<V::Scalar>,
    first_motor: usize,
    state: &mut State<V>,
    order: impl Iterator<Item = usize>,
) -> Result<Effort, StepFailure>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let damping = system.dissipation_form();
    // Friction that couples the momenta acts outside the sweep.
    let dissipative = !damping.zero && !damping.coupled;
    let mut evaluations = 0;
    let (q, p, w) = (state.q.as_mut_slice(), state.p.as_mut_slice(), state.w.as_mut_slice());
    let has_motors = first_motor < q.len();
    for j in order {
        if has_motors {
            evaluations += advance_driven(system, stride, first_motor, dissipative, j, [q, p, w])?;
            continue;
        }
        let member = Member { index: j, dof: j };
        let moved = advance(system, &Newton, stride, member, [q, p], dissipative)?;
        (q[j], p[j]) = (moved.q, moved.p);
        if dissipative {
            w[j] += moved.dw;
        }
        evaluations += moved.evaluations;
    }
    Ok(Effort { evaluations, iterations: evaluations })
}

/// The largest |q_j| if every coordinate is coupled to every other, else 0: for local coupling,
/// [`beside`] computes the maximum over neighbours.
pub(super) fn largest_if_dense<T: Scalar>(coupling: &Coupling, q: &[T]) -> T {
    if *coupling != Coupling::Dense {
        return T::zero();
    }
    largest(q)
}
