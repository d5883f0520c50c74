//! Chains and rings of equal members.

use super::around::{Place, around, most, rounding};
use super::separable;
use crate::error::InputError;
use crate::numbers::Scalar;
use crate::quantity::Quantity;
use crate::system::{Coupling, Members, Separable};

/// The quantities of a member that are compared, in this order.
const QUANTITIES: [Quantity; 5] = [
    Quantity::Mass,
    Quantity::Partial,
    Quantity::Increment,
    Quantity::Dissipation,
    Quantity::DissipationSlope,
];

/// Validates by [`separable()`], and compares the mass, ∂V/∂q_j, its divided difference, D_j and,
/// if D is linear, ∂D_j/∂p_j of every member with those of the middle of `[q_{j-1}, q_j, q_{j+1}]`,
/// for the system itself and for each of its lanes. The cost is O(N).
///
/// # Errors
/// Those of [`separable()`], and [`InputError::Contradiction`] with the first member that differs.
pub fn uniform(s: &dyn Members, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    separable(s, q, p)?;
    let (n, lanes, linear) = (q.len(), s.side_by_side()?, s.dissipation_form().linear);
    let ends = s.at_ends();
    let places = around(s, q, p);
    for dof in 0..n {
        let steepest = most(&places, |place| place.fields.hq[dof]);
        let strongest = most(&places, |place| place.fields.d[dof]);
        for Place { q, p, .. } in &places {
            let window = beside(s.coupling(), q, dof);
            // The edge leads from each state to the given one, and has width 0 for that one.
            let to = places.first().map_or(q[dof], |start| start.q[dof]);
            let found = member(s, q, p, dof, to);
            let momenta = [0.0, p[dof], 0.0];
            let end = ends.as_ref().and_then(|[first, last]| match dof {
                0 => Some(first),
                _ if dof + 1 == n => Some(last),
                _ => None,
            });
            let given = match end {
                Some(end) => vec![member(&**end, &window, &momenta, 1, to)],
                None => {
                    let eight = member(
                        &lanes,
                        &window.map(Scalar::from_f64),
                        &momenta.map(Scalar::from_f64),
                        1,
                        Scalar::from_f64(to),
                    );
                    let each = (0..8).map(|k| eight.map(|x| x.to_array()[k]));
                    each.chain([member(s, &window, &momenta, 1, to)]).collect()
                }
            };
            for given in given {
                let sizes = [found[0], steepest, steepest, strongest, found[4].abs()];
                for (k, quantity) in QUANTITIES.into_iter().enumerate() {
                    let (given, found) = (given[k], found[k]);
                    // NaN counts as a difference.
                    let same = (given - found).abs() <= rounding(n) * sizes[k];
                    if !same && (linear || quantity != Quantity::DissipationSlope) {
                        let rule =
                            "every member of a uniform system obeys the law of the middle of three";
                        return Err(InputError::Contradiction {
                            quantity,
                            dof,
                            given,
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

/// q_{j-1}, q_j and q_{j+1} in a ring, or in a chain with fixed ends at 0.
fn beside(coupling: Coupling, q: &[f64], j: usize) -> [f64; 3] {
    let n = q.len();
    let ring = coupling == Coupling::Ring;
    let left = if ring { q.get((j + n - 1) % n) } else { j.checked_sub(1).and_then(|i| q.get(i)) };
    let right = if ring { q.get((j + 1) % n) } else { q.get(j + 1) };
    [left.copied().unwrap_or(0.0), q[j], right.copied().unwrap_or(0.0)]
}

/// The compared quantities of member j on the edge to `to`.
fn member<T: Scalar>(
    s: &(impl Separable<T> + ?Sized),
    q: &[T],
    p: &[T],
    j: usize,
    to: T,
) -> [T; 5] {
    let drag = s.dissipation_of(q, p, j);
    [s.mass(j), s.partial(q, j, to), s.divided_difference(q, j, to).value, drag.value, drag.by_p]
}
