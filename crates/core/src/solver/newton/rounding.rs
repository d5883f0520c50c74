//! Measurement of the rounding error of F.

use crate::numbers::{Mask, Scalar};
use crate::solver::Equation;

/// A point at which F was evaluated.
#[derive(Clone, Copy)]
pub(in crate::solver) struct Point<T> {
    pub(in crate::solver) x: T,
    /// 1 + F'
    pub(in crate::solver) slope: T,
    /// start - x - F
    pub(in crate::solver) residual: T,
}

impl<T: Scalar> Point<T> {
    /// The change of x + F from here to `to`, less the trapezoidal rule for its slope.
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

/// The outcome of a measurement.
pub(in crate::solver) struct MeasuredRounding<T: Scalar> {
    /// The mismatch; it is the rounding error of F in the lanes of `rounding`.
    pub(in crate::solver) size: T,
    /// Lanes in which a share of the mismatch remains between neighbouring numbers, so that it is
    /// rounding and no feature of F.
    pub(in crate::solver) rounding: T::Mask,
    /// The evaluations of F that were made.
    pub(in crate::solver) evaluations: u32,
}

/// The largest number of bisections: more than the 106 bits of the longest scalar.
const MOST_HALVINGS: u32 = 120;
/// The share of a mismatch that remains between neighbouring numbers if it is rounding; between 0
/// and 1. A choice: a smooth F leaves far less.
const REMAINING_SHARE: f64 = 0.125;

/// Bisects the edge between two points, towards the half with the larger mismatch, down to
/// neighbouring numbers.
///
/// The mismatch of a smooth F decreases like the cube of the edge, and like the edge itself if the
/// slope is not exactly the derivative. The part that comes from rounding remains. If 1 + F' is not
/// positive on the way there may be a fold, and the mismatch does not count as rounding.
#[cold]
#[inline(never)]
pub(in crate::solver) fn measure_rounding<T: Scalar>(
    s: T,
    start: T,
    [mut a, mut b]: [Point<T>; 2],
    mut open: T::Mask,
    equation: &mut impl Equation<T>,
) -> MeasuredRounding<T> {
    let (zero, one) = (T::zero(), T::one());
    let (largest, other) = (a.x.abs(), b.x.abs());
    let largest = T::select(largest.lt(other), other, largest);
    let neighbours = T::from_f64(2.0 * T::EPSILON).mul_add(largest, T::from_f64(f64::MIN_POSITIVE));
    let (asked, whole) = (open, a.mismatch(&b));
    let mut rising = zero.lt(a.slope).and(zero.lt(b.slope));
    let mut evaluations = 0;
    while evaluations < MOST_HALVINGS {
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
    let share = zero.lt(left).and((whole * T::from_f64(REMAINING_SHARE)).le(left));
    let size = T::select(whole.lt(left), left, whole);
    MeasuredRounding { size, rounding: asked.and(rising).and(share), evaluations }
}
