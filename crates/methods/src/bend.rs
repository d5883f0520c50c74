//! The effect of rounding of z on the forces.

use afterbay_core::{Curvature, Scalar};

/// The largest absolute entry of H'' and ∂D at (q, p). A rounding of z changes the forces by ε
/// |H''| |z|.
pub(crate) fn bend<T: Scalar, S: Curvature<T> + ?Sized>(system: &S, q: &[T], p: &[T]) -> f64 {
    let mut most = 0.0_f64;
    system.curvature(q, p, |_, _, _, entry| most = most.max(entry.to_f64().abs()));
    most
}
