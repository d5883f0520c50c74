//! Global errors with several degrees of freedom.

use crate::many::{errors, reference, start};
use crate::slope::slope;
use afterbay_core::{Grid, Method, Scalar, Series, State, System, integrate};

/// The largest errors of q, p and w over all points of a grid, against the Taylor series of the
/// same system (`series`).
fn global_errors<T, S, M>(
    method: &M,
    system: &S,
    series: &dyn System<Series<T, 24>>,
    from: [&[f64]; 2],
    grid: Grid<T>,
) -> [f64; 3]
where
    T: Scalar,
    S: System<T> + ?Sized,
    M: Method<Vec<T>, S>,
{
    let exact = reference(series, from, grid.h, grid.steps as usize);
    let (mut state, mut worst) = (start(from), [0.0_f64; 3]);
    let mut look = |n: u64, state: &State<Vec<T>>| {
        let now = errors(state, &exact[n as usize]);
        worst.iter_mut().zip(now).for_each(|(worst, now)| *worst = worst.max(now));
        std::ops::ControlFlow::Continue(())
    };
    integrate(method, system, grid, &mut state, &mut look).unwrap();
    worst
}

/// Checks that the largest errors of q, p and w over [0, end] fall with the order: `counts` are
/// numbers of steps.
pub(crate) fn check_orders<T, S, M>(
    name: &str,
    method: &M,
    (system, series): (&S, &dyn System<Series<T, 24>>),
    from: [&[f64]; 2],
    (end, counts): (f64, [u64; 4]),
    (order, tolerance): (f64, f64),
) where
    T: Scalar,
    S: System<T> + ?Sized,
    M: Method<Vec<T>, S>,
{
    let all = counts.map(|steps| {
        let h = T::from_f64(end) / T::from_f64(steps as f64);
        global_errors(method, system, series, from, Grid { h, steps })
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
