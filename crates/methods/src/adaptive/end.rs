//! The end of an attempted step, and K there.

use super::projection::Projection;
use crate::kernels::reductions::sum;
use afterbay_core::{Scalar, State, System, Vector};

/// The end of a step that began where H was a given number, `before`.
#[derive(Clone, Debug)]
pub(crate) struct End<V: Vector> {
    pub(crate) q: V,
    pub(crate) p: V,
    /// The increments of the reservoirs, Δw.
    pub(crate) gain: V,
    /// H at (q, p).
    pub(crate) energy: V::Scalar,
}

impl<V: Vector> End<V> {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || V::zeros(n);
        Self { q: zeros(), p: zeros(), gain: zeros(), energy: V::Scalar::zero() }
    }

    /// Computes H at (q, p).
    #[inline(always)]
    pub(crate) fn measure<S: System<V::Scalar> + ?Sized>(&mut self, system: &S) {
        self.energy = system.energy(self.q.as_slice(), self.p.as_slice());
    }

    /// The value of H with which K is exact, `before - Σ Δw_j`.
    #[inline(always)]
    pub(crate) fn target(&self, before: V::Scalar) -> V::Scalar {
        before - sum([self.gain.as_slice()], |[gain]| gain)
    }

    /// Projects (q, p) onto K along `[∂H/∂q, ∂H/∂p]`, scaled by the errors of q and p allowed in
    /// the run, of which this share is allowed for the step. Returns whether (q, p) moved, or the
    /// ratio of the change to the allowed one if it exceeds that.
    #[inline(always)]
    pub(crate) fn project<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        slope: [&V; 2],
        before: V::Scalar,
        [of_q, of_p, _]: [f64; 3],
        share: f64,
    ) -> Result<bool, f64> {
        let target = self.target(before);
        let projection = Projection {
            slope: slope.map(V::as_slice),
            target,
            size: (before.abs() + target.abs()).to_f64(),
            scales: [of_q, of_p],
            share,
        };
        let Self { q, p, energy, .. } = self;
        projection.apply(system, [q.as_mut_slice(), p.as_mut_slice()], energy)
    }

    /// Makes K exact by the momentum of the last motor, an account of energy with ∂H/∂p = 1.
    /// Returns whether there is one.
    ///
    /// A step across a jump of the drive is taken whatever its error is. It may be that no change
    /// of (q, p) of the size of the tolerance restores K. The account then has an error of this
    /// size in any case.
    #[cold]
    pub(crate) fn balance<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        before: V::Scalar,
    ) -> bool {
        if system.motors() == 0 {
            return false;
        }
        self.measure(system);
        let missing = self.target(before) - self.energy;
        if let Some(account) = self.p.as_mut_slice().last_mut() {
            *account += missing;
        }
        self.measure(system);
        true
    }

    /// Writes the end to `to`, which has the w of the start.
    #[inline(always)]
    pub(crate) fn write(&self, to: &mut State<V>) {
        to.q.as_mut_slice().copy_from_slice(self.q.as_slice());
        to.p.as_mut_slice().copy_from_slice(self.p.as_slice());
        for (w, &gain) in to.w.as_mut_slice().iter_mut().zip(self.gain.as_slice()) {
            *w += gain;
        }
    }
}
