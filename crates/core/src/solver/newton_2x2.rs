//! Newton's method for two equations, to rounding, with continuation.

use super::continuation::{Limits, follow};
use super::convergence::{UPDATE_ROUNDINGS, Updates};
use crate::error::StepFailure;
use crate::numbers::{Mask, Scalar};
use crate::quantity::Quantity;
use std::hint::cold_path;

/// The residuals of two equations at a point, and their Jacobian less the identity.
#[derive(Clone, Copy, Debug)]
pub struct Equations<T> {
    /// The residuals.
    pub residual: [T; 2],
    /// The Jacobian less 1, by rows.
    pub excess: [[T; 2]; 2],
}

/// A solution and the work to find it.
#[derive(Clone, Copy, Debug)]
pub struct Root<T> {
    /// The solution.
    pub x: [T; 2],
    /// The number of evaluations, which is that of the iterations.
    pub evaluations: u32,
}

/// No solution was found along which the determinant stays positive.
struct Stalled {
    update: f64,
    evaluations: u32,
}

/// The largest number of corrections of the direct iteration. A choice: Newton's method needs less
/// than ten where it converges quadratically.
const MOST_CORRECTIONS: u32 = 200;
/// A size far below that of every number in use, so that 0 is not divided by 0.
const SMALLEST_SIZE: f64 = 1e-290;

/// Finds the solution x of `equations(1, x) = 0` that continues from x = 0 at s = 0, where
/// `equations(s, x) = x + O(s)`. x is an increment of `start`. Numbers up to `magnitudes` enter the
/// equations; where updates no longer shrink, an error of up to 64 roundings of `magnitudes` is
/// accepted. The determinant is tested at the iterates only: a long step may jump over a pair of
/// folds to a solution that does not continue from s = 0.
///
/// # Errors
/// A [`StepFailure`] of degree of freedom `dof`.
pub fn solve<T: Scalar>(
    dof: usize,
    start: [T; 2],
    magnitudes: [T; 2],
    mut equations: impl FnMut(T, [T; 2]) -> Equations<T>,
) -> Result<Root<T>, StepFailure> {
    match iterate([T::zero(); 2], start, magnitudes, |x| equations(T::one(), x)) {
        Ok(root) => Ok(root),
        Err(stalled) => continue_from_start(dof, start, magnitudes, equations, stalled.evaluations),
    }
}

/// Solves `equations(x) = 0` from `x`.
#[inline]
fn iterate<T: Scalar>(
    mut x: [T; 2],
    start: [T; 2],
    magnitudes: [T; 2],
    mut equations: impl FnMut([T; 2]) -> Equations<T>,
) -> Result<Root<T>, Stalled> {
    let (zero, one) = (T::zero(), T::one());
    let mut updates: Updates<T> = Updates::none();
    // In each lane, marks updates that grew and may be noise.
    let mut grown = zero;
    for evaluations in 1..=MOST_CORRECTIONS {
        let Equations { residual: [f, g], excess: [[a, b], [c, d]] } = equations(x);
        // The determinant of 1 + (a, b; c, d), without cancellation for small entries.
        let determinant = one + (a + d) + (a * d - b * c);
        if !zero.lt(determinant).all() {
            return Err(Stalled { update: updates.last().to_f64(), evaluations });
        }
        let inverse = determinant.recip();
        let update = [(b * g - (one + d) * f) * inverse, (c * f - (one + a) * g) * inverse];
        x = [x[0] + update[0], x[1] + update[1]];
        if !(update[0] + update[1]).is_finite().all() {
            return Err(Stalled { update: f64::NAN, evaluations });
        }
        let scale = [0, 1].map(|k| start[k].abs() + x[k].abs() + T::from_f64(SMALLEST_SIZE));
        let share = |scale: [T; 2]| {
            let [u, v] = [update[0].abs() / scale[0], update[1].abs() / scale[1]];
            T::select(u.lt(v), v, u)
        };
        updates.see(share(scale));
        // Updates of a converging iteration shrink; updates that are noise grow from time to time.
        let grows = updates.grows();
        if grows.any() {
            cold_path();
            let noise = [
                a.abs() * magnitudes[0] + b.abs() * magnitudes[1],
                c.abs() * magnitudes[0] + d.abs() * magnitudes[1],
            ];
            let spread = [
                ((one + d).abs() * noise[0] + b.abs() * noise[1]) * inverse,
                (c.abs() * noise[0] + (one + a).abs() * noise[1]) * inverse,
            ];
            let small = share([scale[0] + spread[0], scale[1] + spread[1]])
                .le(T::from_f64(UPDATE_ROUNDINGS * T::EPSILON));
            grown = T::select(small.and(grows), grown + one, grown);
        }
        if updates.next_is_at_most(T::from_f64(T::EPSILON)).or(one.lt(grown)).all() {
            return Ok(Root { x, evaluations });
        }
    }
    Err(Stalled { update: updates.last().to_f64(), evaluations: MOST_CORRECTIONS })
}

