//! Borrowed states.

use super::hamiltonian::System;
use crate::numbers::Scalar;

/// (q, p, w) at time t as slices of length N, whatever the storage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateRef<'a, T> {
    /// Coordinates.
    pub q: &'a [T],
    /// Canonical momenta.
    pub p: &'a [T],
    /// Reservoir, one entry a degree of freedom.
    pub w: &'a [T],
    /// Time.
    pub t: T,
}

impl<T: Scalar> StateRef<'_, T> {
    /// Σ w_j
    #[inline]
    pub fn reservoir(&self) -> T {
        self.w.iter().fold(T::zero(), |sum, &w| sum + w)
    }

    /// H(q, p)
    #[inline]
    pub fn energy<S: System<T> + ?Sized>(&self, system: &S) -> T {
        system.energy(self.q, self.p)
    }

    /// K = H(q, p) + Σ w_j, the quantity the exact flow keeps.
    #[inline]
    pub fn total<S: System<T> + ?Sized>(&self, system: &S) -> T {
        self.energy(system) + self.reservoir()
    }
}
