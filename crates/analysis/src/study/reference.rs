//! References with which the runs of a study are compared.
//!
//! A reference comes from Taylor series ([`crate::series`]), in 106 bits for few degrees of freedom
//! and in 53 bits for more. Where series end at a kink or would take too many strides, as on a
//! stiff system, it is the exact flow of a linear system of few degrees of freedom, else one of the
//! two runs of established methods that agree best. Each reference has a doubt.

mod exact;
mod runs;

use super::{Problem, method};
use crate::Solution;
use crate::progress::Progress;
use crate::series;
use afterbay_core::{InputError, IntegrateError, Quad, State, StateRef, Tolerance};
use afterbay_methods::registry::Setting;
use afterbay_systems::catalog::Expandable;

/// The largest number of degrees of freedom for which a reference comes from Taylor series in 106
/// bits, whose cost grows with N. Larger systems use series in `f64`.
pub const MOST_DEGREES_IN_QUAD: usize = 16;

/// The least number of strides for which a series is tried.
const FEWEST: usize = 64;

/// The tolerance of the run that shows whether a motion ends at a kink or becomes infinite, and its
/// end, as a multiple of the time at which the series end.
const TOLERANCE: f64 = 1e-10;
const BEYOND: f64 = 1.001;
/// The growth of q or p from which a motion that ends becomes infinite. A choice: the momentum of a
/// fall into -1/r grows by 1e4 until the steps are roundings of t.
const UNBOUNDED: f64 = 100.0;

/// The reference at the times `i h`, i = 0..=count.
pub(super) fn reference(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    if problem.model.dof() <= MOST_DEGREES_IN_QUAD {
        let found = by_series::<Quad>(problem, h, count, progress);
        if let Some(found) = last_word(problem, found, progress)? {
            return Ok(found.rounded());
        }
        if let Some(found) = exact::by_exact_flow(problem, h, count, progress)? {
            return Ok(found.rounded());
        }
    }
    if series::most_strides::<f64>(problem.model.dof()) >= FEWEST {
        let found = by_series::<f64>(problem, h, count, progress);
        if let Some(found) = last_word(problem, found, progress)? {
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
/// strides or ends at a kink that the motion passes.
fn last_word<T>(
    problem: &Problem,
    found: Result<Solution<T>, IntegrateError>,
    progress: &dyn Progress,
) -> Result<Option<Solution<T>>, IntegrateError> {
    match found {
        Err(IntegrateError::Input(InputError::Budget { .. })) => Ok(None),
        Err(IntegrateError::Input(InputError::SolutionEnds { t }))
            if problem.has_kinks()? && !is_unbounded(problem, t, progress)? =>
        {
            Ok(None)
        }
        found => found.map(Some),
    }
}

/// Whether the motion becomes infinite at t, where its series end, as at the centre of a potential
/// such as -1/sqrt(q1^2 + q2^2), whose root is a kink. A method that passes kinks then ends there
/// too, and a coordinate or momentum has grown by [`UNBOUNDED`] since t/2. One that grows more
/// slowly, as log r at a centre lets p, is not seen.
fn is_unbounded(
    problem: &Problem,
    t: f64,
    progress: &dyn Progress,
) -> Result<bool, IntegrateError> {
    let run = problem.model.bind(method("adaptive-verner98")?)?;
    let (mut state, free): (State<Vec<f64>>, _) = (problem.start()?, problem.model.degrees());
    let (mut before, mut last) = (vec![0.0_f64; 2 * free], vec![0.0; 2 * free]);
    let mut see = |_: u64, state: StateRef<'_, f64>| {
        let entries = state.q[..free].iter().chain(&state.p[..free]);
        last.iter_mut().zip(entries).for_each(|(last, z)| *last = z.abs());
        if state.t <= 0.5 * t {
            before.iter_mut().zip(&last).for_each(|(most, &last)| *most = most.max(last));
        }
        progress.flow()
    };
    let setting = Setting::Tolerance(Tolerance::all(TOLERANCE), t * BEYOND);
    let ends = matches!(run.run(setting, &mut state, 1, &mut see), Err(IntegrateError::Run(_)));
    let mut grown = last.iter().zip(&before);
    Ok(ends && grown.any(|(&last, &before)| before > 0.0 && last > UNBOUNDED * before))
}
