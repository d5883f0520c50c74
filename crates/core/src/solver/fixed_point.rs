//! Fixed-point iteration, as in the paper.

use super::convergence::{UPDATE_ROUNDINGS, Updates};
use super::newton::{MeasuredRounding, Point, measure_rounding};
use super::{Equation, Root, Solver};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use crate::quantity::Quantity;

/// The iteration `x ← start - F(1, x)`, until the update no longer shrinks. It contracts if |∂F/∂x|
/// < 1, which bounds the step. (The tolerance of the paper, 1e-18, is below the rounding of `f64`
/// and is never reached there.)
#[derive(Clone, Copy, Debug, Default)]
pub struct FixedPoint;

/// The largest number of iterations. A choice: it allows contraction factors up to about 0.996 in
/// `f64`.
const MOST_ITERATIONS: u32 = 10_000;
/// A fast contraction ends after this number of iterations in a row without a smaller update. The
/// number is at least 2, since a single update may grow on the way to a solution. A contraction
/// with the factor r is given 1/(1 - r) times as many iterations.
const STALLED_ITERATIONS: u32 = 3;

impl Solver for FixedPoint {
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        mut equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let one = T::one();
        let (mut x, mut seen) = (start, None);
        let mut updates = Updates::none();
        for evaluations in 1..=MOST_ITERATIONS {
            let f = equation.at(T::one(), x);
            if !f.value.is_finite().all() {
                return Err(StepFailure::NonFinite {
                    quantity: Quantity::Force,
                    dof,
                    value: f.value.to_f64(),
                });
            }
            let last = x;
            x = start - f.value;
            let at = Point { x: last, slope: one + f.slope, residual: x - last };
            let edge = [seen.unwrap_or(at), at];
            seen = Some(at);
            let update = (x - last).abs();
            if update.le(T::zero()).all() {
                return Ok(Root { x, evaluations });
            }
            updates.see(update);
            // Noise hides a slow contraction: with the factor |F'| it shows after 1/(1 - |F'|)
            // iterations.
            let gap = one - f.slope.abs();
            if updates.stalled(STALLED_ITERATIONS) && gap.le(T::zero()).any() {
                return Err(not_contracting(dof, evaluations, updates));
            }
            if T::from_f64(f64::from(STALLED_ITERATIONS))
                .le(T::from_f64(f64::from(updates.waited())) * gap)
                .all()
            {
                // Updates of a contraction stop shrinking at the noise of F, unless they never came
                // close.
                let small = T::from_f64(UPDATE_ROUNDINGS * T::EPSILON)
                    * (start.abs() + x.abs() + f.value_rounding);
                let smallest = updates.smallest();
                let small = small + Self::rounding(start, edge, smallest.le(small), &mut equation);
                // If F' > 0 the iterates alternate around the solution, by many roundings if F' is
                // near 1.
                let x = T::select(T::zero().lt(f.slope), (last + x).half(), x);
                return if smallest.le(small).all() {
                    Ok(Root { x, evaluations })
                } else {
                    Err(not_contracting(dof, evaluations, updates))
                };
            }
        }
        Err(not_contracting(dof, MOST_ITERATIONS, updates))
    }
}

fn not_contracting<T: Scalar>(dof: usize, iterations: u32, updates: Updates<T>) -> StepFailure {
    StepFailure::NotContracting { dof, iterations, ratio: updates.ratio().to_f64() }
}

impl FixedPoint {
    /// Twice the rounding error of F that is measured between the last two points, in the
    /// lanes in which the bound does not suffice.
    #[cold]
    fn rounding<T: Scalar>(
        start: T,
        edge: [Point<T>; 2],
        known: T::Mask,
        equation: &mut impl Equation<T>,
    ) -> T {
        if known.all() {
            return T::zero();
        }
        let MeasuredRounding { size, rounding, .. } =
            measure_rounding(T::one(), start, edge, known.not(), equation);
        T::select(rounding, size + size, T::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::Sample;

    fn kepler(eccentricity: f64) -> impl FnMut(f64, f64) -> Sample<f64> {
        move |s, x| Sample {
            value: -s * eccentricity * x.sin(),
            slope: -s * eccentricity * x.cos(),
            argument_rounding: 0.0,
            value_rounding: 0.0,
        }
    }

    #[test]
    fn contracts_to_rounding() {
        let root = FixedPoint.solve(0, 1.0, kepler(0.5)).unwrap();
        assert!((root.x - 1.0 - 0.5 * root.x.sin()).abs() < 4e-16);
        assert!(root.evaluations > 10, "{root:?}");
    }

    #[test]
    fn says_that_it_does_not_contract() {
        let failure = FixedPoint
            .solve(3, 1.0, |_, x| Sample {
                value: 2.0 * x,
                slope: 2.0,
                argument_rounding: 0.0,
                value_rounding: 0.0,
            })
            .unwrap_err();
        let StepFailure::NotContracting { dof: 3, iterations: 4, ratio } = failure else {
            panic!("{failure}")
        };
        assert!((ratio - 2.0).abs() < 1e-12);
    }
}
