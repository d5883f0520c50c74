//! The ranges of the coordinates and momenta along a motion.

use super::side::Side;
use afterbay_core::{Scalar, StateRef};

/// The least and the largest value of each entry of (q, p) along a motion. Angles count with their
/// turns.
#[derive(Clone, Debug)]
pub(super) struct Ranges<T = f64>(Vec<[T; 2]>);

impl<T: Scalar> Ranges<T> {
    /// Ranges without a state, for `dof` degrees of freedom.
    pub(super) fn nothing(dof: usize) -> Self {
        Self(vec![nothing(); 2 * dof])
    }

    /// Widens the ranges by a state, whose motors do not count.
    pub(super) fn see(&mut self, state: StateRef<'_, T>) {
        let dof = self.0.len() / 2;
        let entries = state.q[..dof].iter().chain(&state.p[..dof]);
        self.0.iter_mut().zip(entries).for_each(|(range, &x)| widen(range, [x, x]));
    }

    /// Widens the ranges by others.
    pub(super) fn join(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(range, &by)| widen(range, by));
    }

    /// Forgets all states.
    pub(super) fn clear(&mut self) {
        self.0.fill(nothing());
    }
}

impl<T: Side> Ranges<T> {
    /// Lane k.
    pub(super) fn lane(&self, k: usize) -> Ranges {
        Ranges(self.0.iter().map(|range| range.map(|x| x.lane(k))).collect())
    }
}

impl Ranges {
    /// The ranges of points (q, p).
    pub(super) fn of(points: &[Vec<f64>]) -> Self {
        let mut all = Self(vec![nothing(); points.first().map_or(0, Vec::len)]);
        for point in points {
            all.0.iter_mut().zip(point).for_each(|(range, &x)| widen(range, [x, x]));
        }
        all
    }

    /// The number of coordinates and momenta.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// The least and the largest value of entry j.
    pub(super) fn bounds(&self, j: usize) -> [f64; 2] {
        self.0[j]
    }

    /// The extent of entry j; 0 if no state was seen.
    pub(super) fn extent(&self, j: usize) -> f64 {
        let [least, most] = self.0[j];
        (most - least).max(0.0)
    }

    /// The largest magnitude of entry j; 0 if no state was seen.
    pub(super) fn magnitude(&self, j: usize) -> f64 {
        let [least, most] = self.0[j];
        if least <= most { least.abs().max(most.abs()) } else { 0.0 }
    }
}

fn nothing<T: Scalar>() -> [T; 2] {
    [f64::INFINITY, f64::NEG_INFINITY].map(T::from_f64)
}

fn widen<T: Scalar>(range: &mut [T; 2], [least, most]: [T; 2]) {
    let [low, high] = *range;
    *range = [T::select(least.lt(low), least, low), T::select(high.lt(most), most, high)];
}
