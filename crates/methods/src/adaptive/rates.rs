//! How fast a system can move.

use afterbay_core::{Block, Curvature, Scalar, Vector};

/// Sums over the rows of the second derivatives of H, and of ∂D/∂p.
#[derive(Clone, Debug)]
pub(crate) struct Rates<V: Vector> {
    by_q: V,
    by_p: V,
    friction: V,
}

impl<V: Vector> Rates<V> {
    pub(crate) fn new(n: usize) -> Self {
        Self { by_q: V::zeros(n), by_p: V::zeros(n), friction: V::zeros(n) }
    }

    /// Bounds of the frequencies there are at (q, p), `ω² ≤ |∂²H/∂q²| |∂²H/∂p²|`, and of the rates of friction, `|∂D/∂p|`, in the norm
    /// of the largest sum of a row.
    #[inline]
    pub(crate) fn see<S>(&mut self, system: &S, q: &V, p: &V) -> [f64; 2]
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let zero = V::Scalar::zero();
        let [by_q, by_p, friction] =
            [&mut self.by_q, &mut self.by_p, &mut self.friction].map(V::as_mut_slice);
        for sums in [&mut *by_q, by_p, friction] {
            sums.fill(zero);
        }
        system.curvature(q.as_slice(), p.as_slice(), |block, i, _, value| match block {
            Block::Hqq => by_q[i] += value.abs(),
            Block::Hpp => by_p[i] += value.abs(),
            Block::Dp => friction[i] += value.abs(),
            Block::Hqp | Block::Dq => {}
        });
        let largest = |x: &[V::Scalar]| x.iter().fold(0.0, |most: f64, x| most.max(x.to_f64()));
        [(largest(by_q) * largest(by_p)).sqrt(), largest(friction)]
    }
}
