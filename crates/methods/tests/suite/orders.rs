//! The orders of every method in q, p and w on nonlinear damped problems, in f64 and in 31 digits.

use crate::catalog::{self, As, Both, Built};
use crate::many::InSeries;
use crate::slope::slope;
use afterbay_core::taylor::{Expansion, trajectory};
use afterbay_core::{Grid, InputError, Quad, Scalar, State, StateRef};
use afterbay_methods::registry::{FIXED, Needs, Order, Row, Run, find};
use std::ops::ControlFlow;

/// The largest difference between a slope and the order.
const TOLERANCE: f64 = 0.1;

/// Steps in f64, at which even local errors of order 4 exceed their rounding, 1e-16/h, by two
/// digits.
const STEPS: [f64; 5] = [0.008, 0.01, 0.012, 0.016, 0.02];
/// Steps in 31 digits, at which higher-order terms are negligible.
const FINE_STEPS: [f64; 5] = [0.0004, 0.0006, 0.0009, 0.0013, 0.002];

/// Base points, away from the poles p = 0 and V' + D = 0 of every problem below.
const POINTS: [(f64, f64); 3] = [(1.1, 0.9), (-0.7, -1.3), (0.8, 1.6)];

fn duffing() -> Built {
    catalog::duffing(1.0, 1.0, 0.3)
}

fn modified_van_der_pol() -> Built {
    catalog::modified_van_der_pol(0.4, 1.0, 1.0)
}

fn oscillator() -> Built {
    catalog::oscillator(1.3, 0.4)
}

type Bound<T> = Result<Run<T>, InputError>;

fn start<T: Scalar>((q, p): (f64, f64)) -> State<[T; 1]> {
    State::new([T::from_f64(q)], [T::from_f64(p)]).unwrap()
}

/// |q|, |p| and |w| of the difference of two states.
fn distance<T: Scalar>(a: StateRef<'_, T>, b: StateRef<'_, T>) -> [f64; 3] {
    [a.q[0] - b.q[0], a.p[0] - b.p[0], a.w[0] - b.w[0]].map(|x| x.to_f64().abs())
}

/// The local errors (x(t + h) - x1)/h of q, p and w at one point.
fn local_errors<T: Scalar>(
    system: &InSeries<T>,
    run: &Run<T>,
    steps: &[f64],
    point: (f64, f64),
) -> Vec<[f64; 3]> {
    let exact = Expansion::<[T; 1], 24>::about(system, &start(point));
    let error = |&h: &f64| {
        let mut state = start(point);
        run.step(T::from_f64(h), &mut state).unwrap();
        distance(exact.at(T::from_f64(h)).state_ref(), state.state_ref()).map(|error| error / h)
    };
    steps.iter().map(error).collect()
}

/// The slope of each variable's errors.
fn slopes(steps: &[f64], errors: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|variable| {
        slope(steps, &errors.iter().map(|error| error[variable]).collect::<Vec<_>>())
    })
}

fn assert_orders(row: &Row, found: [f64; 3]) {
    println!("{:26} {found:.3?}", row.name);
    for (found, order) in found.into_iter().zip(row.local_order) {
        let number = f64::from(order.number().expect("not exact"));
        assert!((found - number).abs() < TOLERANCE, "{}: {found:.3}, not {order}", row.name);
    }
}

/// For one degree of freedom a sweep equals its adjoint, so increments are tested with several
/// (increment.rs). Beyond order 4 the errors of these steps are below rounding (collocation.rs uses
/// longer ones).
fn rows() -> impl Iterator<Item = &'static Row> {
    FIXED.iter().filter(|row| !row.name.starts_with("increment") && row.order() <= Order::Of(4))
}

/// Binds a system, except a linear one to a method that is exact on it (locally_exact.rs).
fn bind<T: Both>(system: &Built, row: &'static Row, form: As) -> Bound<T> {
    if row.name == "locally-exact" && form == As::Linear {
        return Err(InputError::Unsupported { method: row.name, why: "it has no error" });
    }
    system.bind(row, form)
}

/// Checks the local orders of every method that binds, at each point in 31 digits, and returns the
/// number of methods.
fn check_fine(system: &Built, form: As) -> usize {
    let series = system.series::<Quad>();
    let bound = rows().filter_map(|row| Some((row, bind(system, row, form).ok()?)));
    bound
        .map(|(row, run)| {
            for point in POINTS {
                assert_orders(
                    row,
                    slopes(&FINE_STEPS, &local_errors(&*series, &run, &FINE_STEPS, point)),
                );
            }
        })
        .count()
}

/// Checks the orders in f64 for the root mean square over all points: at steps this large, a point
/// where the leading error term is small would show the next one.
fn check(system: &Built, form: As) -> usize {
    let series = system.series::<f64>();
    let bound = rows().filter_map(|row| Some((row, bind(system, row, form).ok()?)));
    bound
        .map(|(row, run)| {
            let mut squares = [[0.0; 3]; STEPS.len()];
            for point in POINTS {
                let errors = local_errors(&*series, &run, &STEPS, point);
                for (sum, error) in squares.iter_mut().flatten().zip(errors.into_iter().flatten()) {
                    *sum += error * error;
                }
            }
            assert_orders(row, slopes(&STEPS, &squares.map(|sums| sums.map(f64::sqrt))));
        })
        .count()
}

