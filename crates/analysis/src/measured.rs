//! Errors measured against a reference that is known to some doubt itself.

use serde::Serialize;
use std::fmt;

/// How far a state of a reference may be from the exact one: bounds of the largest error of an
/// entry of q and p, and of w.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Doubt {
    /// Of q and p.
    pub qp: f64,
    /// Of w.
    pub w: f64,
}

impl Doubt {
    /// The larger of each; NaN counts as the largest.
    pub fn larger(self, other: Self) -> Self {
        Self { qp: larger(self.qp, other.qp), w: larger(self.w, other.w) }
    }

    /// The larger of both parts.
    pub fn most(self) -> f64 {
        larger(self.qp, self.w)
    }
}

/// The error of a run as measured against a reference, and the doubt of that reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Measured {
    /// The distance to the reference.
    pub error: f64,
    /// The doubt of the reference.
    pub doubt: f64,
}

/// An error counts as measured where it is at least this many times the doubt of its reference.
pub const RESOLVED: f64 = 10.0;

impl Measured {
    /// Is the error large against the doubt of the reference? Otherwise it is known only to be no
    /// larger than [`Measured::bound`]; it stands for no order and no fit.
    pub fn is_resolved(self) -> bool {
        self.error >= RESOLVED * self.doubt
    }

    /// What the true error does not exceed.
    pub fn bound(self) -> f64 {
        self.error + self.doubt
    }

    /// The larger error with the larger doubt: the largest true error is within that doubt of the
    /// largest error measured.
    pub fn larger(self, other: Self) -> Self {
        Self { error: larger(self.error, other.error), doubt: larger(self.doubt, other.doubt) }
    }
}

/// `1.2e-8` where the error is resolved, `≤ 1.2e-8 + 3.4e-8` elsewhere.
impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { error, doubt } = self;
        if self.is_resolved() {
            write!(f, "{error:.1e}")
        } else {
            write!(f, "≤ {error:.1e} + {doubt:.1e}")
        }
    }
}

/// The larger number, NaN if one of them is.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_below_ten_doubts_is_a_bound() {
        let says = |error, doubt| Measured { error, doubt }.to_string();
        assert_eq!(says(1.25e-7, 1.25e-8), "1.2e-7");
        assert_eq!(says(1.25e-7, 1.26e-8), "≤ 1.2e-7 + 1.3e-8");
        assert_eq!(says(0.0, 0.0), "0.0e0");
        assert!(!Measured { error: 1.0, doubt: f64::NAN }.is_resolved());
        assert!(!Measured { error: f64::NAN, doubt: 0.0 }.is_resolved());
    }

    #[test]
    fn a_number_that_is_none_is_the_largest() {
        assert!(larger(1.0, f64::NAN).is_nan() && larger(f64::NAN, 1.0).is_nan());
        assert_eq!(larger(1.0, 2.0), 2.0);
    }
}
