//! Newton's method for a scalar equation, with chord corrections and continuation.

use super::{Root, Solver};
use crate::{Line, Mask, Quantity, Scalar, StepFailure};
use std::hint::cold_path;

/// Newton's iteration to rounding. Corrections with the last slope (chords) follow while they contract fast, so that
/// an ordinary step needs one division; where the slope has been negative on the way, or nothing converges, the
/// solution is followed from s = 0 instead, and its loss is a failure.
#[derive(Clone, Copy, Debug, Default)]
pub struct Newton;

/// Corrections before the direct iteration is given up.
const LIMIT: u32 = 50;
/// The shortest step in s of the continuation.
const SHORTEST: f64 = 1e-6;

impl Solver for Newton {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        reach: T,
        mut equation: impl FnMut(T, T) -> Line<T>,
    ) -> Result<Root<T>, StepFailure> {
        match iterate(start, start, reach, |x| equation(T::one(), x)) {
            Ok(root) => Ok(root),
            Err(stalled) => follow(dof, start, reach, equation, stalled.evaluations),
        }
    }
}

/// The direct iteration has not led to a solution the slope stays positive to.
struct Stalled {
    update: f64,
    evaluations: u32,
}

/// Solves `x = start - F(x)` from `x`.
#[inline(always)]
fn iterate<T: Scalar>(
    mut x: T,
    start: T,
    reach: T,
    mut equation: impl FnMut(T) -> Line<T>,
) -> Result<Root<T>, Stalled> {
    let first = equation(x);
    let mut rising = T::zero().lt(T::one() + first.slope);
    let mut slope = first.slope;
    let mut inverse = (T::one() + slope).recip();
    // Where F is nearly flat 1 - F' + F'² will do for the inverse, and nothing waits for the division.
    let steep = T::from_f64(0.0625).lt(slope.abs()).any();
    let gain = if steep { inverse } else { slope.mul_add(slope - T::one(), T::one()) };
    let residual = start - x - first.value;
    let mut update = residual * gain;
    x = residual.mul_add(gain, x);
    let mut evaluations = 1;
    while evaluations < LIMIT {
        let f = equation(x);
        evaluations += 1;
        rising = rising.and(T::zero().lt(T::one() + f.slope));
        // What a correction with the old slope leaves of the error. One that gains less than a digit is replaced by
        // Newton's own, of which nothing is known before the next slope.
        let mut contraction = (f.slope - slope).abs() * inverse.abs();
        if T::from_f64(0.1).lt(contraction).any() {
            cold_path();
            slope = f.slope;
            inverse = (T::one() + slope).recip();
            contraction = T::one();
        }
        let previous = update.abs();
        let residual = start - x - f.value;
        update = residual * inverse;
        x = residual.mul_add(inverse, x);
        let size = update.abs();
        let scale = f.slope.abs().mul_add(reach, start.abs()).mul_add(inverse.abs(), x.abs());
        let resolution = T::from_f64(T::EPSILON) * scale;
        // Done where the next correction would be lost in rounding, or corrections stopped shrinking at the noise of F.
        let lost = (contraction * size).le(resolution);
        let noise = size.le(T::from_f64(T::EPSILON.sqrt()) * scale).and(previous.le(size + size));
        if lost.or(noise).all() {
            return if rising.all() {
                Ok(Root { x, evaluations })
            } else {
                Err(Stalled { update: 0.0, evaluations })
            };
        }
    }
    Err(Stalled { update: update.to_f64(), evaluations })
}

/// Follows the solution from s = 0 to s = 1.
#[cold]
fn follow<T: Scalar>(
    dof: usize,
    start: T,
    reach: T,
    mut equation: impl FnMut(T, T) -> Line<T>,
    mut evaluations: u32,
) -> Result<Root<T>, StepFailure> {
    let force = equation(T::one(), start).value;
    if !force.is_finite().all() {
        return Err(StepFailure::NonFinite { quantity: Quantity::Force, dof, value: force.to_f64() });
    }
    let (mut x, mut s, mut stride) = (start, 0.0_f64, 0.25_f64);
    while s < 1.0 {
        let next = (s + stride).min(1.0);
        match iterate(x, start, reach, |x| equation(T::from_f64(next), x)) {
            Ok(root) => {
                evaluations += root.evaluations;
                (x, s) = (root.x, next);
                stride *= 2.0;
            }
            Err(stalled) => {
                evaluations += stalled.evaluations;
                stride *= 0.25;
                if stride < SHORTEST {
                    return Err(StepFailure::NewtonStalled {
                        dof,
                        iterations: evaluations,
                        update: stalled.update,
                    });
                }
            }
        }
    }
    Ok(Root { x, evaluations })
}

#[cfg(test)]
mod tests {
    use super::*;
    use qd::Quad;

    /// x + s (a x + b x³) = start
    fn cubic<T: Scalar>(a: f64, b: f64) -> impl FnMut(T, T) -> Line<T> {
        let (a, b) = (T::from_f64(a), T::from_f64(b));
        move |s, x| Line { value: s * (a * x + b * x * x * x), slope: s * (a + T::from_f64(3.0) * b * x * x) }
    }

    #[test]
    fn one_newton_and_one_chord_correction_solve_an_ordinary_step() {
        let root = Newton.solve(0, 1.0, 0.0, cubic(1e-4, 1e-5)).unwrap();
        assert!((root.x * (1.0 + 1e-4 + 1e-5 * root.x * root.x) - 1.0).abs() < 3e-16);
        assert_eq!(root.evaluations, 2);
    }

    #[test]
    fn stiff_and_steep_equations_are_solved_to_rounding() {
        for (a, b, start) in
            [(1e6, 0.0, 3.0), (5.0, 1e8, -2.0), (-0.5, 1e3, 1e-9), (0.0, 1.0, 1e6), (2.0, 3.0, 0.0)]
        {
            let f64_root = Newton.solve(0, start, 0.0, cubic(a, b)).unwrap().x;
            let root = Newton.solve(0, Quad::from_f64(start), Quad::ZERO, cubic(a, b)).unwrap().x;
            let value = root + cubic(a, b)(Quad::ONE, root).value;
            assert!((value.to_f64() - start).abs() <= 1e-28 * start.abs(), "{a} {b} {start}");
            assert!((f64_root - root.to_f64()).abs() <= 4e-16 * root.to_f64().abs(), "{a} {b} {start}");
        }
    }

    #[test]
    fn the_solution_taken_is_the_one_that_leads_back_to_the_start() {
        // Three solutions: about -10, -0.1 and 10.1; only the last is reached from s = 0 with a rising slope.
        let root = Newton.solve(0, 1.0, 0.0, cubic(-11.0, 0.1)).unwrap();
        assert!((root.x - 10.05).abs() < 0.1, "{root:?}");
    }

    #[test]
    fn a_lost_solution_is_a_failure() {
        // x + s (x² - 4x + 6) = 0 has no real solution once s > 0.11.
        let failure = Newton
            .solve(1, 0.0, 0.0, |s: f64, x: f64| Line {
                value: s * (x * x - 4.0 * x + 6.0),
                slope: s * (2.0 * x - 4.0),
            })
            .unwrap_err();
        assert!(matches!(failure, StepFailure::NewtonStalled { dof: 1, .. }), "{failure}");
    }
}
