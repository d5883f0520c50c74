//! Steps that violate passivity.

use crate::Model;
use crate::solution::accounts;
use afterbay_core::{Accounts, InputError, Motors, Passive, StateRef};

/// Counts the steps that violate passivity, see [`Passive::violated`]. The work of a drive is in an
/// account of its own and does not count.
#[derive(Clone, Debug)]
pub(super) struct Passivity {
    passive: Passive,
    motors: Motors,
    before: Vec<f64>,
    violations: u64,
}

impl Passivity {
    /// Starts from a state of a model.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub(super) fn new(model: &Model, state: StateRef<'_, f64>) -> Result<Self, InputError> {
        let mut passivity = Self {
            passive: model.passive()?,
            motors: model.motors(),
            before: Vec::new(),
            violations: 0,
        };
        passivity.before = accounts(state, &passivity.motors).w;
        Ok(passivity)
    }

    /// Records the state after a step.
    pub(super) fn see(&mut self, state: StateRef<'_, f64>) {
        if self.motors.driven.is_empty() {
            let w = &state.w[..self.before.len()];
            self.violations += u64::from(self.passive.violated(&self.before, w));
            self.before.copy_from_slice(w);
            return;
        }
        let Accounts { w, s, .. } = accounts(state, &self.motors);
        // w_j is the difference of two accounts, and has the rounding of the larger. Both ends are
        // shifted by its size, which leaves their difference.
        let sizes: Vec<f64> = w
            .iter()
            .zip(&self.before)
            .zip(&s)
            .map(|((w, b), s)| w.abs() + b.abs() + s.abs())
            .collect();
        let shifted =
            |w: &[f64]| -> Vec<f64> { w.iter().zip(&sizes).map(|(w, size)| w + size).collect() };
        self.violations += u64::from(self.passive.violated(&shifted(&self.before), &shifted(&w)));
        self.before = w;
    }

    /// The number of steps that violate passivity; none where the system is not passive.
    pub(super) fn violations(&self) -> Option<u64> {
        (self.passive != Passive::No).then_some(self.violations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_and_not_degrees_of_freedom() {
        let count = |passive| {
            let (before, violations) = (vec![0.0; 2], 0);
            let mut passivity =
                Passivity { passive, motors: Motors::default(), before, violations };
            // Both rise; one falls and the sum rises; both fall; one falls and the sum with it.
            [[1.0, 1.0], [0.5, 2.0], [0.25, 1.0], [2.0, -2.0]]
                .iter()
                .for_each(|w| passivity.see(StateRef { q: &[], p: &[], w, t: 0.0 }));
            passivity.violations()
        };
        assert_eq!(count(Passive::Each), Some(3));
        assert_eq!(count(Passive::InSum), Some(2));
        assert_eq!(count(Passive::No), None);
    }

    #[test]
    fn the_work_of_a_drive_is_no_violation_and_hides_none() {
        let count = |steps: [[f64; 3]; 3]| {
            let motors = Motors { driven: vec![0], ..Motors::default() };
            let (passive, before) = (Passive::Each, vec![0.0]);
            let mut passivity = Passivity { passive, motors, before, violations: 0 };
            // w_1 - s_1, and s_1 as momentum and account of the motor.
            for [w, s, q] in steps {
                let state = StateRef { q: &[0.0, q], p: &[0.0, s], w: &[w - s, -s], t: q };
                passivity.see(state);
            }
            passivity.violations()
        };
        assert_eq!(count([[0.5, 3.0, 0.1], [0.7, -4.0, 0.2], [0.7, 9.0, 0.3]]), Some(0));
        assert_eq!(count([[-0.5, 3.0, 0.1], [-0.7, -4.0, 0.2], [-0.6, 9.0, 0.3]]), Some(2));
    }
}
