//! Whether K is kept: the deviation of K beside the largest energy that took part.

use afterbay_core::{Scalar, StateRef, System};
use serde::{Deserialize, Serialize};

/// The largest deviation of K, relative to the largest energy of the run, that counts as rounding.
pub const LARGEST_DRIFT: f64 = 1e-11;

/// The largest energy of a run so far: |H| + Σ |w_j| + ½ Σ |p_j ∂H/∂p_j|. H and K alone may be 0
/// where their terms are not.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LargestEnergy(f64);

impl LargestEnergy {
    pub(crate) fn see<T: Scalar>(&mut self, system: &dyn System<T>, state: StateRef<'_, T>) {
        let [mut hq, mut hp] = [(); 2].map(|()| vec![T::zero(); state.q.len()]);
        system.gradient(state.q, state.p, &mut hq, &mut hp);
        let kinetic = state.p.iter().zip(&hp).map(|(&p, &v)| (p * v).half().abs());
        let terms = kinetic.chain(state.w.iter().map(|w| w.abs()));
        let energy = terms.fold(state.energy(system).abs(), |sum, term| sum + term).to_f64();
        if energy.is_finite() {
            self.0 = self.0.max(energy);
        }
    }

    /// A deviation of K as a share of this energy.
    pub(crate) fn share(self, deviation: f64) -> f64 {
        // At rest there is no energy and no deviation.
        if deviation == 0.0 { 0.0 } else { deviation / self.0 }
    }
}
