//! The dissipative force D: its form, its values, and the passivity of a step.

use crate::numbers::{Mask, Scalar};

/// Properties of the dissipative force D that hold at every (q, p).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DissipationForm {
    /// D = 0. Methods leave the reservoir untouched.
    pub zero: bool,
    /// Whether the reservoir can only gain energy.
    pub passive: Passive,
    /// D is linear in p. If it is not coupled, D_j = γ_j(q) p_j, and `by_p` of
    /// [`crate::Separable::dissipation_of`] is γ_j.
    pub linear: bool,
    /// D_j may depend on momenta other than p_j, as in D = C p.
    pub coupled: bool,
}

/// The sign of the dissipated power. A system is passive if D = R(q, p) ∂H/∂p with R positive
/// semidefinite: every step should then satisfy Σ Δw_j ≥ 0, and each Δw_j ≥ 0 if R is diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passive {
    /// The system is active, or nothing is known.
    No,
    /// Σ_j D_j ∂H/∂p_j ≥ 0.
    InSum,
    /// D_j ∂H/∂p_j ≥ 0 for each j: R is diagonal.
    Each,
}

impl Passive {
    /// [`Passive::Each`] if `passive`, else [`Passive::No`].
    pub fn each_if(passive: bool) -> Self {
        if passive { Self::Each } else { Self::No }
    }

    /// Whether a step that changes the reservoir from `before` to `after` violates passivity. This
    /// is the only definition of a violation: Σ_j Δw_j < 0 if R is positive semidefinite, and any
    /// Δw_j < 0 if R is diagonal as well.
    ///
    /// A step adds to w_j a few times, and each sum is rounded. So Δw_j counts as negative if it is
    /// below -4 u (|w_j before| + |w_j after|), with u the unit roundoff, and the sum over j if it
    /// is below the sum of these bounds.
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
    /// Nothing is known, except that each D_j depends on no velocity but v_j. Set
    /// [`coupled`](Self::coupled) if it depends on others.
    pub const GENERAL: Self =
        Self { zero: false, passive: Passive::No, linear: false, coupled: false };
    /// D_j = γ_j(q) p_j. Whether it is passive is not known.
    pub const LINEAR: Self = Self { linear: true, ..Self::GENERAL };
    /// D = 0.
    pub const NONE: Self =
        Self { zero: true, passive: Passive::Each, linear: true, coupled: false };
}

/// The dissipative force on one degree of freedom and its derivatives by that degree of freedom.
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
