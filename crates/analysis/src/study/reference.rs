//! References with which the runs of a study are compared.
//!
//! A reference comes from Taylor series ([`crate::series`]), in 106 bits for few degrees of freedom
//! and in 53 bits for more. Where series end at a kink or would take too many strides, as on a
//! stiff system, it is the exact flow of a linear system of few degrees of freedom, else one of the
//! two runs of established methods that agree best. Each reference has a doubt.

mod exact;
mod runs;

use super::Problem;
use crate::Solution;
use crate::progress::Progress;
use crate::series;
use afterbay_core::{InputError, IntegrateError, Quad};
use afterbay_systems::catalog::Expandable;

/// The largest number of degrees of freedom for which a reference comes from Taylor series in 106
/// bits, whose cost grows with N. Larger systems use series in `f64`.
pub const MOST_DEGREES_IN_QUAD: usize = 16;

/// The least number of strides for which a series is tried.
const FEWEST: usize = 64;

/// The reference at the times `i h`, i = 0..=count.
pub(super) fn reference(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    if problem.model.dof() <= MOST_DEGREES_IN_QUAD {
        let found = by_series::<Quad>(problem, h, count, progress);
        if let Some(found) = last_word(problem, found)? {
            return Ok(found.rounded());
        }
        if let Some(found) = exact::by_exact_flow(problem, h, count, progress)? {
            return Ok(found.rounded());
        }
    }
    if series::most_strides::<f64>(problem.model.dof()) >= FEWEST {
        let found = by_series::<f64>(problem, h, count, progress);
        if let Some(found) = last_word(problem, found)? {
            return Ok(found);
        }
    }
    runs::by_runs(problem, h, count, progress)
}

fn by_series<T: Expandable>(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<T>, IntegrateError> {
    problem.model.solution(&problem.start()?, T::from_f64(h), count, progress)
}

/// The result of a series, unless another method may do better because the series takes too many
/// strides or ends at a kink.
fn last_word<T>(
    problem: &Problem,
    found: Result<Solution<T>, IntegrateError>,
) -> Result<Option<Solution<T>>, IntegrateError> {
    match found {
        Err(IntegrateError::Input(InputError::Budget { .. })) => Ok(None),
        Err(IntegrateError::Input(InputError::SolutionEnds { .. })) if problem.has_kinks()? => {
            Ok(None)
        }
        found => found.map(Some),
    }
}
