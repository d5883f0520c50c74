//! How accurate a run with adaptive steps is to be.

use crate::error::InputError;
use crate::numbers::Scalar;

/// The error allowed at the end of a run, of (q, p) and of w: `absolute + relative · size`, with the largest |q_j|, |p_j| and |w_j| as the
/// sizes of q, p and w. The steps aim at their share of it by length, so that what they add to each other is about that;
/// a system that pulls solutions apart multiplies it, one that draws them together divides it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Share of the size of q and p.
    pub relative: f64,
    /// Of q and p, in their own units.
    pub absolute: f64,
    /// The same of w, relative and absolute.
    pub w: (f64, f64),
}

impl Tolerance {
    /// `tolerance`, relative and absolute, for all of q, p and w.
    pub const fn all(tolerance: f64) -> Self {
        Self { relative: tolerance, absolute: tolerance, w: (tolerance, tolerance) }
    }

    /// Can it be met in this scalar? A relative tolerance is at least 64 of its roundings.
    ///
    /// # Errors
    /// [`InputError::Tolerance`] where one is not finite, not positive, or less than that.
    pub fn check<T: Scalar>(&self) -> Result<(), InputError> {
        let parts = [
            ("relative", self.relative, 64.0 * T::EPSILON),
            ("absolute", self.absolute, f64::MIN_POSITIVE),
            ("w relative", self.w.0, 64.0 * T::EPSILON),
            ("w absolute", self.w.1, f64::MIN_POSITIVE),
        ];
        for (name, value, least) in parts {
            if !(value >= least && value.is_finite()) {
                return Err(InputError::Tolerance { name, value, least });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Quad;

    #[test]
    fn tolerances_no_one_can_meet_are_refused() {
        for value in [0.0, -1e-6, f64::NAN, f64::INFINITY, 1e-15] {
            let good = Tolerance::all(1e-6);
            for (bad, named) in [
                (Tolerance { relative: value, ..good }, "relative"),
                (Tolerance { w: (value, 1e-6), ..good }, "w relative"),
            ] {
                let refused = bad.check::<f64>();
                assert!(
                    matches!(refused, Err(InputError::Tolerance { name, .. }) if name == named),
                    "{value}"
                );
            }
        }
        assert!(Tolerance { absolute: 0.0, ..Tolerance::all(1e-6) }.check::<f64>().is_err());
        assert!(Tolerance { absolute: 1e-30, ..Tolerance::all(1e-6) }.check::<f64>().is_ok());
        assert!(Tolerance::all(1e-15).check::<Quad>().is_ok());
    }
}
