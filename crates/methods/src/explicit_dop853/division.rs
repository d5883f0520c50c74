//! The division of a step into parts, in each lane.
//!
//! A part is taken again, shorter, where it does not resolve the motion, or a stage lies beyond a
//! kink. The lengths are halves and doubles of each other, apart from those at kinks. So
//! neighbouring motions divide their steps at the same places, and the end of a step depends
//! smoothly on its start.

use super::resolution::Resolution;
use crate::kernels::reductions::smaller;
use afterbay_core::{Mask, Scalar};

/// 2⁻²⁰, the share of the step below which the resolution of a part is not examined: a force that
/// jumps is then wrong for no longer. A choice.
const LEAST: f64 = 1.0 / (1 << 20) as f64;
/// The length of the part across a kink, in roundings of the step.
const ACROSS: f64 = 512.0;

/// The part of a step that remains, and the limits of its next part.
#[derive(Clone, Debug)]
pub(super) struct Division<T: Scalar> {
    h: T,
    left: T,
    /// The longest part that resolves the motion, as far as is known.
    longest: T,
    /// The longest part that ends before a kink, as far as is known.
    clear: T,
    /// The part that remains behind a kink that it crosses.
    across: T,
    /// Whether the next part crosses a kink, towards which the motion turned.
    at_kink: T::Mask,
    /// Whether the numbers at the end of the shortest parts are not finite.
    stuck: T::Mask,
}

/// A part that is not accepted yet.
pub(super) struct Trial<T: Scalar> {
    pub(super) length: T,
    /// The length that it would have without kinks.
    pub(super) most: T,
    /// Whether it leads across a kink that is very near.
    pub(super) crosses: T::Mask,
    /// Whether a stage or the end lies beyond a kink.
    pub(super) passed: T::Mask,
    /// Whether the end lies beside a kink, and not on the side of the start.
    pub(super) leaves: T::Mask,
    /// Whether q, p and w are finite at the end.
    pub(super) finite: T::Mask,
    pub(super) resolution: Resolution<T>,
}

impl<T: Scalar> Division<T> {
    pub(super) fn new(h: T) -> Self {
        let nowhere = nowhere::<T>();
        let across = shortest(h);
        Self { h, left: h, longest: h, clear: h, across, at_kink: nowhere, stuck: nowhere }
    }

    pub(super) fn left(&self) -> T {
        self.left
    }

    pub(super) fn h(&self) -> T {
        self.h
    }

    pub(super) fn across(&self) -> T {
        self.across
    }

    pub(super) fn at_kink(&self) -> T::Mask {
        self.at_kink
    }

    /// The longest part that is allowed, with one more bound.
    pub(super) fn most(&self, bound: T) -> T {
        smaller(smaller(bound, self.left), smaller(self.longest, self.clear))
    }

    /// Whether the step is complete in all lanes.
    pub(super) fn is_complete(&self) -> bool {
        self.left.le(T::zero()).all()
    }

    /// Whether numbers are not finite in a lane, however short the parts are.
    pub(super) fn is_stuck(&self) -> bool {
        self.stuck.any()
    }

    /// Whether the part is accepted. If not, the next one is shorter, or longer where it has to
    /// cross a kink.
    pub(super) fn judge(&mut self, trial: &Trial<T>) -> T::Mask {
        let &Trial { length, most, crosses, passed, leaves, finite, ref resolution } = trial;
        let runs = T::zero().lt(self.left);
        // Roundings of q or p hide so short a motion.
        let by_kink = length.lt(most);
        let hidden = crosses.and(leaves.not()).and(by_kink);
        self.across = T::select(hidden, self.across + self.across, self.across);
        // The motion turned towards a kink.
        let turned = passed.and(crosses.not());
        self.clear = T::select(turned, length.half(), self.clear);
        self.at_kink = self.at_kink.or(turned.and(self.clear.lt(shortest(self.h))));
        self.clear = T::select(hidden, self.clear + self.clear, self.clear);

        let examined = (self.h * T::from_f64(LEAST)).lt(length);
        let insufficient = finite.not().or(examined.and(resolution.is_insufficient(by_kink)));
        let coarse = finite.not().or(resolution.is_coarse());
        let less = length * T::select(coarse, T::from_f64(0.125), T::from_f64(0.5));
        self.longest = T::select(insufficient, less, self.longest);
        let vanishes = self.longest.lt(self.h * T::from_f64(T::EPSILON));
        self.stuck = runs.and(finite.not()).and(vanishes);

        let accepted = runs.and(hidden.or(turned).or(insufficient).not());
        let longer = accepted.and(resolution.is_fine()).and(self.longest.le(length));
        self.longest = T::select(longer, self.longest + self.longest, self.longest);
        self.left -= T::select(accepted, length, T::zero());
        self.clear = T::select(accepted, self.h, self.clear);
        self.across = T::select(accepted, shortest(self.h), self.across);
        self.at_kink = self.at_kink.and(accepted.not());
        accepted
    }
}

/// False in all lanes.
pub(super) fn nowhere<T: Scalar>() -> T::Mask {
    T::zero().lt(T::zero())
}

/// The length of the shortest part across a kink, in a step h.
pub(super) fn shortest<T: Scalar>(h: T) -> T {
    h * T::from_f64(ACROSS * T::EPSILON)
}
