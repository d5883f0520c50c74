//! What roundings of z become where H bends.

use afterbay_core::{Curvature, Scalar};

/// The largest second derivative at (q, p), |H''| or |∂D|: forces are off by ε |H''| |z| where z is
/// rounded.
pub(crate) fn bend<T: Scalar, S: Curvature<T> + ?Sized>(system: &S, q: &[T], p: &[T]) -> f64 {
    let mut most = 0.0_f64;
    system.curvature(q, p, |_, _, _, entry| most = most.max(entry.to_f64().abs()));
    most
}
