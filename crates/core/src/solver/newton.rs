//! Newton's method for a scalar equation, with chord corrections, bisection and continuation.
//!
//! **Convergence.** There is one rule: x has converged where the next update is below the rounding
//! of what it moves. With g(x) = x + F(x) - start and ε the unit roundoff, that rounding is
//!
//! ```text
//! scale = ε (|x| + (|start| + argument_rounding) / (1 + F')) + the rounding of F / (1 + F')
//! ```
//!
//! as a residual rounded by ε (|start| + argument_rounding) moves x by that much over g'. The rule is met in
//! three ways. (1) The next update, computed from the last two (`Correction`), is below ε (|x| +
//! ..): the ordinary end. (2) Updates that no longer shrink are below the rounding of F: the bound
//! `value_rounding` that the equation states, or the rounding that is seen, which is what F changes by
//! between neighbouring numbers beyond its slope (`grain`). (3) Residuals of opposite signs stand
//! closer to each other than `scale`: every update between them is below it (`Bracket`). The last
//! needs no knowledge of F, and holds also where F jumps by its rounding: tails that underflow,
//! forces that cancel, functions that are constant to rounding.

mod bracket;
mod course;
mod follow;
mod grain;
mod twice;

use super::{Equation, Root, Sample, Solver};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use course::carefully;
use follow::follow;
use std::hint::cold_path;
use twice::twice;

pub(super) use grain::{Grain, Point, grain};

/// Newton's iteration to rounding: two evaluations where that is enough, which is the ordinary
/// step.
///
/// Corrections with the last slope (chords) follow while they contract fast, so that an ordinary
/// step needs one division. An iteration that is still under way after sixteen evaluations stays
/// between residuals of opposite signs and halves their distance where a correction would not.
/// Where the slopes seen allow for a fold on the way, or nothing converges, the solution is
/// followed from s = 0 instead, and its loss is a failure: [`StepFailure::SeveralSolutions`] where
/// other solutions are seen, else [`StepFailure::NewtonStalled`]. A scalar of several lanes
/// iterates and follows each of them as it would alone; where one is lost, all fail. The slope
/// between the points where it is seen is taken for a parabola, so that a force that turns often
/// within a step may still lead to another solution, unseen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Newton;

/// What an inverse may miss and still be improved instead of made anew.
const GENTLE: f64 = 0.0625;

impl Newton {
    /// The solution where two evaluations give it in every lane, the same to the bit as with more care.
    #[inline(always)]
    pub fn ordinary<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        let first = equation.at(T::one(), start);
        let twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        twice.done.all().then_some(twice.root())
    }

    /// The solution for a caller that corrects it: two evaluations where the next update is below
    /// so many roundings of what it moves, as [`Newton`] gives it elsewhere, in each lane.
    ///
    /// # Errors
    /// A [`StepFailure`] of degree of freedom `dof`.
    #[inline(always)]
    pub fn nearly<T: Scalar>(
        dof: usize,
        start: T,
        mut equation: impl Equation<T>,
        roundings: f64,
    ) -> Result<Root<T>, StepFailure> {
        let first = equation.at(T::one(), start);
        let twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        let near = twice.gentle.and(twice.correction.lost(T::from_f64(roundings) * twice.scale));
        if near.all() {
            return Ok(twice.root());
        }
        let Root { x, evaluations } = Newton.solve(dof, start, equation)?;
        Ok(Root { x: T::select(near, twice.end, x), evaluations: evaluations + 2 })
    }

    /// The direct iteration alone, without the continuation: none where it does not lead, in every lane, to a solution to
    /// which the slope stays positive, as far as it is seen.
    #[inline(always)]
    pub fn direct<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        let first = equation.at(T::one(), start);
        let twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        if twice.done.all() {
            return Some(twice.root());
        }
        let outcome = carefully::<_, _, true>(T::one(), start, twice, &mut equation);
        (!outcome.stalled.any()).then_some(Root { x: outcome.x, evaluations: outcome.evaluations })
    }
}

impl Solver for Newton {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        mut equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let first = equation.at(T::one(), start);
        let mut twice = twice::<_, true>(T::one(), start, start, first, &mut equation);
        if twice.done.all() {
            return Ok(twice.root());
        }
        cold_path();
        twice.rest();
        if twice.done.all() {
            return Ok(twice.root());
        }
        let outcome = carefully::<_, _, true>(T::one(), start, twice, &mut equation);
        if outcome.stalled.any() {
            return follow(dof, start, first.value, outcome, &mut equation);
        }
        Ok(Root { x: outcome.x, evaluations: outcome.evaluations })
    }
}

/// Where an iteration has led, each lane by itself.
struct Outcome<T: Scalar> {
    x: T,
    /// Lanes in which it has not led to a solution the slope stays positive to.
    stalled: T::Mask,
    update: T,
    evaluations: u32,
}

/// May an inverse that misses so much be improved, or the inverse of 1 + F' be 1 - F' at first?
#[inline(always)]
fn is_gentle<T: Scalar>(missing: T) -> T::Mask {
    missing.abs().lt(T::from_f64(GENTLE))
}

#[cfg(test)]
mod tests;
