//! Continuation of the solution from s = 0 to s = 1.

use super::course::carefully;
use super::twice::{Twice, twice};
use super::{Equation, Outcome, Root, is_gentle};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use crate::quantity::Quantity;
use crate::solver::several::several;
use std::hint::cold_path;

/// The shortest step in s of the continuation.
const SHORTEST: f64 = 1e-6;
/// Evaluations after which the continuation is given up.
const MOST: u32 = 10_000;

/// Follows the solution from s = 0 to s = 1 where the direct iteration has not led to it, each lane
/// in its own strides.
#[cold]
#[inline(never)]
pub(super) fn follow<T: Scalar, E: Equation<T>>(
    dof: usize,
    start: T,
    force: T,
    direct: Outcome<T>,
    equation: &mut E,
) -> Result<Root<T>, StepFailure> {
    let (zero, one) = (T::zero(), T::one());
    let Outcome { x, stalled, mut evaluations, .. } = direct;
    if !force.is_finite().or(stalled.not()).all() {
        return Err(StepFailure::NonFinite { quantity: Quantity::Force, dof, value: force.to_f64() });
    }
    let (mut x, mut s) = (T::select(stalled, start, x), T::select(stalled, zero, one));
    let mut stride = T::from_f64(0.25);
    loop {
        let arrived = one.le(s);
        if arrived.all() {
            return Ok(Root { x, evaluations });
        }
        let next = s + stride;
        let next = T::select(next.lt(one), next, one);
        let outcome = iterate(next, x, start, arrived, equation);
        evaluations += outcome.evaluations;
        let stalled = outcome.stalled;
        stride *= T::select(stalled, T::from_f64(0.25), T::from_f64(2.0));
        if stalled.any() {
            cold_path();
            if stalled.and(stride.lt(T::from_f64(SHORTEST))).any() || evaluations > MOST {
                // Just before the end of a branch it has another beside it, just after a fork two.
                for share in [s, next, one] {
                    if T::LANES == 1 && several(share, x, start, equation) {
                        return Err(StepFailure::SeveralSolutions { dof, share: share.to_f64() });
                    }
                }
                let update = outcome.update.to_f64();
                return Err(StepFailure::NewtonStalled { dof, iterations: evaluations, update });
            }
        }
        (x, s) = (T::select(stalled, x, outcome.x), T::select(stalled, s, next));
    }
}

/// Solves `x = start - F(s, x)` from `x`, which is on the way from s = 0. Lanes that wait stay.
#[inline(always)]
fn iterate<T: Scalar>(s: T, x: T, start: T, waiting: T::Mask, equation: &mut impl Equation<T>) -> Outcome<T> {
    let first = equation.at(s, x);
    if !is_gentle(first.slope).and(waiting.not()).any() {
        return carefully::<_, _, false>(s, start, Twice::once(x, waiting, first), equation);
    }
    let mut twice = twice::<_, false>(s, x, start, first, equation);
    twice.end = T::select(waiting, x, twice.end);
    twice.done = twice.done.or(waiting);
    if twice.done.all() {
        let none = T::one().lt(T::zero());
        return Outcome { x: twice.end, stalled: none, update: T::zero(), evaluations: 2 };
    }
    carefully::<_, _, false>(s, start, twice, equation)
}
