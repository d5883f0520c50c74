//! The tolerance of a run with error control.

use crate::error::InputError;
use crate::numbers::Scalar;

/// The error allowed at the end of a run, for (q, p) and for w: `absolute + relative · size`, where
/// the largest |q_j|, |p_j| and |w_j| are the sizes of q, p and w.
///
/// Each method divides the error among its steps, so that their errors add up to about the
/// tolerance. The time of a driven system is not counted as a coordinate, and the energy that it is
/// supplied with counts as w, not as a momentum. No error of w is asked for below the rounding of
/// H. A system whose solutions diverge magnifies the errors, and one whose solutions converge
/// reduces them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the size of q and p.
    pub relative: f64,
    /// Absolute, in the units of q and p.
    pub absolute: f64,
    /// Relative to the size of w.
    pub w_relative: f64,
    /// Absolute, in the units of energy.
    pub w_absolute: f64,
}

impl Tolerance {
    /// `tolerance` as the relative and the absolute one of q, p and w.
    pub const fn all(tolerance: f64) -> Self {
        Self {
            relative: tolerance,
            absolute: tolerance,
            w_relative: tolerance,
            w_absolute: tolerance,
        }
    }

    /// Checks the range of each part. A relative tolerance is at least 64 times the unit roundoff
    /// of the scalar.
    ///
    /// # Errors
    /// [`InputError::Tolerance`], with the part that is out of range.
    pub fn check<T: Scalar>(&self) -> Result<(), InputError> {
        let parts = [
            ("relative", self.relative, 64.0 * T::EPSILON),
            ("absolute", self.absolute, f64::MIN_POSITIVE),
            ("w relative", self.w_relative, 64.0 * T::EPSILON),
            ("w absolute", self.w_absolute, f64::MIN_POSITIVE),
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
                (Tolerance { w_relative: value, ..good }, "w relative"),
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
