//! Solutions by Taylor series, each followed twice.
//!
//! The defect of every stride is enclosed, so that no feature is missed. A second run takes other
//! strides and is moved at each by as much as one of the first may err; how far the two come apart is
//! what errors and roundings grow to, in chaos as well, and with a margin it is the doubt.

use crate::Solution;
use crate::measured::Doubt;
use crate::progress::Progress;
use crate::solution::twice_apart;
use afterbay_core::taylor::{Enclosed, Pace, enclosing, follow};
use afterbay_core::{InputError, IntegrateError, Interval, Scalar, Series, State, System, Vector};

/// Terms of the series.
pub(crate) const TERMS: usize = 24;

/// Series of intervals, in which the defect is enclosed.
pub(crate) type Ranges = Series<Interval, TERMS>;

/// A parameter of a system as a range.
pub(crate) fn range<T: Scalar>(x: T) -> Ranges {
    Series::constant(enclosing(x))
}

/// The runs are compared at this many times at least: at one of them they may meet by chance.
const COMPARED: usize = 256;

/// The most strides of a run, times the number of degrees of freedom: half a minute or so.
pub(crate) fn most_strides<T: Scalar>(dof: usize) -> usize {
    let most = if T::EPSILON < 1e-20 { 20_000 } else { 100_000 };
    most / dof.max(1)
}

/// The solution by series at the times `i h`, i = 0..=count, its states stored in `V` on the way.
pub(crate) fn by_series<V, S, R>(
    (system, ranges): (&S, R),
    start: &State<Vec<V::Scalar>>,
    h: V::Scalar,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<V::Scalar>, IntegrateError>
where
    V: Vector,
    S: System<Series<V::Scalar, TERMS>>,
    R: System<Ranges>,
{
    let dof = system.dof();
    let start = stored::<V>(start, dof)?;
    let defect = Enclosed::new(ranges);
    let between = COMPARED.div_ceil(count.max(1));
    let fine = (h / V::Scalar::from_f64(between as f64), count * between);
    let run = |pace: Pace| -> Result<Option<Vec<State<V>>>, InputError> {
        let mut states = Vec::with_capacity(fine.1 + 1);
        let pace = pace.within(most_strides::<V::Scalar>(dof));
        let mut see = |_, state| states.push(state);
        let route = follow((system, &defect), &start, fine, pace, &|| progress.stopped(), &mut see)?;
        Ok((!route.interrupted).then_some(states))
    };
    let (states, check) = rayon::join(|| run(Pace::FULL), || run(Pace::CHECK));
    let (Some(states), Some(check)) = (states?, check?) else { return Err(IntegrateError::Interrupted) };
    let mut solution = Solution::with_room(dof, count + 1);
    let mut doubt = Doubt::default();
    for (i, (state, check)) in states.iter().zip(&check).enumerate() {
        doubt = doubt.larger(twice_apart(state, check));
        if i % between == 0 {
            solution.push(state.state_ref());
            solution.doubt_last(doubt);
        }
    }
    Ok(solution)
}

/// The same state in another storage.
pub(crate) fn stored<V: Vector>(state: &State<Vec<V::Scalar>>, dof: usize) -> Result<State<V>, InputError> {
    state.check(dof)?;
    let copy = |part: &Vec<V::Scalar>| V::filled(part, |x| x);
    Ok(State { q: copy(&state.q), p: copy(&state.p), w: copy(&state.w), t: state.t })
}
