//! The slopes at the start or at the end of a step.

use afterbay_core::{Curvature, Vector};

/// ∂H/∂p, ∂H/∂q + D, ∂H/∂q and D_j ∂H/∂p_j at a point.
#[derive(Clone, Debug)]
pub(super) struct Slopes<V: Vector> {
    pub(super) v: V,
    pub(super) f: V,
    pub(super) hq: V,
    pub(super) loss: V,
}

impl<V: Vector> Slopes<V> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || V::zeros(n);
        Self { v: zeros(), f: zeros(), hq: zeros(), loss: zeros() }
    }

    /// Evaluates the system at (q, p).
    #[inline]
    pub(super) fn evaluate<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        [q, p]: [&V; 2],
    ) {
        let Self { v, f, hq, loss } = self;
        let (q, p) = (q.as_slice(), p.as_slice());
        system.gradient(q, p, hq.as_mut_slice(), v.as_mut_slice());
        system.dissipation(q, p, v.as_slice(), loss.as_mut_slice());
        let n = V::LEN.unwrap_or(q.len());
        let (f, hq, v, loss) = (f.as_mut_slice(), hq.as_slice(), v.as_slice(), loss.as_mut_slice());
        for j in 0..n {
            f[j] = hq[j] + loss[j];
            loss[j] *= v[j];
        }
    }
}
