//! A coordinate that moves along its edge.

use crate::coordinate::{Coordinate, Edge, Moved, Rates};
use crate::kernels::reductions::larger;
use afterbay_core::solver::Solver;
use afterbay_core::{Coupling, Scalar, Separable, StepFailure};

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
