//! The drift of K, the violations of passivity and the number of steps of a run, for studies.

use super::passivity::Passivity;
use crate::Model;
use afterbay_core::{InputError, StateRef, System, larger_or_nan};

/// The drift of K, the steps that violate passivity and the steps done, of a run so far.
pub(super) struct Watch<S> {
    system: S,
    total: f64,
    /// max |K - K0|
    pub(super) drift: f64,
    passivity: Passivity,
    /// Steps done.
    pub(super) steps: u64,
}

impl<S: std::ops::Deref<Target: System<f64>>> Watch<S> {
    /// Starts from a state of a model with this system.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub(super) fn new(
        system: S,
        model: &Model,
        start: StateRef<'_, f64>,
    ) -> Result<Self, InputError> {
        let (total, passivity) = (start.total(&*system), Passivity::new(model, start)?);
        Ok(Self { system, total, drift: 0.0, passivity, steps: 0 })
    }

    /// Records the state after a step, and returns K - K0.
    pub(super) fn see(&mut self, step: u64, state: StateRef<'_, f64>) -> f64 {
        let drift = state.total(&*self.system) - self.total;
        self.drift = larger_or_nan(self.drift, drift.abs());
        if step > self.steps {
            self.passivity.see(state);
        }
        self.steps = step;
        drift
    }

    /// The number of steps that violate passivity; none where the system is not passive.
    pub(super) fn violations(&self) -> Option<u64> {
        self.passivity.violations()
    }
}
