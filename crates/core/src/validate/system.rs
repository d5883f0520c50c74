//! Tests of the properties that every system claims.

use super::around::{Fields, Place, around, finite, starts};
use super::coupling::coupling;
use super::dissipation::dissipation;
use super::gradient::{gradient, unit_mass};
use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::System;

/// Checks that q, p and H, ∂H/∂q, ∂H/∂p, D there are finite.
///
/// # Errors
/// [`InputError::Length`] if the length of q or p is not [`System::dof`], and
/// [`InputError::NotFinite`].
pub fn finite_at(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    let n = system.dof();
    for (quantity, part) in [(Quantity::Coordinate, q), (Quantity::Momentum, p)] {
        if part.len() != n {
            return Err(InputError::Length { quantity, expected: n, found: part.len() });
        }
        finite(quantity, part)?;
    }
    Fields::at(system, q, p).finite()
}

/// Validates a system at and around (q, p): compares the gradient with the energy, and tests that
/// every entry of ∂H/∂q, ∂H/∂p and D is written, and the claims of [`System::unit_mass`],
/// [`System::dissipation_form`] and [`System::coupling`].
///
/// # Errors
/// Those of [`finite_at`], and [`InputError::Contradiction`] and
/// [`InputError::ContradictionBetween`] with the value given, the value found and the rule
/// violated.
pub fn system(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    let n = system.dof();
    finite_at(system, q, p)?;
    written(system, q, p)?;
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

/// Checks that the system writes every entry, whatever it contains before.
fn written(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    let (zeros, ones) = (Fields::at(system, q, p), Fields::over(1.0, system, q, p));
    for (quantity, given, found, rule) in [
        (Quantity::Slope, ones.hq, zeros.hq, "gradient() must write every entry, 0 as well"),
        (Quantity::Velocity, ones.hp, zeros.hp, "gradient() must write every entry, 0 as well"),
        (Quantity::Dissipation, ones.d, zeros.d, "dissipation() must write every entry, 0 as well"),
    ] {
        for (dof, (given, found)) in given.into_iter().zip(found).enumerate() {
            if given.to_bits() != found.to_bits() {
                return Err(InputError::Contradiction { quantity, dof, given, found, rule });
            }
        }
    }
    Ok(())
}
