//! Brackets: two points between which the residual changes its sign.

use crate::numbers::{Mask, Scalar};

/// Points with residuals of opposite signs, lane by lane; ±`f64::MAX` until one is known.
pub(super) struct Bracket<T> {
    low: T,
    high: T,
}

impl<T: Scalar> Bracket<T> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let far = T::from_f64(f64::MAX);
        Self { low: -far, high: far }
    }

    /// Adds a point. If it contradicts the bracket, the end on the other side becomes unknown.
    #[inline(always)]
    pub(super) fn take(&mut self, x: T, residual: T) {
        let (zero, none) = (T::zero(), Self::none());
        let (below, above) = (zero.le(residual), residual.le(zero));
        self.low = T::select(below, x, self.low);
        self.high = T::select(above, x, self.high);
        let crossed = self.high.lt(self.low);
        self.high = T::select(crossed.and(below), none.high, self.high);
        self.low = T::select(crossed.and(above), none.low, self.low);
    }

    /// Lanes in which both ends are known.
    #[inline(always)]
    fn is_closed(&self) -> T::Mask {
        let none = Self::none();
        none.low.lt(self.low).and(self.high.lt(none.high))
    }

    /// Lanes in which the distance of the ends is at most `scale`.
    #[inline(always)]
    pub(super) fn within(&self, scale: T) -> T::Mask {
        self.is_closed().and((self.high - self.low).le(scale))
    }

    /// Lanes in which `x` is not between the ends.
    #[inline(always)]
    pub(super) fn leaves(&self, x: T) -> T::Mask {
        self.is_closed().and(self.low.lt(x).and(x.lt(self.high)).not())
    }

    /// The middle, and the lanes that have one.
    #[inline(always)]
    pub(super) fn middle(&self) -> (T, T::Mask) {
        (self.low.half() + self.high.half(), self.is_closed())
    }
}
