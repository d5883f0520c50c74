//! The energies of a run over all its states, whether or not they are kept.

use afterbay_core::{StateRef, System, larger_or_nan};
use serde::{Deserialize, Serialize};

/// The rise of H, as a share of its size, up to which it counts as rounding.
const ROUNDING: f64 = 1e-8;

/// The deviation of K and the rise of H over the states seen: after each step, and between the
/// steps where a state is kept there.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Balance {
    /// K of the first state.
    start: Option<f64>,
    /// The largest deviation of K from that of the first state.
    pub drift: f64,
    /// The least H so far.
    least: Option<f64>,
    /// The largest rise of H between two states, the first before the second. A state whose H is
    /// NaN is left out; the drift is NaN then.
    rise: f64,
    /// The size of H.
    size: f64,
}

impl Balance {
    /// One state more, of a system with motors behind n degrees of freedom.
    pub(in crate::study) fn see(
        &mut self,
        system: &dyn System<f64>,
        state: StateRef<'_, f64>,
        n: usize,
    ) {
        let with_motors = state.energy(system);
        let (energy, total) =
            (with_motors - state.p[n..].iter().sum::<f64>(), with_motors + state.reservoir());
        let start = *self.start.get_or_insert(total);
        self.drift = larger_or_nan(self.drift, (total - start).abs());
        let least = self.least.map_or(energy, |least| least.min(energy));
        self.least = Some(least);
        self.rise = self.rise.max(energy - least);
        self.size = self.size.max(energy.abs().min(total.abs()));
    }

    /// The largest rise of H, and none if it is a rounding of its size.
    pub fn rise(&self) -> Option<f64> {
        (self.rise > ROUNDING * self.size).then_some(self.rise)
    }
}
