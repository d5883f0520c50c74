//! The equation of a kick that is implicit in the momentum.

use afterbay_core::solver::{Newton, Sample, Solver};
use afterbay_core::{Scalar, Separable, StepFailure};

/// The momentum that a kick ends in, and the force of friction there.
pub(crate) struct Kicked<T> {
    pub(crate) p: T,
    pub(crate) drag: T,
    pub(crate) iterations: u64,
}

/// Solves p½ + s D_j(q, p½) = `kicked` for one degree of freedom, where p½ is entry j of `momenta`
/// and D is without the force of a drive.
#[inline(always)]
pub(crate) fn kick<T: Scalar, S: Separable<T> + ?Sized>(
    system: &S,
    q: &[T],
    momenta: &mut [T],
    j: usize,
    kicked: T,
    s: T,
) -> Result<Kicked<T>, StepFailure> {
    let root = Newton.solve(j, kicked, |scale, p| {
        momenta[j] = p;
        let drag = system.friction_of(q, momenta, j);
        Sample {
            value: scale * s * drag.value,
            slope: scale * s * drag.by_p,
            argument_rounding: T::zero(),
            value_rounding: T::zero(),
        }
    })?;
    momenta[j] = root.x;
    let drag = system.friction_of(q, momenta, j).value;
    Ok(Kicked { p: root.x, drag, iterations: u64::from(root.evaluations) })
}
