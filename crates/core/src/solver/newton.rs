//! Newton's method for a scalar equation, with chord corrections and continuation.

use super::{Root, Sample, Solver};
use crate::{Mask, Quantity, Scalar, StepFailure};
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

impl Newton {
    /// The direct iteration alone, without the continuation: none where it does not lead, in every lane, to a solution to
    /// which the slope stays positive.
    #[inline(always)]
    pub fn direct<T: Scalar>(start: T, equation: impl FnMut(T) -> Sample<T>) -> Option<Root<T>> {
        iterate(start, start, equation).ok()
    }
}

impl Solver for Newton {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        mut equation: impl FnMut(T, T) -> Sample<T>,
    ) -> Result<Root<T>, StepFailure> {
        match iterate(start, start, |x| equation(T::one(), x)) {
            Ok(root) => Ok(root),
            Err(stalled) => follow(dof, start, equation, stalled.evaluations),
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
    mut equation: impl FnMut(T) -> Sample<T>,
) -> Result<Root<T>, Stalled> {
    let one = T::one();
    let (mut inverse, mut rest) = (one, T::zero());
    let mut update = T::zero();
    let mut rising = T::zero().lt(one);
    // Lanes that are done wait for the others.
    let mut done = one.lt(T::zero());
    for evaluations in 1..LIMIT + 1 {
        let f = equation(x);
        // Newton's iteration for the inverse, y ← y (2 - (1 + F') y), squares what y misses, and nothing waits for a
        // division. An inverse that misses much is made anew: also the one of any slope that is not positive.
        let before = rest;
        let missing = (-f.slope).mul_add(inverse, one - inverse);
        rest = missing * missing;
        let anew = T::from_f64(0.0625).lt(missing.abs());
        inverse = inverse.mul_add(missing, inverse);
        if anew.any() {
            cold_path();
            let derivative = one + f.slope;
            rising = rising.and(T::zero().lt(derivative));
            rest = T::select(anew, T::zero(), rest);
            inverse = T::select(anew, derivative.recip(), inverse);
        }
        let previous = update;
        let residual = start - x - f.value;
        update = residual * inverse;
        x = T::select(done, x, residual.mul_add(inverse, x));
        if evaluations == 1 {
            continue;
        }
        let (size, largest) = (update.abs(), previous.abs());
        let scale = T::from_f64(T::EPSILON) * (start.abs() + f.rough).mul_add(inverse.abs(), x.abs());
        // An error e becomes e (r + c + d): r the rest the inverse misses, c what the slope changes over e/2, d what a
        // slope that is not quite the derivative is off by. The correction before shows them: it shrank by r + c + d,
        // and the slope has changed by 2 c since, so that r + 2 c was missing. The next r and c are smaller by a
        // factor, d is not.
        let off = (before + missing).half().mul_add(-previous, update).abs();
        let contraction = missing.abs().mul_add(largest, size);
        let next = contraction.mul_add(contraction, off * largest) * size;
        // Done where the next correction would be lost in rounding.
        done = done.or(next.lt(scale * (largest * largest)));
        if !done.all() {
            // Corrections that stopped shrinking are the noise of F.
            let noise = f.blur.mul_add(inverse.abs(), scale / T::from_f64(T::EPSILON));
            let small = size.le(T::from_f64(T::EPSILON.sqrt()) * noise);
            done = done.or(small.and(largest.le(size + size)));
            if !done.all() {
                continue;
            }
        }
        return if rising.all() {
            Ok(Root { x, evaluations })
        } else {
            Err(Stalled { update: 0.0, evaluations })
        };
    }
    Err(Stalled { update: update.to_f64(), evaluations: LIMIT })
}

/// Follows the solution from s = 0 to s = 1.
#[cold]
fn follow<T: Scalar>(
    dof: usize,
    start: T,
    mut equation: impl FnMut(T, T) -> Sample<T>,
    mut evaluations: u32,
) -> Result<Root<T>, StepFailure> {
    let force = equation(T::one(), start).value;
    if !force.is_finite().all() {
        return Err(StepFailure::NonFinite { quantity: Quantity::Force, dof, value: force.to_f64() });
    }
    let (mut x, mut s, mut stride) = (start, 0.0_f64, 0.25_f64);
    while s < 1.0 {
        let next = (s + stride).min(1.0);
        match iterate(x, start, |x| equation(T::from_f64(next), x)) {
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
    fn cubic<T: Scalar>(a: f64, b: f64) -> impl FnMut(T, T) -> Sample<T> {
        let (a, b) = (T::from_f64(a), T::from_f64(b));
        move |s, x| Sample {
            value: s * (a * x + b * x * x * x),
            slope: s * (a + T::from_f64(3.0) * b * x * x),
            rough: T::zero(),
            blur: T::zero(),
        }
    }

    #[test]
    fn one_newton_and_one_chord_correction_solve_an_ordinary_step() {
        let root = Newton.solve(0, 1.0, cubic(1e-4, 1e-5)).unwrap();
        assert!((root.x * (1.0 + 1e-4 + 1e-5 * root.x * root.x) - 1.0).abs() < 3e-16);
        assert_eq!(root.evaluations, 2);
    }

    #[test]
    fn stiff_and_steep_equations_are_solved_to_rounding() {
        for (a, b, start) in
            [(1e6, 0.0, 3.0), (5.0, 1e8, -2.0), (-0.5, 1e3, 1e-9), (0.0, 1.0, 1e6), (2.0, 3.0, 0.0)]
        {
            let f64_root = Newton.solve(0, start, cubic(a, b)).unwrap().x;
            let root = Newton.solve(0, Quad::from_f64(start), cubic(a, b)).unwrap().x;
            let value = root + cubic(a, b)(Quad::ONE, root).value;
            assert!((value.to_f64() - start).abs() <= 1e-28 * start.abs(), "{a} {b} {start}");
            assert!((f64_root - root.to_f64()).abs() <= 4e-16 * root.to_f64().abs(), "{a} {b} {start}");
        }
    }

    #[test]
    fn the_solution_taken_is_the_one_that_leads_back_to_the_start() {
        // Three solutions: about -10, -0.1 and 10.1; only the last is reached from s = 0 with a rising slope.
        let root = Newton.solve(0, 1.0, cubic(-11.0, 0.1)).unwrap();
        assert!((root.x - 10.05).abs() < 0.1, "{root:?}");
    }

    #[test]
    fn a_lost_solution_is_a_failure() {
        // x + s (x² - 4x + 6) = 0 has no real solution once s > 0.11.
        let failure = Newton
            .solve(1, 0.0, |s: f64, x: f64| Sample {
                value: s * (x * x - 4.0 * x + 6.0),
                slope: s * (2.0 * x - 4.0),
                rough: 0.0,
                blur: 0.0,
            })
            .unwrap_err();
        assert!(matches!(failure, StepFailure::NewtonStalled { dof: 1, .. }), "{failure}");
    }
}
