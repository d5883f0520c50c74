//! Simple iteration, as in the paper.

use super::{Root, Solver};
use crate::{Line, Mask, Quantity, Scalar, StepFailure};

/// `x ← start - F(1, x)`, until the update no longer shrinks. (The paper's tolerance of 1e-18 is below the rounding
/// of `f64` and is never reached there.) Contracts where |∂F/∂x| < 1, which bounds the step.
#[derive(Clone, Copy, Debug, Default)]
pub struct FixedPoint;

/// Iterations after which a contraction, however slow, is given up.
const LIMIT: u32 = 10_000;

impl Solver for FixedPoint {
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        reach: T,
        mut equation: impl FnMut(T, T) -> Line<T>,
    ) -> Result<Root<T>, StepFailure> {
        let mut x = start;
        let mut update = T::from_f64(f64::MAX);
        let mut ratio = f64::INFINITY;
        for evaluations in 1..=LIMIT {
            let f = equation(T::one(), x);
            if !f.value.is_finite().all() {
                return Err(StepFailure::NonFinite {
                    quantity: Quantity::Force,
                    dof,
                    value: f.value.to_f64(),
                });
            }
            let next = start - f.value;
            let shift = (next - x).abs();
            x = next;
            if !shift.lt(update).all() {
                // Rounding is all that is left, or there is no contraction.
                let floor = (start.abs() + x.abs() + f.slope.abs() * reach) * T::from_f64(16.0 * T::EPSILON);
                if shift.le(floor).all() {
                    return Ok(Root { x, evaluations });
                }
                if evaluations > 3 {
                    ratio = (shift / update).to_f64();
                    return Err(StepFailure::NotContracting { dof, iterations: evaluations, ratio });
                }
            }
            update = shift;
        }
        Err(StepFailure::NotContracting { dof, iterations: LIMIT, ratio })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kepler(eccentricity: f64) -> impl FnMut(f64, f64) -> Line<f64> {
        move |s, x| Line { value: -s * eccentricity * x.sin(), slope: -s * eccentricity * x.cos() }
    }

    #[test]
    fn contracts_to_rounding() {
        let root = FixedPoint.solve(0, 1.0, 0.0, kepler(0.5)).unwrap();
        assert!((root.x - 1.0 - 0.5 * root.x.sin()).abs() < 4e-16);
        assert!(root.evaluations > 10, "{root:?}");
    }

    #[test]
    fn says_that_it_does_not_contract() {
        let failure = FixedPoint.solve(3, 1.0, 0.0, |_, x| Line { value: 2.0 * x, slope: 2.0 }).unwrap_err();
        let StepFailure::NotContracting { dof: 3, iterations: 4, ratio } = failure else {
            panic!("{failure}")
        };
        assert!((ratio - 2.0).abs() < 1e-12);
    }
}
