//! Steps that violate passivity.

use afterbay_core::Passive;

/// Counts the steps that violate passivity, see [`Passive::violated`].
#[derive(Clone, Debug)]
pub(super) struct Passivity {
    owed: Passive,
    before: Vec<f64>,
    violations: u64,
}

impl Passivity {
    /// Starts from the reservoir w.
    pub(super) fn new(owed: Passive, w: &[f64]) -> Self {
        Self { owed, before: w.to_vec(), violations: 0 }
    }

    /// Records the reservoir after a step.
    pub(super) fn see(&mut self, w: &[f64]) {
        self.violations += u64::from(self.owed.violated(&self.before, w));
        self.before.copy_from_slice(w);
    }

    /// The number of steps that violate passivity; none where the system is not passive.
    pub(super) fn violations(&self) -> Option<u64> {
        (self.owed != Passive::No).then_some(self.violations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_and_not_degrees_of_freedom() {
        let count = |owed| {
            let mut passivity = Passivity::new(owed, &[0.0, 0.0]);
            // Both rise; one falls and the sum rises; both fall; one falls and the sum with it.
            [[1.0, 1.0], [0.5, 2.0], [0.25, 1.0], [2.0, -2.0]]
                .iter()
                .for_each(|w| passivity.see(w));
            passivity.violations()
        };
        assert_eq!(count(Passive::Each), Some(3));
        assert_eq!(count(Passive::InSum), Some(2));
        assert_eq!(count(Passive::No), None);
    }
}
