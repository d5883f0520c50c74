//! Defects of K that are rounding errors, which no projection reduces.

use crate::measured_rounding::measured_rounding;
use crate::rounding::rounding;
use crate::second_derivatives::second_order;
use afterbay_core::{Curvature, Scalar, StepFailure, Vector};

/// A failed projection may be due to rounding if the error of the step is below this share of the
/// allowed error; between 0 and 1. A choice.
pub(crate) const ROUNDING_SUSPECTED_BELOW: f64 = 0.01;
/// The largest defect that may be rounding, in roundings of H. A choice.
const ENERGY_DEFECT_ROUNDINGS: f64 = 16.0;

/// Whether H at the end (q, p) of a step differs from its target by no more than the rounding of
/// (q, p) causes, and a shorter step does not reduce the difference. Near an equilibrium away from
/// the origin no small change of (q, p) can correct it.
///
/// `energies` are H at the start, H at the end, and the target. `last_defect` is the difference
/// that a longer step from the same state left, and is replaced by that of this step.
///
/// # Errors
/// [`StepFailure::NotGradient`]
#[cold]
pub(crate) fn is_noise<V, S>(
    system: &S,
    [q, p]: [&V; 2],
    energies: [V::Scalar; 3],
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
    let within = |terms: f64| found <= ENERGY_DEFECT_ROUNDINGS * rounding::<V::Scalar>(terms);
    Ok((found > 0.5 * before && within(terms)) || within(measured_rounding(system, q, p)?))
}
