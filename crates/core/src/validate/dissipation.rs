//! The form of D that a system claims.

use super::around::{Fields, Place, displaced, most, rounding};
use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::{Passive, System};

/// Checks the claims of [`System::dissipation_form`].
pub(super) fn dissipation(system: &dyn System<f64>, places: &[Place]) -> Result<(), InputError> {
    let (damping, n) = (system.dissipation_form(), system.dof());
    let refuse = |quantity, dof, found, rule| {
        Err(InputError::Contradiction { quantity, dof, given: 0.0, found, rule })
    };
    let slack = |j: usize| {
        let largest =
            |most: f64, place: &Place| (place.fields.d[j] * place.fields.hp[j]).abs().max(most);
        -rounding(n) * places.iter().fold(0.0, largest)
    };
    let slacks: Vec<f64> = (0..n).map(slack).collect();
    for Place { fields, .. } in places {
        if damping.zero
            && let Some(dof) = fields.d.iter().position(|&d| d != 0.0)
        {
            return refuse(
                Quantity::Dissipation,
                dof,
                fields.d[dof],
                "dissipation_form() says it is zero",
            );
        }
        let losses: Vec<f64> = fields.d.iter().zip(&fields.hp).map(|(d, v)| d * v).collect();
        match damping.passive {
            Passive::No => {}
            Passive::InSum => {
                let total: f64 = losses.iter().sum();
                if total < slacks.iter().sum() {
                    let worst =
                        (0..n).min_by(|&i, &j| losses[i].total_cmp(&losses[j])).unwrap_or(0);
                    return refuse(
                        Quantity::TotalReservoirRate,
                        worst,
                        total,
                        "dissipation_form() says it is never negative",
                    );
                }
            }
            Passive::Each => {
                if let Some(dof) = (0..n).find(|&j| losses[j] < slacks[j]) {
                    return refuse(
                        Quantity::ReservoirRate,
                        dof,
                        losses[dof],
                        "dissipation_form() says it is never negative",
                    );
                }
            }
        }
    }
    if damping.linear { linear(system, places) } else { Ok(()) }
}

/// Checks that D(q, p + p') = D(q, p) + D(q, p').
fn linear(system: &dyn System<f64>, places: &[Place]) -> Result<(), InputError> {
    let n = system.dof();
    for (k, Place { q, p, fields }) in places.iter().enumerate() {
        let other = displaced(p, k + places.len(), 1.0);
        let sum: Vec<f64> = p.iter().zip(&other).map(|(a, b)| a + b).collect();
        let (one, both) = (Fields::at(system, q, &other), Fields::at(system, q, &sum));
        for dof in 0..n {
            let (a, b, found) = (fields.d[dof], one.d[dof], both.d[dof]);
            let size = a.abs() + b.abs() + found.abs() + most(places, |place| place.fields.d[dof]);
            if (a + b - found).abs() > rounding(n) * size {
                let rule =
                    "dissipation_form() says D is linear in p: D of a sum must be the sum of D";
                let quantity = Quantity::Dissipation;
                return Err(InputError::Contradiction { quantity, dof, given: a + b, found, rule });
            }
        }
    }
    Ok(())
}
