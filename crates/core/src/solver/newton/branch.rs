//! The branch of solutions that starts at s = 0, followed to s = 1.

use super::iteration::iterate_to_rounding;
use super::two_corrections::{TwoCorrections, two_corrections};
use super::{Equation, Outcome, Root, can_be_improved};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use crate::quantity::Quantity;
use crate::solver::continuation::{Limits, Position};
use crate::solver::several_solutions::has_several_solutions;

/// Continues the solution from s = 0 to s = 1 in the lanes in which the direct iteration failed,
/// each with its own steps in s.
#[cold]
#[inline(never)]
pub(super) fn continue_from_start<T: Scalar, E: Equation<T>>(
    dof: usize,
    start: T,
    force: T,
    direct: Outcome<T>,
    equation: &mut E,
) -> Result<Root<T>, StepFailure> {
    let (zero, one) = (T::zero(), T::one());
    let Outcome { x, stalled, mut evaluations, .. } = direct;
    if !force.is_finite().or(stalled.not()).all() {
        return Err(StepFailure::NonFinite {
            quantity: Quantity::Force,
            dof,
            value: force.to_f64(),
        });
    }
    let mut x = T::select(stalled, start, x);
    let mut position = Position::at(T::select(stalled, zero, one), Limits::OF_FOLDS);
    loop {
        let (arrived, next) = (position.arrived(), position.next());
        if arrived.all() {
            return Ok(Root { x, evaluations });
        }
        let before = position.s();
        let outcome = iterate(next, x, start, arrived, equation);
        evaluations += outcome.evaluations;
        if !position.advance(outcome.stalled, evaluations) {
            // Just before a fold there is a second solution, just after a fork there are two more.
            for share in [before, next, one] {
                if T::LANES == 1 && has_several_solutions(share, x, start, equation) {
                    return Err(StepFailure::SeveralSolutions { dof, share: share.to_f64() });
                }
            }
            let update = outcome.update.to_f64();
            return Err(StepFailure::NewtonStalled { dof, iterations: evaluations, update });
        }
        x = T::select(outcome.stalled, x, outcome.x);
    }
}

/// Solves `x = start - F(s, x)` from the solution `x` at a smaller s. Lanes in `waiting` keep their
/// x.
#[inline(always)]
fn iterate<T: Scalar>(
    s: T,
    x: T,
    start: T,
    waiting: T::Mask,
    equation: &mut impl Equation<T>,
) -> Outcome<T> {
    let first = equation.at(s, x);
    if !can_be_improved(first.slope).and(waiting.not()).any() {
        return iterate_to_rounding::<_, _, false>(
            s,
            start,
            TwoCorrections::once(x, waiting, first),
            equation,
        );
    }
    let mut pair = two_corrections::<_, false>(s, x, start, first, equation);
    pair.end = T::select(waiting, x, pair.end);
    pair.done = pair.done.or(waiting);
    if pair.done.all() {
        let none = T::one().lt(T::zero());
        return Outcome { x: pair.end, stalled: none, update: T::zero(), evaluations: 2 };
    }
    iterate_to_rounding::<_, _, false>(s, start, pair, equation)
}
