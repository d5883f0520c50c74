//! Systems whose energy and dissipation depend on the time.
//!
//! ```text
//! q_j' = p_j/m_j        p_j' = -∂V/∂q_j - D_j(q, p, t)        w_j' = D_j p_j/m_j
//! H = Σ p_j²/(2 m_j) + V(q, t)        s_t' = ∂V/∂t  (pumped)
//! K = H + Σ w_j - s_t is constant
//! ```
//!
//! [`Clocked`] makes an autonomous system of it, to which every method applies as it is. One more
//! degree of freedom c is a clock: its coordinate is the time, and its momentum is minus the energy
//! that the change of H in time has pumped into the system.
//!
//! ```text
//! H̃ = H(q, p, q_c) + p_c        D_c = 0
//! q_c = t        p_c = -s_t
//! ```
//!
//! So H̃ + Σ w = H + Σ w - s_t. The divided difference of V along q_c gives the change of p_c, and
//! K is kept to rounding.

use super::abilities::{Abilities, SecondDerivatives};
use super::dissipation::{Dissipation, DissipationForm};
use super::hamiltonian::System;
use super::hessian::Curvature;
use super::separable::Separable;
use crate::error::InputError;
use crate::numbers::{Line, Scalar};
use crate::quantity::{Block, Quantity};
use std::sync::Arc;

/// The number of degrees of freedom up to which the momenta are copied without an allocation.
const FEW: usize = 16;

/// A separable system with N + 1 coordinates, the last of which is the time.
///
/// The wrapped system counts the time among its coordinates. Its D_j of the time is not used.
pub struct Clocked<S: ?Sized> {
    system: Arc<S>,
    /// The clock, the last degree of freedom.
    clock: usize,
}

impl<S: ?Sized> Clone for Clocked<S> {
    fn clone(&self) -> Self {
        self.with(Arc::clone(&self.system))
    }
}

impl<S: ?Sized> std::fmt::Debug for Clocked<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Clocked").field("clock", &self.clock).finish_non_exhaustive()
    }
}

impl<S: ?Sized> Clocked<S> {
    /// Makes the last coordinate of a system the time.
    ///
    /// # Errors
    /// [`InputError::Length`] if the system has no other coordinate, and
    /// [`InputError::Unsupported`] if it is driven: the work of its forces would count as friction.
    pub fn new<T: Scalar>(system: Arc<S>) -> Result<Self, InputError>
    where
        S: System<T>,
    {
        if system.motors() > 0 {
            let why = "the system is driven: drive the system with the clock, by \
                       Driven::new(Clocked::new(system), drive)";
            return Err(InputError::Unsupported { method: "a clock", why });
        }
        match system.dof() {
            found @ ..=1 => {
                let quantity = Quantity::Coordinate;
                Err(InputError::Length { quantity, expected: 2, found })
            }
            dof => Ok(Self { system, clock: dof - 1 }),
        }
    }

    /// The wrapped system, in which the time is a coordinate.
    pub fn unclocked(&self) -> &Arc<S> {
        &self.system
    }

    /// This clock on another form of the system, which must have as many degrees of freedom.
    pub fn map<R>(&self, f: impl FnOnce(&S) -> R) -> Clocked<R> {
        self.with(Arc::new(f(&self.system)))
    }

    /// Another view of the same system.
    fn with<R: ?Sized>(&self, system: Arc<R>) -> Clocked<R> {
        Clocked { system, clock: self.clock }
    }
}

impl<T: Scalar, S: System<T> + ?Sized> System<T> for Clocked<S> {
    fn dof(&self) -> usize {
        self.clock + 1
    }

    fn check(&self) -> Result<(), InputError> {
        self.system.check()
    }

    fn energy(&self, q: &[T], p: &[T]) -> T {
        // The wrapped system adds p²/(2m) of every momentum. That of the clock is an energy, so 0
        // is passed in its place.
        let (mut few, mut many) = ([T::zero(); FEW], Vec::new());
        let own = match few.get_mut(..p.len()) {
            Some(few) => few,
            None => {
                many.resize(p.len(), T::zero());
                &mut many
            }
        };
        own[..self.clock].copy_from_slice(&p[..self.clock]);
        self.system.energy(q, own) + p[self.clock]
    }

    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        self.system.gradient(q, p, hq, hp);
        hp[self.clock] = T::one();
    }

    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.system.dissipation(q, p, v, d);
        d[self.clock] = T::zero();
    }

    fn has_batches(&self) -> bool {
        self.system.has_batches()
    }

    fn gradients(&self, q: &[&[T]], p: &[&[T]], hq: &mut [&mut [T]], hp: &mut [&mut [T]]) {
        self.system.gradients(q, p, hq, hp);
        hp.iter_mut().for_each(|hp| hp[self.clock] = T::one());
    }

    fn dissipations(&self, q: &[&[T]], p: &[&[T]], v: &[&[T]], d: &mut [&mut [T]]) {
        self.system.dissipations(q, p, v, d);
        d.iter_mut().for_each(|d| d[self.clock] = T::zero());
    }

    fn dissipation_form(&self) -> DissipationForm {
        self.system.dissipation_form()
    }

    fn motors(&self) -> usize {
        1
    }

    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        self.system.kinks(q, p, put);
    }

    fn kinks_of_state(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        self.system.kinks_of_state(q, p, put);
    }

    fn step_between_breaks(&self, q: &[T], h: T) -> T {
        self.system.step_between_breaks(q, h)
    }

    fn has_breaks(&self) -> bool {
        self.system.has_breaks()
    }

    fn may_be_singular(&self) -> bool {
        self.system.may_be_singular()
    }

    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        self.system.is_singular_between(from, to)
    }
}

impl<T: Scalar, S: Separable<T> + ?Sized> Separable<T> for Clocked<S> {
    fn mass(&self, j: usize) -> T {
        if j < self.clock { self.system.mass(j) } else { T::one() }
    }

    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        self.system.partial(q, j, at)
    }

    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        self.system.divided_difference(q, j, to)
    }

    fn has_exact_divided_differences(&self) -> bool {
        self.system.has_exact_divided_differences()
    }

    fn is_singular_along(&self, q: &[T], j: usize, to: T) -> bool {
        self.system.is_singular_along(q, j, to)
    }

    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        if j < self.clock {
            return self.system.dissipation_of(q, p, j);
        }
        Dissipation { value: T::zero(), by_q: T::zero(), by_p: T::zero() }
    }
}

impl<T: Scalar, S: SecondDerivatives<T> + ?Sized> Curvature<T> for Clocked<S> {
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        self.system.each(q, p, &mut |entries| {
            for &(block, row, column, value) in entries {
                let of_clock = match block {
                    Block::Hpp => row == self.clock,
                    Block::Dq | Block::Dp => row == self.clock,
                    Block::Hqq | Block::Hqp => false,
                };
                if !of_clock {
                    put(block, row, column, value);
                }
            }
        });
    }
}

impl<T: Scalar, S: Abilities<T> + ?Sized> Abilities<T> for Clocked<S> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        let system = self.system.clone().separable()?;
        Some(Arc::new(self.with(system)))
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        let system = self.system.clone().second_derivatives()?;
        Some(Arc::new(self.with(system)))
    }
}
