//! References: what the runs of a study are compared to.
//!
//! Taylor series in 106 bits where there are few degrees of freedom, and in 53 where there are more
//! ([`crate::series`]); where these end at a kink, or would take too many strides, the two runs of
//! established methods that agree best. Each comes with a doubt.

mod runs;

use super::Problem;
use crate::Solution;
use crate::progress::Progress;
use crate::series;
use afterbay_core::{InputError, IntegrateError, Quad};
use afterbay_systems::catalog::Expandable;

/// With no more degrees of freedom than this a reference comes from Taylor series in 106 bits,
/// whose cost grows with N; with more, from series in `f64`.
pub const LARGEST_BY_SERIES: usize = 16;

/// Series that may take no more strides than this are not begun.
const FEWEST: usize = 64;

/// The reference at the times `i h`, i = 0..=count.
pub(super) fn reference(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    if problem.model.dof() <= LARGEST_BY_SERIES {
        let found = by_series::<Quad>(problem, h, count, progress);
        if let Some(found) = last_word(problem, found)? {
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

/// What series found, unless another way may do better: where they take too many strides, and where
/// they end at a kink.
fn last_word<T>(
    problem: &Problem,
    found: Result<Solution<T>, IntegrateError>,
) -> Result<Option<Solution<T>>, IntegrateError> {
    match found {
        Err(IntegrateError::Input(InputError::Budget { .. })) => Ok(None),
        Err(IntegrateError::Input(InputError::SolutionEnds { .. })) if has_kinks(problem)? => {
            Ok(None)
        }
        found => found.map(Some),
    }
}

fn has_kinks(problem: &Problem) -> Result<bool, IntegrateError> {
    let (system, start) = (problem.model.system::<f64>()?, problem.start::<f64>()?);
    let mut kinks = 0;
    system.kinks(&start.q, &start.p, &mut |_| kinks += 1);
    Ok(kinks > 0)
}
