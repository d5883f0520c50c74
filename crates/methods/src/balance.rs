//! Does K stay where it was? Asked where the means along edges come from quadrature, which does not
//! see what H does between its nodes.

use afterbay_core::{Mask, Scalar, Separable, StepFailure};

/// K may move by so many roundings of what it is made of: those of the equations of a step, and of
/// the terms of H, of which no more is known than their sum.
const ROUNDINGS: f64 = 1e4;

/// What K has been made of before a step, or is after it.
#[derive(Clone, Copy)]
pub(crate) struct Account<T> {
    /// H
    pub(crate) energy: T,
    /// The sum of the sizes of what H is made of, as far as they are known.
    pub(crate) size: T,
}

/// The rounding of V at q, measured: the largest difference between its change along short edges
/// and the means along them, times 1/ε. Terms that cancel inside V are not seen in any other way.
///
/// The edges are 2^-18 to 2^-24 of each coordinate, short enough to be resolved and long enough for
/// roundings to differ.
#[cold]
pub(crate) fn grain<T: Scalar, S: Separable<T> + ?Sized>(system: &S, q: &[T]) -> T {
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
        let off = (system.energy(&moved, &at_rest) - here - rise).abs();
        most = T::select(most.lt(off), off, most);
    }
    most / T::from_f64(T::EPSILON)
}

/// Looks whether H and the reservoirs, which gain `gained`, add up. `bends` gives what H changes by
/// where the state is rounded, times 1/ε; it is asked where the rest is not enough.
#[inline]
pub(crate) fn check<T: Scalar>(
    before: Account<T>,
    after: Account<T>,
    gained: T,
    bends: impl FnOnce() -> T,
) -> Result<(), StepFailure> {
    let off = (after.energy - before.energy + gained).abs();
    let size = before.size + after.size + gained.abs();
    let unit = T::from_f64(T::EPSILON);
    let within = |size: T| off.le(T::from_f64(ROUNDINGS) * unit * size).all();
    if within(size) {
        return Ok(());
    }
    let size = size + bends();
    if within(size) {
        return Ok(());
    }
    Err(StepFailure::BalanceLost { roundings: (off / (unit * size)).to_f64() })
}
