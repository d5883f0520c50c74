//! The state of a system: coordinates, momenta and reservoir.

use super::hamiltonian::System;
use super::state_ref::StateRef;
use crate::error::InputError;
use crate::numbers::{Mask, Scalar, Vector, value_not_finite};
use crate::quantity::Quantity;
use std::hint::cold_path;

/// The size below which a coordinate or momentum counts as 0. Its square underflows, and it is far
/// from the smallest normal f64, 2e-308, so that the products of a step do not become subnormal.
const AT_REST: f64 = 1e-290;

/// (q, p, w) at time t. `w[j]` is the energy that degree of freedom j has dissipated since the
/// start.
#[derive(Debug, PartialEq)]
pub struct State<V: Vector> {
    /// Coordinates.
    pub q: V,
    /// Canonical momenta.
    pub p: V,
    /// Reservoir, one entry a degree of freedom.
    pub w: V,
    /// Time.
    pub t: V::Scalar,
}

impl<V: Vector> Clone for State<V> {
    /// A copy by [`Vector::copied`].
    #[inline(always)]
    fn clone(&self) -> Self {
        Self { q: self.q.copied(), p: self.p.copied(), w: self.w.copied(), t: self.t }
    }
}

impl<V: Vector> State<V> {
    /// The state (q, p) at t = 0 with an empty reservoir.
    ///
    /// # Errors
    /// [`InputError::Length`] if q and p differ in length, [`InputError::NotFinite`] if an entry is
    /// not finite.
    pub fn new(q: V, p: V) -> Result<Self, InputError> {
        let w = V::zeros(q.as_slice().len());
        let state = Self { q, p, w, t: V::Scalar::zero() };
        state.check(state.dof())?;
        Ok(state)
    }

    /// The number of degrees of freedom.
    #[inline(always)]
    pub fn dof(&self) -> usize {
        V::LEN.unwrap_or(self.q.as_slice().len())
    }

    /// Checks that the state is finite and has `dof` degrees of freedom.
    ///
    /// # Errors
    /// [`InputError::Length`] and [`InputError::NotFinite`], with the quantity and the index.
    pub fn check(&self, dof: usize) -> Result<(), InputError> {
        let parts = [
            (Quantity::Coordinate, &self.q),
            (Quantity::Momentum, &self.p),
            (Quantity::Reservoir, &self.w),
        ];
        for (quantity, part) in parts {
            let part = part.as_slice();
            if part.len() != dof {
                return Err(InputError::Length { quantity, expected: dof, found: part.len() });
            }
            // Not by `first_not_finite`, which the compiler puts into the time loop.
            if let Some(dof) = part.iter().position(|x| !x.is_finite().all()) {
                let value = value_not_finite(part[dof]);
                return Err(InputError::NotFinite { quantity, dof, value });
            }
        }
        Ok(())
    }

    /// Checks that the state is finite and fits a system with `dof` degrees of freedom, the last
    /// `motors()` of which are its motors ([`System::motors`]).
    ///
    /// # Errors
    /// Those of [`State::check`], and [`InputError::NoMotors`] if the motors are missing.
    pub fn check_with(&self, dof: usize, motors: impl Fn() -> usize) -> Result<(), InputError> {
        self.check(dof).map_err(|error| match error {
            InputError::Length { quantity: Quantity::Coordinate, found, .. }
                if found < dof && found + motors() == dof =>
            {
                InputError::NoMotors { found, motors: motors() }
            }
            error => error,
        })
    }

    /// The state as borrowed slices.
    #[inline(always)]
    pub fn state_ref(&self) -> StateRef<'_, V::Scalar> {
        StateRef { q: self.q.as_slice(), p: self.p.as_slice(), w: self.w.as_slice(), t: self.t }
    }

    /// Σ w_j
    #[inline]
    pub fn reservoir(&self) -> V::Scalar {
        self.state_ref().reservoir()
    }

    /// H(q, p)
    #[inline]
    pub fn energy<S: System<V::Scalar> + ?Sized>(&self, system: &S) -> V::Scalar {
        self.state_ref().energy(system)
    }

    /// K = H(q, p) + Σ w_j, the quantity the exact flow keeps.
    #[inline]
    pub fn total<S: System<V::Scalar> + ?Sized>(&self, system: &S) -> V::Scalar {
        self.state_ref().total(system)
    }

    /// Copies `other`, which has the same length.
    pub(crate) fn copy(&mut self, other: &Self) {
        let parts = [(&mut self.q, &other.q), (&mut self.p, &other.p), (&mut self.w, &other.w)];
        for (part, other) in parts {
            part.assign(other.as_slice());
        }
        self.t = other.t;
    }

    /// Whether q, p and w are equal; the times may differ.
    pub(crate) fn stands_where(&self, other: &Self) -> bool {
        let parts = [(&self.q, &other.q), (&self.p, &other.p), (&self.w, &other.w)];
        parts.into_iter().all(|(part, other)| part.as_slice() == other.as_slice())
    }

    /// A placeholder without heap storage.
    pub(crate) fn vacant() -> Self {
        Self { q: V::zeros(0), p: V::zeros(0), w: V::zeros(0), t: V::Scalar::zero() }
    }

    /// Sets entries of q and p below [`AT_REST`] to 0, and returns whether there are any but 0.
    /// Their energy underflows, arithmetic on the subnormal numbers that end a long decay is six
    /// times slower, and steps between such numbers may fail.
    pub(crate) fn set_tiny_to_zero(&mut self) -> bool {
        let (rest, zero) = (V::Scalar::from_f64(AT_REST), V::Scalar::zero());
        let mut found = false;
        for part in [&mut self.q, &mut self.p] {
            for x in part.as_mut_slice() {
                if x.abs().lt(rest).any() {
                    cold_path();
                    let kept = V::Scalar::select(x.abs().lt(rest), zero, *x);
                    found |= kept != *x;
                    *x = kept;
                }
            }
        }
        found
    }
}
