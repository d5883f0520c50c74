//! Newton's method for a scalar equation, with chord corrections, bisection and continuation.
//!
//! **Convergence.** There is one criterion: x has converged if the next update is below the
//! rounding error of x. With g(x) = x + F(x) - start and ε the unit roundoff, that error is
//!
//! ```text
//! scale = ε (|x| + (|start| + argument_rounding) / (1 + F')) + the rounding error of F / (1 + F')
//! ```
//!
//! because a residual with the error ε (|start| + argument_rounding) moves x by this error over g'.
//! It is established in three ways.
//!
//! 1. The next update, predicted from the last two (`Correction`), is below ε (|x| + ..). This is
//!    the ordinary case.
//! 2. Updates no longer shrink and are below the rounding error of F: the bound `value_rounding` of
//!    the equation, or the measured error, which is the change of F between neighbouring numbers
//!    beyond its slope (`measure_rounding`).
//! 3. Residuals of opposite signs are closer to each other than `scale` (`Bracket`), so that every
//!    update between them is below it. This needs no knowledge of F and also holds where F jumps by
//!    its rounding: terms that underflow, forces that cancel, functions constant to rounding.

mod bracket;
mod branch;
mod iteration;
mod rounding;
mod third_correction;
mod two_corrections;

use super::{Equation, Root, Sample, Solver};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use branch::continue_from_start;
use iteration::iterate_to_rounding;
use std::hint::cold_path;
use two_corrections::{TwoCorrections, two_corrections};

pub(super) use rounding::{MeasuredRounding, Point, measure_rounding};

/// Newton's method to rounding. An ordinary step takes two evaluations.
///
/// Corrections reuse the last inverse slope (chords) while they contract fast, so that an ordinary
/// step needs one division. After sixteen evaluations the iteration stays between residuals of
/// opposite signs, and bisects where a correction would not halve their distance. If the slopes
/// allow for a fold on the way, or the iteration does not converge, the solution is continued from
/// s = 0 instead. If its branch ends, the step fails: [`StepFailure::SeveralSolutions`] if other
/// solutions are found, else [`StepFailure::NewtonStalled`].
///
/// The lanes of a SIMD scalar are treated as if each were alone; if one fails, the step fails.
/// Between the points where it is evaluated, the slope is assumed to be a parabola. A force that
/// oscillates within a step may therefore lead to another solution that goes unnoticed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Newton;

/// The largest |1 - (1 + F') y| for which the inverse slope y is improved by multiplications
/// instead of computed anew by a division; between 0 and 1. One improvement squares it, so that
/// 1/16 leaves 1/256.
const MOST_MISSING: f64 = 0.0625;

impl Newton {
    /// The solution if two evaluations suffice in every lane; the same to the bit as that of
    /// `solve`.
    #[inline(always)]
    pub fn ordinary<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        let first = equation.at(T::one(), start);
        let pair = two_corrections::<_, true>(T::one(), start, start, first, &mut equation);
        pair.done.all().then_some(pair.root())
    }

    /// The solution for a caller that corrects it further. Two evaluations suffice in lanes whose
    /// next update is below this number of `roundings` of x; the others are solved to rounding.
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
        let pair = two_corrections::<_, true>(T::one(), start, start, first, &mut equation);
        let near = pair
            .improvable
            .and(pair.correction.next_is_rounding(T::from_f64(roundings) * pair.scale));
        if near.all() {
            return Ok(pair.root());
        }
        let Root { x, evaluations } = Newton.solve(dof, start, equation)?;
        Ok(Root { x: T::select(near, pair.end, x), evaluations: evaluations + 2 })
    }

    /// The direct iteration alone, without continuation. It gives a solution if, in every lane, it
    /// converges and the slopes on the way are positive as far as they are evaluated.
    #[inline(always)]
    pub fn direct<T: Scalar>(start: T, mut equation: impl Equation<T>) -> Option<Root<T>> {
        let first = equation.at(T::one(), start);
        let mut pair = two_corrections::<_, true>(T::one(), start, start, first, &mut equation);
        if pair.done.all() {
            return Some(pair.root());
        }
        if let Some(root) = pair.corrected_again(start, &mut equation) {
            return Some(root);
        }
        let outcome = iterate_to_rounding::<_, _, true>(T::one(), start, pair, &mut equation);
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
        let mut pair = two_corrections::<_, true>(T::one(), start, start, first, &mut equation);
        if pair.done.all() {
            return Ok(pair.root());
        }
        cold_path();
        pair.accept_at_rest();
        if pair.done.all() {
            return Ok(pair.root());
        }
        solve_with_care(dof, start, first.value, pair, equation)
    }
}

/// Solves an equation for which two corrections were not enough in every lane, by a third, by
/// iteration or by continuation. It takes the equation itself: an ordinary step would have to keep
/// an equation in memory to which a reference is passed.
#[inline(never)]
fn solve_with_care<T: Scalar>(
    dof: usize,
    start: T,
    force: T,
    mut pair: TwoCorrections<T>,
    mut equation: impl Equation<T>,
) -> Result<Root<T>, StepFailure> {
    let (_, first) = pair.first;
    if !first.slope.is_finite().all() {
        let first = with_any_slope(first);
        pair = two_corrections::<_, true>(T::one(), start, start, first, &mut equation);
    }
    if let Some(root) = pair.corrected_again(start, &mut equation) {
        return Ok(root);
    }
    let outcome = iterate_to_rounding::<_, _, true>(T::one(), start, pair, &mut equation);
    if outcome.stalled.any() {
        return continue_from_start(dof, start, force, outcome, &mut equation);
    }
    Ok(Root { x: outcome.x, evaluations: outcome.evaluations })
}

/// The sample with the slope 0 in lanes where the derivative of F has no value, as that of v √|v|
/// at rest as it is written. The iteration may begin with any slope.
fn with_any_slope<T: Scalar>(first: Sample<T>) -> Sample<T> {
    let finite = first.slope.is_finite();
    let [slope, argument_rounding] =
        [first.slope, first.argument_rounding].map(|x| T::select(finite, x, T::zero()));
    Sample { slope, argument_rounding, ..first }
}

/// The result of an iteration, lane by lane.
struct Outcome<T: Scalar> {
    x: T,
    /// Lanes in which the iteration did not converge, or met a slope 1 + F' that is not positive.
    stalled: T::Mask,
    update: T,
    evaluations: u32,
}

/// Whether an inverse slope y with `missing` = 1 - (1 + F') y can be improved by multiplications.
/// For y = 1 this is whether 1 - F' is a first approximation of the inverse.
#[inline(always)]
fn can_be_improved<T: Scalar>(missing: T) -> T::Mask {
    missing.abs().lt(T::from_f64(MOST_MISSING))
}

#[cfg(test)]
mod tests;
