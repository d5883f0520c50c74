//! Inverse sine and cosine, in slope arithmetic.

use crate::numbers::line::Line;
use crate::numbers::scalar::Scalar;
use crate::numbers::slope::Slope;

/// asin[a, b], in slope arithmetic of the half angle's tangent.
#[inline(always)]
pub fn asin<T: Scalar>(a: T, b: T) -> Line<T> {
    let (x, one) = (Slope::between(a, b), Slope::<T>::one());
    let half = (x / (one + ((one - x) * (one + x)).sqrt())).atan();
    let (one, value) = (T::one(), half.slope + half.slope);
    let root = ((one - b) * (one + b)).sqrt();
    bent(b - a, value, root.recip(), b / (root * root * root))
}

/// acos[a, b], in slope arithmetic of the quarter angle's tangent.
#[inline(always)]
pub fn acos<T: Scalar>(a: T, b: T) -> Line<T> {
    let (x, one) = (Slope::between(a, b), Slope::<T>::one());
    let quarter = ((one - x).sqrt() / ((one + one).sqrt() + (one + x).sqrt())).atan();
    let (one, value) = (T::one(), T::from_f64(4.0) * quarter.slope);
    let root = ((one - b) * (one + b)).sqrt();
    bent(b - a, value, -root.recip(), -(b / (root * root * root)))
}

/// φ[a, b] with its derivative by b, given φ'(b) and φ''(b).
#[inline(always)]
fn bent<T: Scalar>(width: T, value: T, first: T, second: T) -> Line<T> {
    let short = width.abs().lt(T::from_f64(1e-5));
    let far = (first - value) / T::select(short, T::one(), width);
    Line { value, slope: T::select(short, second.half(), far) }
}
