//! Continuation of the solution from s = 0 to s = 1.

use super::iteration::iterate_to_rounding;
use super::two_corrections::{TwoCorrections, two_corrections};
use super::{Equation, Outcome, Root, can_be_improved};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use crate::quantity::Quantity;
use crate::solver::several_solutions::has_several_solutions;
use std::hint::cold_path;

/// The shortest step of the continuation in s, which goes from 0 to 1. A choice: shorter ones are
/// needed only at a fold or a fork.
const SHORTEST_STEP: f64 = 1e-6;
/// The largest number of evaluations of the continuation. A choice.
const MOST_EVALUATIONS: u32 = 10_000;
/// The first step of the continuation in s, and the factors after a failure and after a success.
const FIRST_STEP: f64 = 0.25;
const SHORTER: f64 = 0.25;
const LONGER: f64 = 2.0;

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
    let (mut x, mut s) = (T::select(stalled, start, x), T::select(stalled, zero, one));
    let mut stride = T::from_f64(FIRST_STEP);
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
        stride *= T::select(stalled, T::from_f64(SHORTER), T::from_f64(LONGER));
        if stalled.any() {
            cold_path();
            if stalled.and(stride.lt(T::from_f64(SHORTEST_STEP))).any()
                || evaluations > MOST_EVALUATIONS
            {
                // Just before a fold there is a second solution, just after a fork there are two
                // more.
                for share in [s, next, one] {
                    if T::LANES == 1 && has_several_solutions(share, x, start, equation) {
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

/// Solves `x = start - F(s, x)` from the solution `x` at a smaller s. Lanes that wait keep their x.
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
