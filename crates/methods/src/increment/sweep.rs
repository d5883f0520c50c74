//! A sweep: every coordinate moves once along its edge, in a given order.

use super::driven::advance_driven;
use crate::coordinate::{Coordinate, Edge, Moved, Rates};
use crate::kernels::reductions::{larger, largest};
use afterbay_core::solver::{Newton, Solver};
use afterbay_core::{Coupling, Effort, Scalar, Separable, State, StepFailure, Vector};

/// A step of a sweep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stride<T> {
    /// The length of the step.
    pub(crate) h: T,
    /// The largest |q_i|. Used under dense coupling alone.
    pub(crate) largest_q: T,
}

/// A coordinate that moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    /// Its index in the slices.
    pub(crate) index: usize,
    /// The number by which failures name it.
    pub(crate) dof: usize,
}

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

/// The largest |q_i| among the coordinates coupled to j: j and its neighbours, or for dense
/// coupling all coordinates as they were before the step.
#[inline(always)]
fn beside<T: Scalar>(coupling: &Coupling, largest_q: T, q: &[T], j: usize) -> T {
    let last = q.len() - 1;
    let [left, right] = match coupling {
        Coupling::Dense => return largest_q,
        Coupling::Chain => [j.saturating_sub(1), (j + 1).min(last)],
        Coupling::Ring => [if j == 0 { last } else { j - 1 }, if j == last { 0 } else { j + 1 }],
    };
    [q[left], q[j], q[right]].iter().fold(T::zero(), larger)
}

/// Moves a coordinate along its edge. Its entry of p is overwritten.
#[inline(always)]
pub(crate) fn advance<T, S>(
    system: &S,
    solver: &impl Solver,
    stride: Stride<T>,
    member: Member,
    [q, p]: [&mut [T]; 2],
    dissipative: bool,
) -> Result<Moved<T>, StepFailure>
where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    coordinate(system, stride, member, [q, p], dissipative)
        .advance(solver, Edge { system, j: member.index, q, p })
}

/// Collects the data of a coordinate before it moves.
#[inline(always)]
pub(super) fn coordinate<T, S>(
    system: &S,
    stride: Stride<T>,
    member: Member,
    [q, p]: [&[T]; 2],
    dissipative: bool,
) -> Coordinate<T>
where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    let (Stride { h, largest_q }, Member { index: j, dof }) = (stride, member);
    let rate = if system.unit_mass() { h } else { h / system.mass(j) };
    let largest_coupled = beside(&system.coupling(), largest_q, q, j);
    let rates = Rates { q: rate, p: h, w: rate };
    Coordinate { dof, q: q[j], p: p[j], rates, largest_coupled, dissipative, drive: () }
}
