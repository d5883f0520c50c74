//! Whether K is kept: the deviation of K beside the largest energy that took part.

use afterbay_core::{Scalar, StateRef, System};
use serde::{Deserialize, Serialize};

/// The largest deviation of K that counts as kept, relative to the largest energy.
pub const KEPT: f64 = 1e-12;

/// The largest energy E of a run so far: the largest |H| + Σ |w_j| and T = ½ Σ |p_j ∂H/∂p_j|. E is
/// K0 where H ≥ 0 falls from K0 and no w_j does. T counts because H and w may be 0 where their
/// terms are not, as in a fall from rest.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LargestEnergy(f64);

impl LargestEnergy {
    pub(crate) fn see<T: Scalar>(&mut self, system: &dyn System<T>, state: StateRef<'_, T>) {
        let [mut hq, mut hp] = [(); 2].map(|()| vec![T::zero(); state.q.len()]);
        system.gradient(state.q, state.p, &mut hq, &mut hp);
        let products = state.p.iter().zip(&hp).map(|(&p, &v)| (p * v).abs());
        let kinetic = products.fold(T::zero(), |sum, product| sum + product).half();
        let energy = state.energy(system).abs();
        let held = state.w.iter().fold(energy, |sum, w| sum + w.abs());
        for energy in [kinetic.to_f64(), held.to_f64()] {
            if energy.is_finite() {
                self.0 = self.0.max(energy);
            }
        }
    }

    /// A deviation of K as a share of this energy.
    pub(crate) fn share(self, deviation: f64) -> f64 {
        // At rest there is no energy and no deviation.
        if deviation == 0.0 { 0.0 } else { deviation / self.0 }
    }
}
