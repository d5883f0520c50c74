//! The sum of two numbers without a rounding error.

use super::scalar::Scalar;

/// The rounded sum s of a and b and its rounding error e, so that s + e = a + b exactly:
///
/// ```text
/// s = a + b        b' = s - a        e = (a - (s - b')) + (b - b')
/// ```
///
/// For scalars of one floating-point number, unless the sum overflows. Source: D. E. Knuth, *The
/// Art of Computer Programming*, volume 2, section 4.2.2, theorem B (2Sum).
#[inline(always)]
pub fn two_sum<T: Scalar>(a: T, b: T) -> [T; 2] {
    let sum = a + b;
    let back = sum - a;
    [sum, (a - (sum - back)) + (b - back)]
}
