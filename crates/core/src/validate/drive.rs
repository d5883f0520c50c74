//! The validation of drives: their harmonics and dependences are compared with their forces.

use super::around::{displaced, finite, moved, rounding};
use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::{Drive, Harmonics};
use std::f64::consts::TAU;

/// The number of pairs of coordinates and times at which claims are tested. A choice.
const PLACES: usize = 40;
/// The distances of the tested times from t, in longest periods of the harmonics, or in units of
/// time where there are none.
const SPANS: [f64; 5] = [1.0, 0.01, 0.3, 30.0, 1000.0];

/// Validates a drive at and around the coordinates q and the time t: compares
/// [`Drive::harmonics`] with the forces, and tests the claims of [`Drive::depends_on_own`] and
/// [`Drive::depends_on_coordinates`]. [`curvature`](super::curvature()) of a [`crate::Driven`]
/// system compares [`Drive::slopes`].
///
/// ```
/// use afterbay_core::{Drive, Harmonic, Harmonics, InputError, validate};
///
/// /// F = cos ωt on the first degree of freedom, and the ω that it claims.
/// struct Shaker {
///     omega: f64,
///     claimed: f64,
/// }
///
/// impl Drive<f64> for Shaker {
///     fn driven(&self) -> &[usize] {
///         &[0]
///     }
///     fn force(&self, _k: usize, _q: &[f64], t: f64) -> f64 {
///         (self.omega * t).cos()
///     }
///     fn slopes(&self, _k: usize, _q: &[f64], t: f64, put: &mut dyn FnMut(Option<usize>, f64)) {
///         put(None, -self.omega * (self.omega * t).sin());
///     }
///     fn harmonics(&self, _k: usize) -> Option<Harmonics<f64>> {
///         let term = Harmonic { frequency: self.claimed, cosine: 1.0, sine: 0.0 };
///         Some(Harmonics { constant: 0.0, terms: vec![term] })
///     }
/// }
///
/// let good = Shaker { omega: 1.3, claimed: 1.3 };
/// assert_eq!(validate::drive(&good, &[0.5, 0.2], 0.0), Ok(()));
/// let wrong = Shaker { omega: 1.3, claimed: 1.4 };
/// let found = validate::drive(&wrong, &[0.5, 0.2], 0.0);
/// assert!(matches!(found, Err(InputError::Contradiction { dof: 0, .. })));
/// ```
///
/// # Errors
/// [`InputError::Length`] if q has no entry for a driven degree of freedom,
/// [`InputError::NotFinite`] if q or a force at q and t is not finite, and
/// [`InputError::Contradiction`] with the force claimed, the force found and the rule violated.
pub fn drive(drive: &dyn Drive<f64>, q: &[f64], t: f64) -> Result<(), InputError> {
    finite(Quantity::Coordinate, q)?;
    for (k, &dof) in drive.driven().iter().enumerate() {
        if dof >= q.len() {
            let (expected, found) = (dof + 1, q.len());
            return Err(InputError::Length { quantity: Quantity::Coordinate, expected, found });
        }
        let value = drive.force(k, q, t);
        if !value.is_finite() {
            return Err(InputError::NotFinite { quantity: Quantity::Drive, dof, value });
        }
        claims(drive, k, dof, q, t)?;
    }
    Ok(())
}

/// Tests the claims about force k, which acts on `dof`.
fn claims(
    drive: &dyn Drive<f64>,
    k: usize,
    dof: usize,
    q: &[f64],
    t: f64,
) -> Result<(), InputError> {
    let (sum, quantity) = (drive.harmonics(k), Quantity::Drive);
    let span = sum.as_ref().and_then(longest_period).unwrap_or(1.0);
    for i in 0..PLACES {
        let shift = if i == 0 { 0.0 } else { displaced(&[0.0], i, SPANS[i % SPANS.len()])[0] };
        let (there, time) = (displaced(q, i, [1.0, 0.25, 0.01][i % 3]), t + span * shift);
        let [here, away] = [q, &there].map(|q| drive.force(k, q, time));
        let own = drive.force(k, &moved(&there, dof, q[dof]), time);
        // Only where all of them have values.
        if !(here + away + own).is_finite() {
            continue;
        }
        let same = |given: f64, found: f64, size: f64, rule| {
            // NaN counts as a difference.
            if (given - found).abs() <= rounding(q.len()) * (size + given.abs() + found.abs()) {
                Ok(())
            } else {
                Err(InputError::Contradiction { quantity, dof, given, found, rule })
            }
        };
        if let Some(sum) = &sum {
            let rule = "harmonics() must be the sum that force() gives, at all times and all q";
            same(sum.at(time), away, size(sum, time), rule)?;
        }
        if !drive.depends_on_coordinates(k) {
            same(here, away, 0.0, "depends_on_coordinates() says it is the same at all q")?;
        }
        if !drive.depends_on_own(k) {
            let rule = "depends_on_own() says it does not change with the q of its own degree of \
                freedom";
            same(own, away, 0.0, rule)?;
        }
    }
    Ok(())
}

/// 2π over the lowest frequency; none for a constant.
fn longest_period(sum: &Harmonics<f64>) -> Option<f64> {
    let periods = sum.terms.iter().map(|term| TAU / term.frequency.abs());
    periods.filter(|period| period.is_finite()).reduce(f64::max)
}

/// The size of the terms at t, and of their changes by a rounding of ωt.
fn size(sum: &Harmonics<f64>, t: f64) -> f64 {
    sum.terms.iter().fold(sum.constant.abs(), |size, term| {
        size + (term.cosine.abs() + term.sine.abs()) * (1.0 + (term.frequency * t).abs())
    })
}
