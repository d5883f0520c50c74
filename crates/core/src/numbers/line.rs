//! A value with its derivative.

/// A function of one variable at a point: its value and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<T> {
    /// f(x)
    pub value: T,
    /// f'(x)
    pub slope: T,
}
