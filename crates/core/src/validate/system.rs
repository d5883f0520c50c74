//! What every system says of itself.

use super::around::{Fields, Place, around, finite, starts};
use super::coupling::coupling;
use super::dissipation::dissipation;
use super::gradient::{gradient, unit_mass};
use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::System;

/// Is the system at (q, p), and around it, what it says it is? Checks the gradient against the energy, and what is
/// claimed by [`System::unit_mass`], [`System::dissipation_form`] and [`System::coupling`].
///
/// # Errors
/// [`InputError::Length`] where q or p are not as long as [`System::dof`] says, [`InputError::NotFinite`] where they or
/// H, ∂H/∂q, ∂H/∂p, D there are not finite; [`InputError::Contradiction`] and [`InputError::ContradictionBetween`],
/// with what was given, what was found and the rule that is broken.
pub fn system<S: System<f64> + ?Sized>(system: &S, q: &[f64], p: &[f64]) -> Result<(), InputError> {
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
