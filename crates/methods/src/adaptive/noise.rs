//! Defects of K that are rounding errors, which no projection reduces.

use crate::kernels::reductions::sum;
use crate::measured_rounding::measured_rounding;
use crate::rounding::rounding;
use crate::second_derivatives::second_order;
use afterbay_core::{Curvature, Scalar, StepFailure, Vector};

/// A failed projection may be due to rounding if the error of the step is below this share of the
/// allowed error; between 0 and 1. A choice.
pub(crate) const ROUNDING_SUSPECTED_BELOW: f64 = 0.01;
/// The largest defect that may be rounding, in roundings of H. A choice.
const ENERGY_DEFECT_ROUNDINGS: f64 = 16.0;
/// The energy, as a share of w, at which the rounding of the terms of H is measured for a motion at
/// rest. A choice.
const MEASURED_SHARE: f64 = 1e-6;

/// Whether H at the end (q, p) of a step differs from its target by no more than the rounding of
/// (q, p) causes, and a shorter step does not reduce the difference. Near an equilibrium no small
/// change of (q, p) can correct it. The terms of H may cancel there ([`is_rounding_at_rest`]).
///
/// `energies` are H at the start, H at the end, and the target. `last_defect` is the difference
/// that a longer step from the same state left, and is replaced by that of this step.
///
/// # Errors
/// [`StepFailure::NotGradient`], unless the difference is a rounding at rest
#[cold]
pub(crate) fn is_noise<V, S>(
    system: &S,
    [q, p]: [&V; 2],
    energies: [V::Scalar; 3],
    w: &V,
    last_defect: &mut f64,
) -> Result<bool, StepFailure>
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    let (q, p, [start, end, target]) = (q.as_slice(), p.as_slice(), energies);
    let terms = start.abs().to_f64() + end.abs().to_f64() + second_order(system, q, p);
    let found = (end - target).abs().to_f64();
    let before = std::mem::replace(last_defect, found);
    let remains = found > 0.5 * before;
    if remains && is_rounding::<V::Scalar>(found, terms) {
        return Ok(true);
    }
    match measured_rounding(system, q, p) {
        Ok(measured) if is_rounding::<V::Scalar>(found, measured) => Ok(true),
        _ if is_rounding_at_rest(system, [q, p], w, found) => Ok(remains),
        measured => measured.map(|_| false),
    }
}

/// Whether a difference of energies near rest is a rounding of w, or of the terms of H.
///
/// The terms of exp(q) - q - 1 cancel near q = 0, and the sum has the rounding of the largest term.
/// If |q| is below this rounding, H does not change with q, and [`measured_rounding`] finds
/// nothing. The rounding is therefore measured at a multiple of z = (q, p), where H is larger and
/// its terms have nearly the same size.
pub(crate) fn is_rounding_at_rest<V: Vector, S: Curvature<V::Scalar> + ?Sized>(
    system: &S,
    z: [&[V::Scalar]; 2],
    w: &V,
    difference: f64,
) -> bool {
    let size = sum([w.as_slice()], |[w]| w.abs()).to_f64();
    if is_rounding::<V::Scalar>(difference, size) {
        return true;
    }
    let farther = (MEASURED_SHARE * size / second_order(system, z[0], z[1])).sqrt();
    if !(farther > 1.0 && farther.is_finite()) {
        return false;
    }
    let free = z[0].len() - system.motors();
    let [q, p] = z.map(|part| {
        let mut part = part.to_vec();
        part[..free].iter_mut().for_each(|x| *x *= V::Scalar::from_f64(farther));
        part
    });
    measured_rounding(system, &q, &p).is_ok_and(|terms| is_rounding::<V::Scalar>(difference, terms))
}

fn is_rounding<T: Scalar>(difference: f64, terms: f64) -> bool {
    difference <= ENERGY_DEFECT_ROUNDINGS * rounding::<T>(terms)
}
