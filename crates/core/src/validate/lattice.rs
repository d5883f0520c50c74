//! What a chain or a ring of equal members says of itself.

use super::around::{Place, around, most, rounding};
use super::separable;
use crate::error::InputError;
use crate::numbers::Scalar;
use crate::quantity::Quantity;
use crate::system::{Coupling, Separable, Uniform};

/// What is compared of a member, in this order.
const QUANTITIES: [Quantity; 5] = [
    Quantity::Mass,
    Quantity::Partial,
    Quantity::Increment,
    Quantity::Dissipation,
    Quantity::DissipationSlope,
];

/// [`separable()`], and the mass, ∂V/∂q_j, its mean along edges, D_j and, where D is linear, ∂D_j/∂p_j of every member against
/// those of the middle of `[q_{j-1}, q_j, q_{j+1}]`: of the system itself, and of each of its lanes. O(N).
///
/// # Errors
/// Those of [`separable()`], and [`InputError::Contradiction`] of the first member that obeys another law.
pub fn uniform<S: Uniform + ?Sized>(s: &S, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    separable(s, q, p)?;
    let (n, lanes, linear) = (q.len(), s.lanes(), s.dissipation_form().linear);
    let places = around(s, q, p);
    for dof in 0..n {
        let steepest = most(&places, |place| place.fields.hq[dof]);
        let strongest = most(&places, |place| place.fields.d[dof]);
        for Place { q, p, .. } in &places {
            let window = beside(s.coupling(), q, dof);
            // The edge from each place leads to the state; from the state itself it is none.
            let to = places.first().map_or(q[dof], |start| start.q[dof]);
            let found = member(s, q, p, dof, to);
            let momenta = [0.0, p[dof], 0.0];
            let alone = member(s, &window, &momenta, 1, to);
            let eight = member(
                &lanes,
                &window.map(Scalar::from_f64),
                &momenta.map(Scalar::from_f64),
                1,
                Scalar::from_f64(to),
            );
            let each = (0..8).map(|k| eight.map(|x| x.to_array()[k]));
            for given in std::iter::once(alone).chain(each) {
                let sizes = [found[0], steepest, steepest, strongest, found[4].abs()];
                for (k, quantity) in QUANTITIES.into_iter().enumerate() {
                    let (given, found) = (given[k], found[k]);
                    // What is no number is not the same either.
                    let same = (given - found).abs() <= rounding(n) * sizes[k];
                    if !same && (linear || quantity != Quantity::DissipationSlope) {
                        let rule = "every member of a uniform system obeys the law of the middle of three";
                        return Err(InputError::Contradiction { quantity, dof, given, found, rule });
                    }
                }
            }
        }
    }
    Ok(())
}

/// q_{j-1}, q_j and q_{j+1}, around the ring, or with walls at 0.
fn beside(coupling: Coupling, q: &[f64], j: usize) -> [f64; 3] {
    let n = q.len();
    let ring = coupling == Coupling::Ring;
    let left = if ring { q.get((j + n - 1) % n) } else { j.checked_sub(1).and_then(|i| q.get(i)) };
    let right = if ring { q.get((j + 1) % n) } else { q.get(j + 1) };
    [left.copied().unwrap_or(0.0), q[j], right.copied().unwrap_or(0.0)]
}

/// What a member does as it is moved.
fn member<T: Scalar>(s: &(impl Separable<T> + ?Sized), q: &[T], p: &[T], j: usize, to: T) -> [T; 5] {
    let drag = s.dissipation_of(q, p, j);
    [s.mass(j), s.partial(q, j, to), s.divided_difference(q, j, to).value, drag.value, drag.by_p]
}
