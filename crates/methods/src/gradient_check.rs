//! A check that the gradient of a system is the derivative of its energy. It is made where a step
//! changes K along (q, p) by more than the known rounding errors.

use crate::ray::{Difference, Memory, Ray};
use afterbay_core::{Scalar, Separable, StepFailure, System};

/// ∇H may not be the gradient of H if the error of ∇H·z exceeds this share of its terms. A choice:
/// mistakes are larger. Roundings of ∇H of this size differ from node to node, so that the integral
/// is not resolved.
const LARGEST_SLOPE_ERROR: f64 = 1e-8;
/// The relative change of the slope error over the longest interval of a check. A choice: it is
/// about 2^-4 over 2^-4 z.
const UNEVEN: f64 = 0.25;
/// Each check begins with an interval of 2^-k z, for these k in turn. A choice: the shortest
/// interval resolves cos q up to |q| of a few hundred.
const LONGEST: [i32; 4] = [4, 6, 8, 10];
/// An error of H up to this number of roundings of |H| and of the terms of ∇H·z is not attributed
/// to cancellation. The number is below the bounds up to which an error of K is accepted, the
/// least of which is 8, so that no step falls between the two. A choice.
pub(crate) const EXPLAINED_ROUNDINGS: f64 = 4.0;
/// Roundings of q whose effect on ∇V bounds the rounding of ∇V. A choice.
const SLOPE_ROUNDINGS: f64 = 64.0;
/// The number of times that z is doubled at most. A choice: from the least number whose square is
/// normal, 1e-154, to beyond 1.
const DOUBLINGS: i32 = 520;
/// If H stops being finite within fewer doublings than these, the difference counts as rounding. A
/// choice: H is rarely singular that close to z.
const FEWEST_DOUBLINGS: i32 = 5;
/// A difference is irregular if it exceeds its share of the difference over a longer interval by
/// this factor. A choice: for a smooth H the factor is near 1.
const IRREGULAR: f64 = 16.0;

/// Checks that ∇H·(q, p) is the slope of H.
///
/// # Errors
/// [`StepFailure::NotGradient`]
#[cold]
pub(crate) fn check_gradient<T: Scalar, S: System<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> Result<(), StepFailure> {
    check_slope(&mut Ray { system, z: [q, p], scale: 1.0, memory: &mut Memory::new(q.len()) })
}

/// Checks by [`check_gradient`], and that the ∂V/∂q_j of a separable system are those of its
/// gradient. A difference that is no larger than the change of ∇V by a few roundings of q is one of
/// rounding.
///
/// # Errors
/// [`StepFailure::NotGradient`] and [`StepFailure::NotPartial`]
#[cold]
pub(crate) fn check_partials<T: Scalar, S: Separable<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> Result<(), StepFailure> {
    check_gradient(system, q, p)?;
    let [mut slopes, mut beside, mut hp] = [(); 3].map(|()| vec![T::zero(); q.len()]);
    system.gradient(q, p, &mut slopes, &mut hp);
    let rounded = T::from_f64(1.0 + SLOPE_ROUNDINGS * T::EPSILON);
    let near: Vec<T> = q.iter().map(|&q| q * rounded).collect();
    system.gradient(&near, p, &mut beside, &mut hp);
    let changes = slopes.iter().zip(&beside).map(|(&a, &b)| (b - a).abs().to_f64());
    let rounding = changes.fold(0.0, f64::max);
    for (dof, slope) in slopes.into_iter().enumerate() {
        let partial = system.partial(q, dof, q[dof]);
        let (off, size) = ((partial - slope).abs().to_f64(), partial.abs() + slope.abs());
        if off > rounding && off > LARGEST_SLOPE_ERROR * size.to_f64() {
            let (partial, slope) = (partial.to_f64(), slope.to_f64());
            return Err(StepFailure::NotPartial { dof, partial, slope });
        }
    }
    Ok(())
}

/// Checks that ∇H·z is the slope of H. An error of ∇H shows as a difference that is a large part of
/// the slope, proportional to the interval, and no rounding. The interval must be shorter than the
/// waves of H.
///
/// # Errors
/// [`StepFailure::NotGradient`]
pub(crate) fn check_slope<T: Scalar, S: System<T> + ?Sized>(
    ray: &mut Ray<'_, T, S>,
) -> Result<(), StepFailure> {
    for power in LONGEST {
        let [long, middle, short] = differences(ray, power);
        let large =
            is_large(&long, power) && long.size > EXPLAINED_ROUNDINGS * T::EPSILON * long.terms;
        if long.resolved && !large {
            return Ok(());
        }
        let proportional = is_share(&middle, &long, 16.0) && is_share(&short, &long, 256.0);
        if long.resolved && proportional {
            if becomes_noise(ray) {
                return Ok(());
            }
            let [rise, integral] = long.changes;
            return Err(StepFailure::NotGradient { integral, rise });
        }
    }
    Ok(())
}

/// The differences over intervals of 2^-power, 2^-(power + 4) and 2^-(power + 8) z.
fn differences<T: Scalar, S: System<T> + ?Sized>(
    ray: &mut Ray<'_, T, S>,
    power: i32,
) -> [Difference; 3] {
    [0, 4, 8].map(|more| ray.difference([0.0, 2.0_f64.powi(-power - more)]))
}

/// Whether a difference over 2^-power z is a large part of the slope.
fn is_large(difference: &Difference, power: i32) -> bool {
    difference.size > LARGEST_SLOPE_ERROR * 2.0_f64.powi(-power) * difference.slopes
}

/// Whether a difference is in proportion to the one over an interval `ratio` times as long.
fn is_share(short: &Difference, long: &Difference, ratio: f64) -> bool {
    (ratio * short.size / long.size - 1.0).abs() < UNEVEN
}

/// Whether the difference stops being proportional to the interval as z is doubled repeatedly,
/// while it is still a large part of the slope.
///
/// Rounding by cancellation does this. In 1 - cos q it is all of q²/2 while q is so small that the
/// computed value is 0, and it is a rounding of 1 for a larger q. The error of a wrong gradient
/// stays proportional. The result is also true if H stops being finite within
/// [`FEWEST_DOUBLINGS`].
///
/// An interval that holds several waves of H, as of cos q for a large q, does not count, since its
/// integral is not resolved. A difference over few waves may be small by chance. The differences
/// over the two shorter intervals are then still proportional, while those of noise are not.
fn becomes_noise<T: Scalar, S: System<T> + ?Sized>(ray: &mut Ray<'_, T, S>) -> bool {
    let begin = ray.scale;
    let verdict = (0..DOUBLINGS).find_map(|doubling| {
        ray.scale = begin * 2.0_f64.powi(doubling);
        let all = differences(ray, 4);
        let [long, middle, short] = &all;
        if !(long.size.is_finite() && short.size.is_finite()) {
            return Some(doubling < FEWEST_DOUBLINGS);
        }
        let irregular = all.iter().all(|difference| difference.resolved)
            && 256.0 * short.size > IRREGULAR * long.size
            && !is_share(short, middle, 16.0);
        irregular.then(|| is_large(short, 12))
    });
    ray.scale = begin;
    verdict.unwrap_or(false)
}
