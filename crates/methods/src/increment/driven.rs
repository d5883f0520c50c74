//! The coordinates and the motors of a driven system in a sweep.

use super::member::{Member, Stride, coordinate};
use crate::coordinate::Edge;
use afterbay_core::solver::Newton;
use afterbay_core::{Scalar, Separable, StepFailure, Supply};

/// Updates one coordinate or motor of a driven system, with the friction on it if there is any in
/// the sweep. Returns the number of evaluations.
#[inline(never)]
pub(super) fn advance_driven<T, S>(
    system: &S,
    stride: Stride<T>,
    first_motor: usize,
    dissipative: bool,
    j: usize,
    [q, p, w]: [&mut [T]; 3],
) -> Result<u64, StepFailure>
where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    if j >= first_motor {
        advance_motor(system, stride.h, j, [q, p])?;
        return Ok(0);
    }
    let known = system.supply(q, j).filter(|supply| !supply.depends_on_own);
    let drive = known.map(|supply| supply.force);
    let member = Member { index: j, dof: j };
    let coordinate = coordinate(system, stride, member, [q, p], dissipative);
    let moved = coordinate.under(drive).advance(&Newton, Edge { system, j, q, p })?;
    let from = std::mem::replace(&mut q[j], moved.q);
    p[j] = moved.p;
    if dissipative {
        w[j] += moved.dw;
    }
    supply(system, j, known, [from, moved.q], [q, p, w]);
    Ok(moved.evaluations)
}

/// Moves a motor with velocity 1. The momentum of a clock changes by the divided difference of V
/// along the time.
fn advance_motor<T, S>(
    system: &S,
    h: T,
    motor: usize,
    [q, p]: [&mut [T]; 2],
) -> Result<(), StepFailure>
where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    let (from, to) = (q[motor], q[motor] + h);
    if system.may_be_singular() && system.is_singular_along(q, motor, to) {
        let [from, to] = [from, to].map(T::to_f64);
        return Err(StepFailure::AcrossSingularity { dof: motor, from, to });
    }
    p[motor] -= system.divided_difference(q, motor, to).value * (to - from);
    q[motor] = to;
    Ok(())
}

/// Adds to the motor the work of its force on degree of freedom j, which has moved along its edge:
/// the force at the midpoint, as in D̄, times the displacement.
fn supply<T, S>(
    system: &S,
    j: usize,
    known: Option<Supply<T>>,
    [from, to]: [T; 2],
    [q, p, w]: [&mut [T]; 3],
) where
    T: Scalar,
    S: Separable<T> + ?Sized,
{
    let supplied = known.or_else(|| {
        q[j] = (from + to).half();
        let supplied = system.supply(q, j);
        q[j] = to;
        supplied
    });
    if let Some(Supply { motor, force, .. }) = supplied {
        let work = force * (to - from);
        p[motor] += work;
        w[motor] -= work;
    }
}
