//! The order of a method.

use std::fmt;

/// The order of a method, or of one of its local errors. A method without error is above each
/// order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    /// The error is O(h^r).
    Of(u32),
    /// The only error is rounding.
    Exact,
}

impl Order {
    /// The orders in q, p and w.
    pub(super) const fn each([q, p, w]: [u32; 3]) -> [Self; 3] {
        [Self::Of(q), Self::Of(p), Self::Of(w)]
    }

    /// r, if there is an error.
    pub const fn number(self) -> Option<u32> {
        match self {
            Self::Of(order) => Some(order),
            Self::Exact => None,
        }
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Of(order) => order.fmt(f),
            Self::Exact => "exact".fmt(f),
        }
    }
}
