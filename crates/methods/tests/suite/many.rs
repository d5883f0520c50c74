//! States with several degrees of freedom, their reference solution, and their distance.

pub(crate) mod orders;

use afterbay_core::taylor::trajectory;
use afterbay_core::{Scalar, Series, State, System};

/// A system in power series.
pub(crate) type InSeries<T> = dyn System<Series<T, 24>>;

/// The state (q, p), in any scalar.
pub(crate) fn start<T: Scalar>([q, p]: [&[f64]; 2]) -> State<Vec<T>> {
    let lift = |x: &[f64]| x.iter().map(|&x| T::from_f64(x)).collect();
    State::new(lift(q), lift(p)).unwrap()
}

/// The largest error of q, p and w.
pub(crate) fn errors<T: Scalar>(state: &State<Vec<T>>, exact: &State<Vec<T>>) -> [f64; 3] {
    let parts = [(&state.q, &exact.q), (&state.p, &exact.p), (&state.w, &exact.w)];
    parts.map(|(found, exact)| {
        found.iter().zip(exact).fold(0.0, |most: f64, (&a, &b)| most.max((a - b).abs().to_f64()))
    })
}

/// The solution at i h, i = 0..=count, by the Taylor series of the system.
pub(crate) fn reference<T: Scalar>(
    series: &InSeries<T>,
    from: [&[f64]; 2],
    h: T,
    count: usize,
) -> Vec<State<Vec<T>>> {
    trajectory(series, &start(from), h, count).unwrap()
}

/// The solution at t = `end` from a state at t = 0, by the Taylor series of the system.
pub(crate) fn exact_end<T: Scalar>(
    series: &InSeries<T>,
    from: &State<Vec<T>>,
    end: f64,
) -> State<Vec<T>> {
    trajectory(series, from, T::from_f64(end), 1).unwrap().pop().unwrap()
}
