//! What every system says of itself.

use super::along::{Sample, compare};
use super::around::{Place, around, displaced, starts};
use super::{Fields, finite, moved, reach, rounding};
use crate::{Block, InputError, Passive, Quantity, System};

/// Is the system at (q, p), and around it, what it says it is? Checks the gradient against the energy, and what is
/// claimed by [`System::unit_mass`], [`System::damping`] and [`System::coupling`].
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
    damping(system, &places)?;
    starts(&places).iter().try_for_each(|Place { q, p, .. }| coupling(system, q, p))
}

/// ∂H/∂q_j or ∂H/∂p_j against the increments of H.
fn gradient<S>(system: &S, quantity: Quantity, (q, p): (&[f64], &[f64]), j: usize) -> Result<(), InputError>
where
    S: System<f64> + ?Sized,
{
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
    compare(x[j], reach(x), rounding(q.len()), sample, |_, _, mean| mean).map(drop).map_err(|lie| {
        let rule = "it must be the derivative of the energy";
        InputError::Contradiction { quantity, dof: j, given: lie.given, found: lie.found, rule }
    })
}

/// ∂H/∂p = p
fn unit_mass(places: &[Place]) -> Result<(), InputError> {
    for Place { p, fields, .. } in places {
        if let Some(dof) = (0..p.len()).find(|&j| p[j] != fields.hp[j]) {
            let (given, found) = (p[dof], fields.hp[dof]);
            let rule = "unit_mass() says it is p";
            return Err(InputError::Contradiction { quantity: Quantity::Velocity, dof, given, found, rule });
        }
    }
    Ok(())
}

/// What is known of D beforehand.
fn damping<S: System<f64> + ?Sized>(system: &S, places: &[Place]) -> Result<(), InputError> {
    let (damping, n) = (system.damping(), system.dof());
    let refuse = |quantity, dof, found, rule| {
        Err(InputError::Contradiction { quantity, dof, given: 0.0, found, rule })
    };
    let slack = |j: usize| {
        let largest = |most: f64, place: &Place| (place.fields.d[j] * place.fields.hp[j]).abs().max(most);
        -rounding(n) * places.iter().fold(0.0, largest)
    };
    let slacks: Vec<f64> = (0..n).map(slack).collect();
    for Place { fields, .. } in places {
        if damping.zero
            && let Some(dof) = fields.d.iter().position(|&d| d != 0.0)
        {
            return refuse(Quantity::Dissipation, dof, fields.d[dof], "damping() says it is zero");
        }
        let losses: Vec<f64> = fields.d.iter().zip(&fields.hp).map(|(d, v)| d * v).collect();
        match damping.passive {
            Passive::No => {}
            Passive::InSum => {
                let total: f64 = losses.iter().sum();
                if total < slacks.iter().sum() {
                    let worst = (0..n).min_by(|&i, &j| losses[i].total_cmp(&losses[j])).unwrap_or(0);
                    return refuse(Quantity::TotalLoss, worst, total, "damping() says it is never negative");
                }
            }
            Passive::Each => {
                if let Some(dof) = (0..n).find(|&j| losses[j] < slacks[j]) {
                    return refuse(Quantity::Loss, dof, losses[dof], "damping() says it is never negative");
                }
            }
        }
    }
    if damping.linear { linear(system, places) } else { Ok(()) }
}

/// D(q, p + p') = D(q, p) + D(q, p')
fn linear<S: System<f64> + ?Sized>(system: &S, places: &[Place]) -> Result<(), InputError> {
    let n = system.dof();
    for (k, Place { q, p, fields }) in places.iter().enumerate() {
        let other = displaced(p, k + places.len(), 1.0);
        let sum: Vec<f64> = p.iter().zip(&other).map(|(a, b)| a + b).collect();
        let (one, both) = (Fields::at(system, q, &other), Fields::at(system, q, &sum));
        for dof in 0..n {
            let (a, b, found) = (fields.d[dof], one.d[dof], both.d[dof]);
            let size = a.abs() + b.abs() + found.abs() + most(places, |place| place.fields.d[dof]);
            if (a + b - found).abs() > rounding(n) * size {
                let rule = "damping() says D is linear in p: D of a sum must be the sum of D";
                let quantity = Quantity::Dissipation;
                return Err(InputError::Contradiction { quantity, dof, given: a + b, found, rule });
            }
        }
    }
    Ok(())
}

/// The largest value at any of the places.
pub(super) fn most(places: &[Place], of: impl Fn(&Place) -> f64) -> f64 {
    places.iter().fold(0.0, |most, place| of(place).abs().max(most))
}

/// What one may not act on, does not change when it moves.
fn coupling<S: System<f64> + ?Sized>(system: &S, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    let (coupling, n) = (system.coupling(), q.len());
    let rule = "coupling() says that one does not act on the other";
    let blocks = [Block::Hqq, Block::Hqp, Block::Hpp, Block::Dq, Block::Dp];
    unmoved(system, q, p, |i, j| !coupling.joins(n, i, j), &blocks, rule)
}

/// Moves every q_i and p_i and looks whether one of these derivatives of the fields of a j that is `apart` shows.
pub(super) fn unmoved<S: System<f64> + ?Sized>(
    system: &S,
    q: &[f64],
    p: &[f64],
    apart: impl Fn(usize, usize) -> bool,
    blocks: &[Block],
    rule: &'static str,
) -> Result<(), InputError> {
    let n = q.len();
    let before = Fields::at(system, q, p);
    for i in (0..n).filter(|&i| (0..n).any(|j| apart(i, j))) {
        for (by_q, share) in [(true, 0.618), (true, -0.414), (false, 0.618), (false, -0.414)] {
            let x = if by_q { q } else { p };
            let width = share * reach(x);
            let to = moved(x, i, x[i] + width);
            let after = if by_q { Fields::at(system, &to, p) } else { Fields::at(system, q, &to) };
            for j in (0..n).filter(|&j| apart(i, j)) {
                // ∂²H/∂q_i∂p_j is named by its q first.
                let changes = if by_q {
                    [
                        (Block::Hqq, [j, i], before.hq[j], after.hq[j]),
                        (Block::Hqp, [i, j], before.hp[j], after.hp[j]),
                        (Block::Dq, [j, i], before.d[j], after.d[j]),
                    ]
                } else {
                    [
                        (Block::Hqp, [j, i], before.hq[j], after.hq[j]),
                        (Block::Hpp, [j, i], before.hp[j], after.hp[j]),
                        (Block::Dp, [j, i], before.d[j], after.d[j]),
                    ]
                };
                for (block, [row, column], a, b) in changes {
                    let slack = rounding(n) * (a.abs() + b.abs());
                    if blocks.contains(&block) && b.is_finite() && (b - a).abs() > slack {
                        let found = (b - a) / width;
                        return Err(InputError::ContradictionBetween {
                            block,
                            row,
                            column,
                            given: 0.0,
                            found,
                            rule,
                        });
                    }
                }
            }
        }
    }
    Ok(())
}
