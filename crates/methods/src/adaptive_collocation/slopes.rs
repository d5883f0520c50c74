//! The end of a step.

use afterbay_core::{Curvature, Scalar, Vector};

/// The end of a step, and the derivatives of H and D there.
#[derive(Clone, Debug)]
pub(super) struct End<V: Vector> {
    pub(super) q: V,
    pub(super) p: V,
    /// The increments of the reservoirs.
    pub(super) gain: V,
    pub(super) v: V,
    pub(super) f: V,
    pub(super) hq: V,
    /// D_j v_j
    pub(super) loss: V,
    pub(super) energy: V::Scalar,
}

impl<V: Vector> End<V> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || V::zeros(n);
        let [q, p, gain, v, f, hq, loss] =
            [zeros(), zeros(), zeros(), zeros(), zeros(), zeros(), zeros()];
        Self { q, p, gain, v, f, hq, loss, energy: V::Scalar::zero() }
    }

    /// Evaluates the system at (q, p).
    #[inline]
    pub(super) fn evaluate_slopes<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S) {
        let Self { q, p, v, f, hq, loss, .. } = self;
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
