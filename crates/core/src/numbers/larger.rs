//! The maximum of numbers that may be NaN.

/// The larger of two numbers, or NaN if one of them is NaN. `f64::max` and comparisons drop NaN.
#[inline(always)]
pub fn larger_or_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_maximum_keeps_nan_wherever_it_stands() {
        assert_eq!([[1.0, 2.0], [2.0, 1.0]].map(|[a, b]| larger_or_nan(a, b)), [2.0; 2]);
        for numbers in [[f64::NAN, 1.0, 0.1], [1.0, f64::NAN, 0.1], [1.0, 0.1, f64::NAN]] {
            assert!(numbers.into_iter().fold(0.0, larger_or_nan).is_nan(), "{numbers:?}");
        }
    }
}
