//! The rounding error of K.

use afterbay_core::Scalar;

/// The error of K, in roundings of its terms, that is not corrected. A choice.
pub(crate) const SMALL_ROUNDINGS: f64 = 2.0;
/// A step solved to rounding restores K if it is off by more than this number of roundings of its
/// terms at the ends.
pub(crate) const RESTORED_ROUNDINGS: f64 = 16.0;
/// The error of K, in roundings of its terms, that is accepted where no small change of z reduces
/// it. A choice.
pub(crate) const KEPT_ROUNDINGS: f64 = 256.0;

/// The rounding error of a sum, given the sum of its absolute terms. Terms that overflow count as
/// the largest finite number, because every error would be below an infinite bound. Squares that
/// underflow lose up to the least normal number, however small the terms are.
#[inline(always)]
pub(crate) fn rounding<T: Scalar>(terms: f64) -> f64 {
    T::EPSILON.mul_add(if terms > f64::MAX { f64::MAX } else { terms }, f64::MIN_POSITIVE)
}

/// An error of a sum in roundings of its terms; 0 for no error, whatever the terms.
#[inline(always)]
pub(crate) fn roundings<T: Scalar>(error: f64, terms: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / rounding::<T>(terms) }
}

/// [`rounding`] in each lane.
#[inline(always)]
pub(crate) fn rounding_of_each<T: Scalar>(terms: T) -> T {
    let largest = T::from_f64(f64::MAX);
    let terms = T::select(largest.lt(terms), largest, terms);
    T::from_f64(T::EPSILON).mul_add(terms, T::from_f64(f64::MIN_POSITIVE))
}
