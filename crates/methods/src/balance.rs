//! A check that K is conserved, for means along edges computed by quadrature, which does not
//! resolve features of H between its nodes.

use crate::gradient_check::check_partials;
use crate::rounding::rounding_of_each;
use afterbay_core::{Mask, Scalar, Separable, StepFailure};

/// The change of K, in roundings of its terms, that a step may make. It allows for the error of the
/// equations of the step and for cancellation between the terms of H, of which only the sum is
/// known.
const LARGEST_CHANGE_ROUNDINGS: f64 = 1e4;

/// The terms of K before or after a step.
#[derive(Clone, Copy)]
pub(crate) struct Account<T> {
    /// H
    pub(crate) energy: T,
    /// The sum of the absolute terms of H, as far as they are known.
    pub(crate) size: T,
}

/// Checks K over a step from (q, p, w) `before` to `after`. `account` gives the terms of H at
/// (q, p), and `second_order` is that of [`check`].
///
/// # Errors
/// Those of [`check`].
#[inline]
pub(crate) fn check_step<T: Scalar>(
    before: [&[T]; 3],
    after: [&[T]; 3],
    account: impl Fn(&[T], &[T]) -> Account<T>,
    second_order: impl FnOnce() -> Result<T, StepFailure>,
) -> Result<(), StepFailure> {
    let ([q0, p0, w0], [q1, p1, w1]) = (before, after);
    let (mut gained, mut held) = (T::zero(), T::zero());
    for (&before, &after) in w0.iter().zip(w1) {
        gained += after - before;
        held += before.abs() + after.abs();
    }
    let (start, end) = (account(q0, p0), account(q1, p1));
    check(Account { size: start.size + held, ..start }, end, gained, second_order)
}

/// The change of H = T + V by the rounding of q at both ends of a step from (q0, p0), times 1/ε.
///
/// # Errors
/// [`StepFailure::NotGradient`]
pub(crate) fn second_order_of_potential<T: Scalar, S: Separable<T> + ?Sized>(
    system: &S,
    [q0, q1]: [&[T]; 2],
    p0: &[T],
) -> Result<T, StepFailure> {
    let at = |q: &[T]| {
        let terms = (0..q.len()).map(|j| (q[j] * system.partial(q, j, q[j])).abs());
        terms.fold(T::zero(), |sum, term| sum + term) + rounding_of_potential(system, q)
    };
    check_partials(system, q0, p0)?;
    Ok(at(q0) + at(q1))
}

/// Measures the rounding error of V at q, times 1/ε: the largest difference between the change of V
/// along short edges and the mean of ∂V/∂q times their length. Cancellation between terms inside V
/// cannot be detected otherwise.
///
/// The edges are 2^-18 to 2^-24 of each coordinate, short enough to be resolved and long enough for
/// their rounding errors to differ.
#[cold]
fn rounding_of_potential<T: Scalar, S: Separable<T> + ?Sized>(system: &S, q: &[T]) -> T {
    let at_rest = vec![T::zero(); q.len()];
    let (here, mut moved) = (system.energy(q, &at_rest), q.to_vec());
    let mut most = T::zero();
    for power in [18, 20, 22, 24] {
        let share = T::from_f64(1.0 - 2.0_f64.powi(-power));
        moved.copy_from_slice(q);
        let mut rise = T::zero();
        for j in 0..q.len() {
            let (from, to) = (moved[j], q[j] * share);
            rise += system.divided_difference(&moved, j, to).value * (to - from);
            moved[j] = to;
        }
        let defect = (system.energy(&moved, &at_rest) - here - rise).abs();
        most = T::select(most.lt(defect), defect, most);
    }
    most / T::from_f64(T::EPSILON)
}

/// Checks that the change of H and the reservoirs' gain `gained` cancel. `second_order` gives the
/// change of H due to the rounding of the state, times 1/ε; it is evaluated only if the other terms
/// do not explain the difference.
///
/// # Errors
/// [`StepFailure::BalanceLost`], and those of `second_order`.
#[inline]
pub(crate) fn check<T: Scalar>(
    before: Account<T>,
    after: Account<T>,
    gained: T,
    second_order: impl FnOnce() -> Result<T, StepFailure>,
) -> Result<(), StepFailure> {
    let defect = (after.energy - before.energy + gained).abs();
    let size = before.size + after.size + gained.abs();
    let most = T::from_f64(LARGEST_CHANGE_ROUNDINGS);
    let within = |size: T| defect.le(most * rounding_of_each(size)).all();
    if within(size) {
        return Ok(());
    }
    let size = size + second_order()?;
    if within(size) {
        return Ok(());
    }
    Err(StepFailure::BalanceLost { roundings: (defect / rounding_of_each(size)).to_f64() })
}
