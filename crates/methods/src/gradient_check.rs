//! A check that the gradient of a system is that of its energy, where K is lost along (q, p) and no
//! rounding that is known explains it.

use crate::ray::{Memory, Ray};
use afterbay_core::{Scalar, StepFailure, System};

/// The error of ∇H·z, as a share of its terms, from which on ∇H may not be the gradient of H. A
/// choice: mistakes are larger. Roundings of ∇H of this size differ from node to node, so that the
/// integral is not resolved.
const LARGEST_SLOPE_ERROR: f64 = 1e-8;
/// The relative change of the slope error over an interval of 2^-4 z. A choice: it is about 2^-4.
const UNEVEN: f64 = 0.25;
/// The number of times that z is doubled at most. A choice: from the least number whose square is
/// normal, 1e-154, to beyond 1.
const DOUBLINGS: i32 = 520;
/// The number of doublings that tell. A choice: features of H that end it near z are rare.
const FEWEST_DOUBLINGS: i32 = 5;
/// The ratio of a difference to its share of that over a longer interval from which on it is
/// irregular. A choice: that of a smooth H is near 1.
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
    if T::IS_EXTENDED {
        return Ok(());
    }
    check_slope(&mut Ray { system, z: [q, p], scale: 1.0, memory: &mut Memory::new(q.len()) })
}

/// Checks that ∇H·z is the slope of H. An error is a large part of it, proportional to the
/// interval, and no rounding.
///
/// # Errors
/// [`StepFailure::NotGradient`]
pub(crate) fn check_slope<T: Scalar, S: System<T> + ?Sized>(
    ray: &mut Ray<'_, T, S>,
) -> Result<(), StepFailure> {
    let [long, middle, short] = [4, 8, 12].map(|power| ray.difference([0.0, 2.0_f64.powi(-power)]));
    let large = long.size > LARGEST_SLOPE_ERROR * 2.0_f64.powi(-4) * long.slopes;
    let shares = [16.0 * middle.size, 256.0 * short.size].map(|size| size / long.size);
    let proportional = shares.iter().all(|share| (share - 1.0).abs() < UNEVEN);
    if !(long.resolved && large && proportional) || becomes_noise(ray) {
        return Ok(());
    }
    let [rise, integral] = long.changes;
    Err(StepFailure::NotGradient { integral, rise })
}

/// Whether the difference becomes irregular as z is doubled again and again, while it is still a
/// large part of the slope, as that of terms which cancel does: where 1 - cos q is 0 for a small
/// q, its rounding is all of q²/2, and for a larger q it is that of 1. That of a wrong gradient
/// stays proportional to the interval. True where H ends too soon to tell.
fn becomes_noise<T: Scalar, S: System<T> + ?Sized>(ray: &mut Ray<'_, T, S>) -> bool {
    let begin = ray.scale;
    let verdict = (0..DOUBLINGS).find_map(|doubling| {
        ray.scale = begin * 2.0_f64.powi(doubling);
        let [long, short] = [4, 12].map(|power| ray.difference([0.0, 2.0_f64.powi(-power)]));
        if !(long.size.is_finite() && short.size.is_finite()) {
            return Some(doubling < FEWEST_DOUBLINGS);
        }
        let irregular = 256.0 * short.size > IRREGULAR * long.size;
        let large = short.size > LARGEST_SLOPE_ERROR * 2.0_f64.powi(-12) * short.slopes;
        irregular.then_some(large)
    });
    ray.scale = begin;
    verdict.unwrap_or(false)
}
