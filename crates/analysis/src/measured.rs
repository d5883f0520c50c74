//! Errors measured against a reference that has a doubt.

use afterbay_core::larger_or_nan;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Add;

/// Bounds of the error of a reference state: the largest error of an entry of q, of p and of w,
/// each in its own unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Doubt {
    /// The bound for q.
    pub q: f64,
    /// The bound for p.
    pub p: f64,
    /// The bound for w.
    pub w: f64,
}

impl Doubt {
    /// The larger of each bound; NaN counts as the largest.
    pub fn larger(self, other: Self) -> Self {
        let [q, p, w] = [(self.q, other.q), (self.p, other.p), (self.w, other.w)]
            .map(|(a, b)| larger_or_nan(a, b));
        Self { q, p, w }
    }

    /// The larger of the bounds for q and p.
    pub fn qp(self) -> f64 {
        larger_or_nan(self.q, self.p)
    }

    /// The largest of the bounds.
    pub fn most(self) -> f64 {
        larger_or_nan(self.qp(), self.w)
    }
}

impl Add for Doubt {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { q: self.q + other.q, p: self.p + other.p, w: self.w + other.w }
    }
}

/// The error of a run as measured against a reference, and the doubt of that reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The distance to the reference.
    pub error: f64,
    /// The doubt of the reference.
    pub doubt: f64,
}

/// The least ratio of a resolved error to the doubt of its reference.
pub const RESOLVED: f64 = 10.0;

impl Measured {
    /// Whether the error is large compared with the doubt of the reference. An error that is not
    /// resolved is known only to be at most [`Measured::bound`], and is not used for orders and
    /// fits.
    pub fn is_resolved(self) -> bool {
        self.error >= RESOLVED * self.doubt
    }

    /// An upper bound of the true error.
    pub fn bound(self) -> f64 {
        self.error + self.doubt
    }

    /// The larger error with the larger doubt. The largest true error differs from the largest
    /// measured error by at most this doubt.
    pub fn larger(self, other: Self) -> Self {
        Self {
            error: larger_or_nan(self.error, other.error),
            doubt: larger_or_nan(self.doubt, other.doubt),
        }
    }
}

/// `1.2e-8` if the error is resolved, else the upper bound `≤ 1.2e-8 + 3.4e-9`. An error below its
/// doubt says nothing beside it, and only the sum is printed: `≤ 2.9e-11`.
impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { error, doubt } = self;
        if self.is_resolved() {
            write!(f, "{error:.1e}")
        } else if error < doubt {
            write!(f, "≤ {:.1e}", self.bound())
        } else {
            write!(f, "≤ {error:.1e} + {doubt:.1e}")
        }
    }
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
        assert_eq!([says(0.0, 2.9e-11), says(2e-11, 3e-11)], ["≤ 2.9e-11", "≤ 5.0e-11"]);
        assert!(!Measured { error: 1.0, doubt: f64::NAN }.is_resolved());
        assert!(!Measured { error: f64::NAN, doubt: 0.0 }.is_resolved());
    }
}
