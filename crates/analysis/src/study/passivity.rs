//! Energy taken back from a reservoir that only fills.

use afterbay_core::Passive;

/// Counts where Δw < 0 although Δw ≥ 0 is owed: in each degree of freedom, or in the sum over them.
#[derive(Clone, Debug)]
pub(super) struct Passivity {
    owed: Passive,
    before: Vec<f64>,
    violations: u64,
}

impl Passivity {
    /// From the reservoir at the start.
    pub(super) fn new(owed: Passive, w: &[f64]) -> Self {
        Self { owed, before: w.to_vec(), violations: 0 }
    }

    /// Takes in the reservoir after a step.
    pub(super) fn see(&mut self, w: &[f64]) {
        let changes = || w.iter().zip(&self.before).map(|(now, before)| now - before);
        self.violations += match self.owed {
            Passive::No => 0,
            Passive::Each => changes().filter(|&change| change < 0.0).count() as u64,
            Passive::InSum => {
                // Each entry is rounded by itself: a sum within these roundings is none.
                let rounding = w.iter().map(|w| w.abs() * f64::EPSILON).sum::<f64>();
                u64::from(changes().sum::<f64>() < -rounding)
            }
        };
        self.before.copy_from_slice(w);
    }

    /// How often it happened; none where nothing is owed.
    pub(super) fn violations(&self) -> Option<u64> {
        (self.owed != Passive::No).then_some(self.violations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(owed: Passive, states: &[[f64; 2]]) -> Option<u64> {
        let mut passivity = Passivity::new(owed, &states[0]);
        states[1..].iter().for_each(|w| passivity.see(w));
        passivity.violations()
    }

    #[test]
    fn what_is_owed_decides_what_is_counted() {
        // Both rise; one falls and the sum rises; both fall; one falls and the sum with it.
        let states = [[0.0, 0.0], [1.0, 1.0], [0.5, 2.0], [0.25, 1.0], [2.0, -2.0]];
        assert_eq!(count(Passive::Each, &states), Some(4));
        assert_eq!(count(Passive::InSum, &states), Some(2));
        assert_eq!(count(Passive::No, &states), None);
    }

    #[test]
    fn a_rounding_of_the_sum_is_no_violation() {
        let states = [[1.0, 3.0], [1.0 + 4.0 * f64::EPSILON, 3.0 - 6.0 * f64::EPSILON]];
        assert_eq!(count(Passive::InSum, &states), Some(0));
        assert_eq!(count(Passive::Each, &states), Some(1));
    }
}
