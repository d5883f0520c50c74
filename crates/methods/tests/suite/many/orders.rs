//! Global errors with several degrees of freedom.

use crate::many::{InSeries, errors, reference, start};
use crate::slope::slope;
use afterbay_core::{Grid, Scalar, State};
use afterbay_methods::registry::Run;
use std::ops::ControlFlow;

/// The largest errors of q, p and w over all points of a grid, against the Taylor series of the
/// same system (`series`).
fn global_errors<T: Scalar>(
    run: &Run<T>,
    series: &InSeries<T>,
    from: [&[f64]; 2],
    grid: Grid<T>,
) -> [f64; 3] {
    let exact = reference(series, from, grid.h, grid.steps as usize);
    let (mut state, mut worst) = (start(from), [0.0_f64; 3]);
    run.run(grid, &mut state, 1, &mut |n, at| {
        let [q, p, w] = [at.q, at.p, at.w].map(<[T]>::to_vec);
        let now = errors(&State { q, p, w, t: at.t }, &exact[n as usize]);
        worst.iter_mut().zip(now).for_each(|(worst, now)| *worst = worst.max(now));
        ControlFlow::Continue(())
    })
    .unwrap();
    worst
}

/// Checks that the largest errors of q, p and w over [0, end] fall with the order: `counts` are
/// numbers of steps.
pub(crate) fn check_orders<T: Scalar>(
    name: &str,
    (run, series): (&Run<T>, &InSeries<T>),
    from: [&[f64]; 2],
    (end, counts): (f64, [u64; 4]),
    (order, tolerance): (f64, f64),
) {
    let all = counts.map(|steps| {
        let h = T::from_f64(end) / T::from_f64(steps as f64);
        global_errors(run, series, from, Grid { h, steps })
    });
    let steps = counts.map(|count| end / count as f64);
    for (part, variable) in ["q", "p", "w"].into_iter().enumerate() {
        let found = slope(&steps, &all.map(|error| error[part]));
        println!("{name} {variable} {found:.3} {:?}", all.map(|error| error[part]));
        assert!(
            (found - order).abs() < tolerance,
            "{name} {variable}: {found:.3} of {order}, {all:?}"
        );
    }
}

/// The orders of q, p and w at the time of `exact`: the slopes of their largest errors there after
/// runs from t = 0 with these numbers of steps.
pub(crate) fn orders_at_end<T: Scalar>(
    exact: &State<Vec<T>>,
    counts: &[u64],
    run: &mut dyn FnMut(Grid<T>) -> State<Vec<T>>,
) -> [f64; 3] {
    let steps: Vec<f64> = counts.iter().map(|&count| exact.t.to_f64() / count as f64).collect();
    let all: Vec<[f64; 3]> = counts
        .iter()
        .map(|&steps| errors(&run(Grid { h: exact.t / T::from_f64(steps as f64), steps }), exact))
        .collect();
    [0, 1, 2].map(|part| slope(&steps, &all.iter().map(|error| error[part]).collect::<Vec<_>>()))
}
