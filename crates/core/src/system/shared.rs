//! The system traits for `Arc<S>`, by delegation.

use super::coupling::Coupling;
use super::dissipation::{Dissipation, DissipationForm};
use super::hamiltonian::System;
use super::separable::{Separable, Supply};
use crate::error::InputError;
use crate::numbers::{Line, Scalar};
use std::sync::Arc;

impl<T: Scalar, S: System<T> + ?Sized> System<T> for Arc<S> {
    #[inline]
    fn dof(&self) -> usize {
        (**self).dof()
    }
    #[inline]
    fn check(&self) -> Result<(), InputError> {
        (**self).check()
    }
    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        (**self).energy(q, p)
    }
    #[inline]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (**self).gradient(q, p, hq, hp);
    }
    #[inline]
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        (**self).dissipation(q, p, v, d);
    }
    #[inline]
    fn has_batches(&self) -> bool {
        (**self).has_batches()
    }
    #[inline]
    fn gradients(&self, q: &[&[T]], p: &[&[T]], hq: &mut [&mut [T]], hp: &mut [&mut [T]]) {
        (**self).gradients(q, p, hq, hp);
    }
    #[inline]
    fn dissipations(&self, q: &[&[T]], p: &[&[T]], v: &[&[T]], d: &mut [&mut [T]]) {
        (**self).dissipations(q, p, v, d);
    }
    #[inline]
    fn dissipation_form(&self) -> DissipationForm {
        (**self).dissipation_form()
    }
    #[inline]
    fn finds_dissipation_form(&self) -> bool {
        (**self).finds_dissipation_form()
    }
    #[inline]
    fn motors(&self) -> usize {
        (**self).motors()
    }
    #[inline]
    fn driven_by(&self, motor: usize) -> Option<usize> {
        (**self).driven_by(motor)
    }
    #[inline]
    fn motor_forces(&self, q: &[T], forces: &mut [T]) -> bool {
        (**self).motor_forces(q, forces)
    }
    #[inline]
    fn dissipation_under(&self, forces: &[T], q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        (**self).dissipation_under(forces, q, p, v, d);
    }
    #[inline]
    fn unit_mass(&self) -> bool {
        (**self).unit_mass()
    }
    #[inline]
    fn coupling(&self) -> Coupling {
        (**self).coupling()
    }
    #[inline]
    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        (**self).kinks(q, p, put);
    }
    #[inline]
    fn kinks_of_state(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        (**self).kinks_of_state(q, p, put);
    }
    #[inline]
    fn step_between_breaks(&self, q: &[T], h: T) -> T {
        (**self).step_between_breaks(q, h)
    }
    #[inline]
    fn has_breaks(&self) -> bool {
        (**self).has_breaks()
    }
    #[inline]
    fn may_be_singular(&self) -> bool {
        (**self).may_be_singular()
    }
    #[inline]
    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        (**self).is_singular_between(from, to)
    }
}

impl<T: Scalar, S: Separable<T> + ?Sized> Separable<T> for Arc<S> {
    #[inline]
    fn mass(&self, j: usize) -> T {
        (**self).mass(j)
    }
    #[inline]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        (**self).partial(q, j, at)
    }
    #[inline]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        (**self).divided_difference(q, j, to)
    }
    #[inline]
    fn has_exact_divided_differences(&self) -> bool {
        (**self).has_exact_divided_differences()
    }
    #[inline]
    fn is_singular_along(&self, q: &[T], j: usize, to: T) -> bool {
        (**self).is_singular_along(q, j, to)
    }
    #[inline]
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        (**self).dissipation_of(q, p, j)
    }
    #[inline]
    fn friction_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        (**self).friction_of(q, p, j)
    }
    #[inline]
    fn supply(&self, q: &[T], j: usize) -> Option<Supply<T>> {
        (**self).supply(q, j)
    }
}