fn nonlinear_rows() -> usize {
    rows().filter(|row| row.needs != Needs::Printed).count()
}

#[test]
fn local_orders_on_duffing() {
    let count = check(&duffing(), As::Nonlinear);
    assert_eq!(count, nonlinear_rows());
}

#[test]
fn local_orders_on_duffing_in_31_digits() {
    let count = check_fine(&duffing(), As::Nonlinear);
    assert_eq!(count, nonlinear_rows());
}

#[test]
fn local_orders_on_modified_van_der_pol() {
    assert_eq!(check(&modified_van_der_pol(), As::Nonlinear), nonlinear_rows());
}

#[test]
fn local_orders_on_modified_van_der_pol_in_31_digits() {
    assert_eq!(check_fine(&modified_van_der_pol(), As::Nonlinear), nonlinear_rows());
}

#[test]
fn local_orders_on_the_damped_oscillator() {
    assert_eq!(check(&oscillator(), As::Linear), rows().count() - 1);
}

#[test]
fn local_orders_on_the_damped_oscillator_in_31_digits() {
    assert_eq!(check_fine(&oscillator(), As::Linear), rows().count() - 1);
}

/// The slopes of the largest errors of q, p and w over [0, 2].
fn global_orders(system: &InSeries<f64>, run: &Run<f64>) -> [f64; 3] {
    let counts = [50, 64, 80, 100, 128];
    let steps = counts.map(|count| 2.0 / f64::from(count));
    let errors: Vec<[f64; 3]> = counts
        .iter()
        .zip(steps)
        .map(|(&count, h)| {
            let exact = trajectory(system, &start(POINTS[0]), h, count as usize).unwrap();
            let mut worst = [0.0_f64; 3];
            let mut show = |n: u64, state: StateRef<'_, f64>| {
                let now = distance(exact[n as usize].state_ref(), state);
                worst.iter_mut().zip(now).for_each(|(worst, now)| *worst = worst.max(now));
                ControlFlow::Continue(())
            };
            run.run(
                Grid::of(h, u64::from(count as u32)).unwrap(),
                &mut start(POINTS[0]),
                1,
                &mut show,
            )
            .unwrap();
            worst
        })
        .collect();
    slopes(&steps, &errors)
}

/// Checks the global orders of the methods with the same order in q, p and w.
fn check_global(system: &Built) {
    for name in ["leapfrog", "rk4", "moddg", "moddg-fixed-point"] {
        let row = find(name).unwrap();
        let run = system.bind(row, As::Nonlinear).unwrap();
        assert_orders(row, global_orders(&*system.series(), &run));
    }
}

#[test]
fn global_orders_on_duffing() {
    check_global(&duffing());
}

#[test]
fn global_orders_on_modified_van_der_pol() {
    check_global(&modified_van_der_pol());
}

#[test]
fn points_are_away_from_the_poles() {
    let far = |system: Built| {
        let system = system.separable::<f64>();
        POINTS.iter().all(|&(q, p)| {
            let force = system.partial(&[q], 0, q) + system.dissipation_of(&[q], &[p], 0).value;
            p.abs() > 0.5 && force.abs() > 0.5
        })
    };
    assert!(far(duffing()) && far(modified_van_der_pol()) && far(oscillator()));
}

#[test]
fn printed_variants_are_refused_where_the_paper_prints_nothing() {
    let refused = |row: &Row, system: Built| {
        let found = system.bind::<f64>(row, As::Nonlinear);
        let Err(error) = found else { panic!("{} applies", row.name) };
        assert!(
            matches!(error, InputError::Unsupported { method, .. } if method == row.name),
            "{error}"
        );
    };
    let printed: Vec<&Row> = FIXED.iter().filter(|row| row.needs == Needs::Printed).collect();
    assert_eq!(printed.len(), 6);
    for row in printed {
        refused(row, duffing());
        refused(row, modified_van_der_pol());
        assert!(oscillator().bind::<f64>(row, As::Linear).is_ok());
    }
}

#[test]
fn an_order_claimed_wrong_by_one_is_seen() {
    for order in 1..=6 {
        let errors = STEPS.map(|h| 3.0 * h.powi(order) * (1.0 + 0.5 * h));
        let found = slope(&STEPS, &errors);
        assert!((found - f64::from(order)).abs() < TOLERANCE);
        assert!((found - f64::from(order - 1)).abs() > 9.0 * TOLERANCE);
        assert!((found - f64::from(order + 1)).abs() > 9.0 * TOLERANCE);
    }
    // moddg has order 2 and no other; an error of h³ instead of h² would be detected.
    let run = duffing().bind::<f64>(find("moddg").unwrap(), As::Nonlinear).unwrap();
    let found = slopes(&STEPS, &local_errors(&*duffing().series(), &run, &STEPS, POINTS[1]));
    assert!(found.into_iter().all(|found| (found - 3.0).abs() > 9.0 * TOLERANCE), "{found:?}");
}
