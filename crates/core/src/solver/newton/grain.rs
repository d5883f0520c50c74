//! The rounding of F, as it is seen.

use crate::numbers::{Mask, Scalar};
use crate::solver::Equation;

/// A point where F has been evaluated.
#[derive(Clone, Copy)]
pub(in crate::solver) struct Point<T> {
    pub(in crate::solver) x: T,
    /// 1 + F'
    pub(in crate::solver) slope: T,
    /// start - x - F
    pub(in crate::solver) residual: T,
}

impl<T: Scalar> Point<T> {
    /// What x + F changes by on the way to `to`, beyond the mean of its slopes times the way.
    #[inline(always)]
    fn mismatch(&self, to: &Self) -> T {
        let rise = self.residual - to.residual;
        ((self.slope + to.slope).half() * (to.x - self.x) - rise).abs()
    }

    #[inline(always)]
    fn select(mask: T::Mask, a: Self, b: Self) -> Self {
        Self {
            x: T::select(mask, a.x, b.x),
            slope: T::select(mask, a.slope, b.slope),
            residual: T::select(mask, a.residual, b.residual),
        }
    }
}

/// What a mismatch comes from.
pub(in crate::solver) struct Grain<T: Scalar> {
    /// The mismatch: the rounding of F, in the lanes where it is that.
    pub(in crate::solver) size: T,
    /// Lanes in which a share of it is left between neighbouring numbers, so that it is no feature
    /// of F.
    pub(in crate::solver) rounding: T::Mask,
    /// Evaluations of F that took.
    pub(in crate::solver) evaluations: u32,
}

/// Halvings of an edge: more than a number has digits.
const HALVINGS: u32 = 120;
/// The share of a mismatch that is left where it is rounding.
const SHARE: f64 = 0.125;

/// Halves the edge between two points, towards the larger mismatch, down to neighbouring numbers.
///
/// A mismatch of a smooth F vanishes like the cube of the edge, that of a slope which is only near
/// the derivative like the edge itself; what rounding makes of F stays. Where 1 + F' is not
/// positive on the way, there is a fold, and no rounding is found.
#[cold]
#[inline(never)]
pub(in crate::solver) fn grain<T: Scalar>(
    s: T,
    start: T,
    [mut a, mut b]: [Point<T>; 2],
    mut open: T::Mask,
    equation: &mut impl Equation<T>,
) -> Grain<T> {
    let (zero, one) = (T::zero(), T::one());
    let (largest, other) = (a.x.abs(), b.x.abs());
    let largest = T::select(largest.lt(other), other, largest);
    let neighbours = T::from_f64(2.0 * T::EPSILON).mul_add(largest, T::from_f64(f64::MIN_POSITIVE));
    let (asked, whole) = (open, a.mismatch(&b));
    let mut rising = zero.lt(a.slope).and(zero.lt(b.slope));
    let mut evaluations = 0;
    while evaluations < HALVINGS {
        open = open.and(rising).and(neighbours.lt((b.x - a.x).abs()));
        if !open.any() {
            break;
        }
        evaluations += 1;
        let x = a.x + (b.x - a.x).half();
        let f = equation.at(s, x);
        let middle = Point { x, slope: one + f.slope, residual: start - x - f.value };
        rising = rising.and(open.not().or(zero.lt(middle.slope)));
        let first = middle.mismatch(&b).le(a.mismatch(&middle));
        b = Point::select(open.and(first), middle, b);
        a = Point::select(open.and(first.not()), middle, a);
    }
    let left = a.mismatch(&b);
    let share = zero.lt(left).and((whole * T::from_f64(SHARE)).le(left));
    let size = T::select(whole.lt(left), left, whole);
    Grain { size, rounding: asked.and(rising).and(share), evaluations }
}
