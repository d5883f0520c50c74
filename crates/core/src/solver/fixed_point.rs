//! Simple iteration, as in the paper.

use super::newton::{Grain, Point, grain};
use super::{Equation, Root, Solver};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use crate::quantity::Quantity;

/// `x ← start - F(1, x)`, until the update no longer shrinks. (The paper's tolerance of 1e-18 is below the rounding
/// of `f64` and is never reached there.) Contracts where |∂F/∂x| < 1, which bounds the step.
#[derive(Clone, Copy, Debug, Default)]
pub struct FixedPoint;

/// Iterations after which a contraction, however slow, is given up.
const LIMIT: u32 = 10_000;
/// Iterations without a smaller update that end a fast contraction. One alone may be a detour on the way.
const PATIENCE: u32 = 3;

impl Solver for FixedPoint {
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        mut equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let one = T::one();
        let (mut x, mut seen) = (start, None);
        let mut smallest = T::from_f64(f64::MAX);
        let (mut before, mut ratio, mut waited) = (smallest, f64::INFINITY, 0);
        for evaluations in 1..=LIMIT {
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
            ratio = (update / before).to_f64();
            waited = if update.lt(smallest).all() { 0 } else { waited + 1 };
            // Noise hides the shrinking of a slow contraction: at the rate |F'| it takes 1/(1 - |F'|) iterations to show.
            let gap = one - f.slope.abs();
            if waited >= PATIENCE && gap.le(T::zero()).any() {
                return Err(StepFailure::NotContracting { dof, iterations: evaluations, ratio });
            }
            if T::from_f64(f64::from(PATIENCE)).le(T::from_f64(f64::from(waited)) * gap).all() {
                // What a contraction stops shrinking at is the noise of F, unless it never got close.
                let small = T::from_f64(64.0 * T::EPSILON) * (start.abs() + x.abs() + f.value_rounding);
                let small = small + Self::rounding(start, edge, smallest.le(small), &mut equation);
                // Where F rises, iterates alternate around the solution, by many roundings if F' is near 1.
                let x = T::select(T::zero().lt(f.slope), (last + x).half(), x);
                return if smallest.le(small).all() {
                    Ok(Root { x, evaluations })
                } else {
                    Err(StepFailure::NotContracting { dof, iterations: evaluations, ratio })
                };
            }
            smallest = T::select(update.lt(smallest), update, smallest);
            before = update;
        }
        Err(StepFailure::NotContracting { dof, iterations: LIMIT, ratio })
    }
}

impl FixedPoint {
    /// Twice the rounding of F that is seen on an edge, in the lanes in which it is not known to be
    /// small.
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
        let Grain { size, rounding, .. } = grain(T::one(), start, edge, known.not(), equation);
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
