//! A sweep: every coordinate moves once along its edge, in a given order.

use super::driven::advance_driven;
use crate::coordinate::{Along, Coordinate, Moved};
use crate::kernels::reductions::{larger, largest};
use afterbay_core::solver::{Newton, Solver};
use afterbay_core::{Coupling, Effort, Scalar, Separable, State, StepFailure, Vector};

/// Updates every coordinate once, in the given order. Motors move with velocity 1.
#[inline]
pub(crate) fn sweep<V, S>(
    system: &S,
    [h, overall]: [V::Scalar; 2],
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
            let sweep = (first_motor, dissipative);
            evaluations += advance_driven(system, [h, overall], sweep, j, [q, p, w])?;
            continue;
        }
        let moved = advance(system, &Newton, [h, overall], [j, j], [q, p], dissipative)?;
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
pub(super) fn overall<T: Scalar>(coupling: &Coupling, q: &[T]) -> T {
    if *coupling != Coupling::Dense {
        return T::zero();
    }
    largest(q)
}

/// The largest |q_i| among the coordinates coupled to j: j and its neighbours, or for dense
/// coupling all coordinates as they were before the step.
#[inline(always)]
fn beside<T: Scalar>(coupling: &Coupling, overall: T, q: &[T], j: usize) -> T {
    let last = q.len() - 1;
    let [left, right] = match coupling {
        Coupling::Dense => return overall,
        Coupling::Chain => [j.saturating_sub(1), (j + 1).min(last)],
        Coupling::Ring => [if j == 0 { last } else { j - 1 }, if j == last { 0 } else { j + 1 }],
    };
    [q[left], q[j], q[right]].iter().fold(T::zero(), larger)
}

/// Moves coordinate j along its edge. Failures report it as `dof`. Entry j of p is overwritten.
#[inline(always)]
pub(crate) fn advance<T, S>(
    system: &S,
    solver: &impl Solver,
    [h, overall]: [T; 2],
    [j, dof]: [usize; 2],
    [q, p]: [&mut [T]; 2],
    dissipative: bool,
) -> Result<Moved<T>, StepFailure>
where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    coordinate(system, [h, overall], [j, dof], [q, p], dissipative)
        .advance(solver, Along { system, j, q, p })
}

/// Collects the data of coordinate j before it moves.
#[inline(always)]
pub(super) fn coordinate<T, S>(
    system: &S,
    [h, overall]: [T; 2],
    [j, dof]: [usize; 2],
    [q, p]: [&[T]; 2],
    dissipative: bool,
) -> Coordinate<T>
where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    let rate = if system.unit_mass() { h } else { h / system.mass(j) };
    let reach = beside(&system.coupling(), overall, q, j);
    Coordinate { dof, q: q[j], p: p[j], steps: [rate, h, rate], reach, dissipative, drive: () }
}
