//! Tests of the properties that every system claims.

use super::around::{Fields, Place, around, finite, starts};
use super::coupling::coupling;
use super::dissipation::dissipation;
use super::gradient::{gradient, unit_mass};
use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::System;

/// Validates a system at and around (q, p): compares the gradient with the energy, and tests the
/// claims of [`System::unit_mass`], [`System::dissipation_form`] and [`System::coupling`].
///
/// # Errors
/// [`InputError::Length`] if the length of q or p is not [`System::dof`], [`InputError::NotFinite`]
/// if q, p or H, ∂H/∂q, ∂H/∂p, D there are not finite, and [`InputError::Contradiction`] and
/// [`InputError::ContradictionBetween`] with the value given, the value found and the rule
/// violated.
pub fn system(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    let n = system.dof();
    for (quantity, part) in [(Quantity::Coordinate, q), (Quantity::Momentum, p)] {
        if part.len() != n {
            return Err(InputError::Length { quantity, expected: n, found: part.len() });
        }
        finite(quantity, part)?;
    }
    Fields::at(system, q, p).finite()?;
    let places = around(system, q, p);
    for Place { q, p, .. } in starts(&places) {
        for j in 0..n {
            gradient(system, Quantity::Slope, (q, p), j)?;
            gradient(system, Quantity::Velocity, (q, p), j)?;
        }
    }
    if system.unit_mass() {
        unit_mass(&places)?;
    }
    dissipation(system, &places)?;
    starts(&places).iter().try_for_each(|Place { q, p, .. }| coupling(system, q, p))
}