/// Continues the solution from s = 0 to s = 1.
#[cold]
fn continue_from_start<T: Scalar>(
    dof: usize,
    start: [T; 2],
    magnitudes: [T; 2],
    mut equations: impl FnMut(T, [T; 2]) -> Equations<T>,
    mut evaluations: u32,
) -> Result<Root<T>, StepFailure> {
    let [f, g] = equations(T::one(), [T::zero(); 2]).residual;
    if !(f + g).is_finite().all() {
        return Err(StepFailure::NonFinite {
            quantity: Quantity::Force,
            dof,
            value: (f + g).to_f64(),
        });
    }
    let mut x = [T::zero(); 2];
    let outcome = follow(Limits::OF_FOLDS, |s| {
        let outcome = iterate(x, start, magnitudes, |x| equations(T::from_f64(s), x)).map(|root| {
            x = root.x;
            evaluations += root.evaluations;
        });
        let outcome = outcome.map_err(|stalled| {
            evaluations += stalled.evaluations;
            stalled.update
        });
        (evaluations, outcome)
    });
    match outcome {
        Ok(()) => Ok(Root { x, evaluations }),
        Err(update) => Err(StepFailure::NewtonStalled { dof, iterations: evaluations, update }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x - s (b y + 1) = 0, y + s (c x³ - 1) = 0
    fn cubic(b: f64, c: f64) -> impl FnMut(f64, [f64; 2]) -> Equations<f64> {
        move |s, [x, y]| Equations {
            residual: [x - s * (b * y + 1.0), y + s * (c * x.powi(3) - 1.0)],
            excess: [[0.0, -s * b], [3.0 * s * c * x * x, 0.0]],
        }
    }

    #[test]
    fn equations_are_solved_to_rounding() {
        for (b, c) in [(1e-3, 1e-4), (0.5, 2.0), (3.0, 1e8), (1e4, 1e4)] {
            let Root { x: [x, y], evaluations } =
                solve(0, [0.0; 2], [1.0; 2], cubic(b, c)).unwrap_or_else(|e| panic!("{e}"));
            let [f, g] = cubic(b, c)(1.0, [x, y]).residual;
            let (terms, others) =
                (x.abs() + b * y.abs() + 1.0, y.abs() + c * x.abs().powi(3) + 1.0);
            assert!(f.abs() <= 4e-16 * terms && g.abs() <= 1e-15 * others, "{b} {c}: {f:e} {g:e}");
            assert!(b > 0.1 || evaluations <= 4, "{evaluations}");
        }
    }

    #[test]
    fn slow_convergence_is_no_noise() {
        // x + 1.4 x + 4 y = 1 and y = 0, with 0.7 in place of 1.4 in the Jacobian; the magnitudes
        // are 1e8.
        let root = solve(0, [1.0, 0.0], [1e8; 2], |s: f64, [x, y]: [f64; 2]| Equations {
            residual: [x + s * (1.4 * x + 4.0 * y - 1.0), y],
            excess: [[s * 0.7, s * 4.0], [0.0; 2]],
        });
        assert!(root.is_ok_and(|root| (root.x[0] - 1.0 / 2.4).abs() < 4e-16));
    }

    #[test]
    fn a_lost_solution_is_a_failure() {
        // x + s (x² - 4x + 6) = 0 has no real solution once s > 0.11.
        let failure = solve(1, [0.0; 2], [1.0; 2], |s: f64, [x, y]: [f64; 2]| Equations {
            residual: [x + s * (x * x - 4.0 * x + 6.0), y],
            excess: [[s * (2.0 * x - 4.0), 0.0], [0.0; 2]],
        });
        let Err(StepFailure::NewtonStalled { dof: 1, iterations, .. }) = failure else {
            panic!("no failure")
        };
        assert!(iterations > 50);
    }

    #[test]
    fn the_solution_taken_continues_from_none() {
        // x - 11 x + 0.1 x³ = 1 has solutions about -10, -0.1 and 10.05; the determinant is
        // positive only at the last.
        let root = solve(0, [0.0; 2], [1.0; 2], |s: f64, [x, y]: [f64; 2]| Equations {
            residual: [x - 1.0 + s * (-11.0 * x + 0.1 * x.powi(3)), y],
            excess: [[s * (-11.0 + 0.3 * x * x), 0.0], [0.0; 2]],
        });
        assert!(root.is_ok_and(|root| (root.x[0] - 10.05).abs() < 0.1));
    }

    #[test]
    fn what_rounding_hides_is_not_looked_for() {
        // x + 1e6 x = 1e-10, where x is evaluated as (1 + x) - 1: x is below a rounding of 1.
        let root = solve(0, [0.0; 2], [1.0; 2], |s: f64, [x, y]: [f64; 2]| Equations {
            residual: [x + s * (1e6 * ((1.0 + x) - 1.0) - 1e-10), y],
            excess: [[s * 1e6, 0.0], [0.0; 2]],
        });
        assert!(root.is_ok_and(|root| root.x[0].abs() < 4e-16 && root.evaluations < 10));
    }
}
