//! ∂H/∂q and ∂H/∂p against increments of H.

use super::along::{Sample, compare};
use super::around::{Fields, Place, moved, reach, rounding};
use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::System;

/// ∂H/∂q_j or ∂H/∂p_j against the increments of H.
pub(super) fn gradient(
    system: &dyn System<f64>,
    quantity: Quantity,
    (q, p): (&[f64], &[f64]),
    j: usize,
) -> Result<(), InputError> {
    let of_q = quantity == Quantity::Slope;
    let x = if of_q { q } else { p };
    let sample = |at: f64| {
        let (q, p) = if of_q { (&*moved(q, j, at), p) } else { (q, &*moved(p, j, at)) };
        let fields = Fields::at(system, q, p);
        let parts = q.iter().zip(&fields.hq).chain(p.iter().zip(&fields.hp));
        let size = parts.fold(fields.h.abs(), |size, (x, slope)| size + (x * slope).abs());
        let slope = if of_q { fields.hq[j] } else { fields.hp[j] };
        Sample { value: vec![fields.h], slope: vec![slope], size: vec![size] }
    };
    compare(x[j], reach(x), rounding(q.len()), &sample, &|_, _, mean| mean).map(drop).map_err(
        |found| {
            let rule = "it must be the derivative of the energy";
            InputError::Contradiction {
                quantity,
                dof: j,
                given: found.given,
                found: found.found,
                rule,
            }
        },
    )
}

/// Checks that ∂H/∂p = p.
pub(super) fn unit_mass(places: &[Place]) -> Result<(), InputError> {
    for Place { p, fields, .. } in places {
        if let Some(dof) = (0..p.len()).find(|&j| p[j] != fields.hp[j]) {
            let (given, found) = (p[dof], fields.hp[dof]);
            let rule = "unit_mass() says it is p";
            return Err(InputError::Contradiction {
                quantity: Quantity::Velocity,
                dof,
                given,
                found,
                rule,
            });
        }
    }
    Ok(())
}
