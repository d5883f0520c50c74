//! λ, the multiple of Δz that turns the slope at the midpoint into a discrete gradient.
//!
//! ```text
//! λ = [H(z1) - H(z0) - ∇H(z̄)·Δz] / |Δz|²
//! ```

use afterbay_core::{Mask, Scalar};

/// The largest noise of h λ at which λ is part of the equation.
const LARGEST_NOISE: f64 = 1e-3;
/// If K would change without λ by more than this number of roundings of H, λ is part of the
/// equation however large its noise is.
const NEGLIGIBLE_ROUNDINGS: f64 = 16.0;

/// λ, the rounding of its numerator over ε|Δz|², and 1/|Δz|²; all 0 where λ = 0 is imposed.
pub(crate) struct Lambda<T> {
    pub(crate) value: T,
    pub(super) rough: f64,
    pub(super) inverse: f64,
}

impl<T: Scalar> Lambda<T> {
    /// λ = 0
    pub(crate) fn zero() -> Self {
        Self { value: T::zero(), rough: 0.0, inverse: 0.0 }
    }

    /// λ for ∇H(z̄)·Δz = `along` and |Δz|² = `square`. `energies` gives H(z0) and H(z1), whose
    /// rounding exceeds that of |H| by `rounding`, times 1/ε.
    #[inline]
    pub(crate) fn of(
        along: T,
        square: T,
        energies: impl FnOnce() -> [T; 2],
        rounding: f64,
    ) -> Self {
        // If |Δz|² underflows, there is no divisor.
        if square.le(T::from_f64(f64::MIN_POSITIVE / T::EPSILON)).any() {
            return Self::zero();
        }
        let [start, end] = energies();
        let inverse = 1.0 / square.to_f64();
        let rough = ((start.abs() + end.abs()).to_f64() + rounding) * inverse;
        Self { value: (end - start - along) / square, rough, inverse }
    }

    /// λ in the equation of a step h: 0 if its noise would disturb the iteration and K changes
    /// without it by a few roundings of H at most, as near an equilibrium. `resolved` keeps the
    /// decision, so that the equation does not change while it is solved.
    #[inline]
    pub(crate) fn if_resolved(self, h: T, resolved: &mut Option<bool>) -> Self {
        if self.inverse > 0.0 {
            let noise = h.to_f64().abs() * T::EPSILON * self.rough;
            let is_resolved = noise < LARGEST_NOISE || self.roundings() > NEGLIGIBLE_ROUNDINGS;
            if !*resolved.get_or_insert(is_resolved) {
                return Self::zero();
            }
        }
        self
    }

    /// The change of K without λ, λ |Δz|², in roundings of H.
    fn roundings(&self) -> f64 {
        if self.rough > 0.0 { self.value.to_f64().abs() / (T::EPSILON * self.rough) } else { 0.0 }
    }
}
