//! The dissipative force D: what is known of it beforehand, its values, and what passivity asks of a step.

use crate::numbers::{Mask, Scalar};

/// What is known of the dissipative force D for all (q, p).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DissipationForm {
    /// D = 0: there is no reservoir to keep.
    pub zero: bool,
    /// Where the reservoir only fills, whatever the state.
    pub passive: Passive,
    /// D is linear in p. Where it is not coupled, D_j = γ_j(q) p_j, and `by_p` of [`crate::Separable::dissipation_of`] is γ_j.
    pub linear: bool,
    /// D_j may depend on the momenta of others, as in D = C p.
    pub coupled: bool,
}

/// Where Δw ≥ 0 is owed: it is where D = R(q, p) ∂H/∂p with R positive semidefinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passive {
    /// Nowhere: the system is active, or nothing is known.
    No,
    /// In the sum over the degrees of freedom, Σ D_j ∂H/∂p_j ≥ 0.
    InSum,
    /// In each of them, D_j ∂H/∂p_j ≥ 0: R is diagonal.
    Each,
}

impl Passive {
    /// In each degree of freedom if it is `true`, else nowhere.
    pub fn each_if(passive: bool) -> Self {
        if passive { Self::Each } else { Self::No }
    }

    /// Does a step that takes the reservoir from `before` to `after` violate passivity? This is the
    /// one definition of a violation: Σ_j Δw_j < 0 where R is positive semidefinite, and any
    /// Δw_j < 0 where R is diagonal as well.
    ///
    /// A step adds to w_j a few times, and each sum is rounded. So Δw_j counts as negative where it
    /// is below -4 u (|w_j before| + |w_j after|), with u the unit roundoff, and the sum over j
    /// where it is below the sum of these.
    #[inline]
    pub fn violated<T: Scalar>(self, before: &[T], after: &[T]) -> T::Mask {
        let rounding = T::from_f64(4.0 * T::EPSILON);
        let never = T::one().lt(T::zero());
        let (mut sum, mut noise, mut fallen) = (T::zero(), T::zero(), never);
        for (&before, &after) in before.iter().zip(after) {
            let (change, bound) = (after - before, rounding * (after.abs() + before.abs()));
            fallen = fallen.or(change.lt(-bound));
            sum += change;
            noise += bound;
        }
        match self {
            Self::No => never,
            Self::InSum => sum.lt(-noise),
            Self::Each => fallen.or(sum.lt(-noise)),
        }
    }
}

impl DissipationForm {
    /// Nothing is known.
    pub const GENERAL: Self = Self { zero: false, passive: Passive::No, linear: false, coupled: false };
    /// D_j = γ_j(q) p_j, active.
    pub const LINEAR: Self = Self { linear: true, ..Self::GENERAL };
    /// D = 0.
    pub const NONE: Self = Self { zero: true, passive: Passive::Each, linear: true, coupled: false };
}

/// The dissipative force on one degree of freedom, and how it changes with that degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dissipation<T> {
    /// D_j
    pub value: T,
    /// ∂D_j/∂q_j
    pub by_q: T,
    /// ∂D_j/∂p_j
    pub by_p: T,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violated(passive: Passive, before: [f64; 2], after: [f64; 2]) -> bool {
        passive.violated(&before, &after)
    }

    #[test]
    fn a_violation_is_a_fall_of_the_sum_or_of_one_entry_where_each_only_fills() {
        // Both rise; one falls and the sum rises; one falls and the sum with it; both fall.
        let steps = [[1.0, 1.0], [-0.5, 1.0], [0.5, -1.0], [-0.1, -0.1]];
        let by = |passive| steps.map(|[a, b]| violated(passive, [2.0, 3.0], [2.0 + a, 3.0 + b]));
        assert_eq!(by(Passive::Each), [false, true, true, true]);
        assert_eq!(by(Passive::InSum), [false, false, true, true]);
        assert_eq!(by(Passive::No), [false; 4]);
    }

    #[test]
    fn a_rounding_of_w_is_no_violation() {
        let u = f64::EPSILON / 2.0;
        for passive in [Passive::Each, Passive::InSum] {
            assert!(!violated(passive, [1.0, 3.0], [1.0 - 4.0 * u, 3.0 - 8.0 * u]));
            assert!(violated(passive, [1.0, 3.0], [1.0 - 40.0 * u, 3.0]));
            // From an empty reservoir nothing can be rounded away.
            assert!(violated(passive, [0.0, 0.0], [-1e-300, 0.0]));
        }
    }
}
