//! Inverse sine and cosine, in slope arithmetic.

use crate::numbers::line::Line;
use crate::numbers::scalar::Scalar;
use crate::numbers::slope::Slope;

/// asin[a, b], by slope arithmetic for the tangent of half the angle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn asin<T: Scalar>(a: T, b: T) -> Line<T> {
    let (x, one) = (Slope::between(a, b), Slope::<T>::one());
    let half = (x / (one + ((one - x) * (one + x)).sqrt())).atan();
    let (one, value) = (T::one(), half.slope + half.slope);
    let root = ((one - b) * (one + b)).sqrt();
    with_derivative(b - a, value, root.recip(), b / (root * root * root))
}

/// acos[a, b], by slope arithmetic for the tangent of a quarter of the angle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn acos<T: Scalar>(a: T, b: T) -> Line<T> {
    let (x, one) = (Slope::between(a, b), Slope::<T>::one());
    let quarter = ((one - x).sqrt() / ((one + one).sqrt() + (one + x).sqrt())).atan();
    let (one, value) = (T::one(), T::from_f64(4.0) * quarter.slope);
    let root = ((one - b) * (one + b)).sqrt();
    with_derivative(b - a, value, -root.recip(), -(b / (root * root * root)))
}

/// The shortest edge on which the derivative of φ[a, b] by b is the quotient (φ'(b) - φ[a, b])/(b -
/// a). On a shorter one it is its limit φ''(b)/2, whose error is of the order of the width; the
/// rounding error of the quotient is of the order of ε over the width.
const SHORTEST_EDGE: f64 = 1e-5;

/// φ[a, b] with its derivative by b, given φ'(b) and φ''(b).
#[inline(always)]
fn with_derivative<T: Scalar>(width: T, value: T, first: T, second: T) -> Line<T> {
    let short = width.abs().lt(T::from_f64(SHORTEST_EDGE));
    let far = (first - value) / T::select(short, T::one(), width);
    Line { value, slope: T::select(short, second.half(), far) }
}
