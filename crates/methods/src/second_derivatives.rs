//! Sizes of the second derivatives of H: they tell how a rounding of z changes the forces and H.

use afterbay_core::{Block, Curvature, Scalar};

/// The largest absolute entry of H'' and ∂D at (q, p). A rounding of z changes the forces by ε
/// |H''| |z|.
pub(crate) fn largest_second_derivative<T: Scalar, S: Curvature<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> f64 {
    let mut most = 0.0_f64;
    system.curvature(q, p, |_, _, _, entry| most = most.max(entry.to_f64().abs()));
    most
}

/// The largest |z_i ∂²H/∂z_i∂z_j z_j| at (q, p): an estimate of the terms that cancel inside H near
/// an equilibrium away from the origin. 0 where it overflows, since every error of K would be below
/// an infinite bound.
pub(crate) fn second_order<T: Scalar, S: Curvature<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> f64 {
    let mut most = 0.0_f64;
    system.curvature(q, p, |block, i, j, entry| {
        let [a, b] = match block {
            Block::Hqq => [q[i], q[j]],
            Block::Hqp => [q[i], p[j]],
            Block::Hpp => [p[i], p[j]],
            Block::Dq | Block::Dp => return,
        };
        most = most.max((a * entry * b).to_f64().abs());
    });
    if most.is_finite() { most } else { 0.0 }
}
