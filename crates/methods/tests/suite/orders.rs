//! The orders of every method in q, p and w on nonlinear damped problems, in f64 and in 31 digits.

use crate::bind::{linear, nonlinear};
use crate::slope;
use afterbay_core::taylor::{Expansion, trajectory};
use afterbay_core::{
    Curvature, Grid, InputError, Linear, Misprinted, OrderRaising, Quad, Scalar, Series, State,
    StateRef, System,
};
use afterbay_methods::registry::{FIXED, Needs, Number, Row, Run, find};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol};
use slope::slope;
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

const DUFFING: [f64; 3] = [1.0, 1.0, 0.3];
const MODIFIED_VAN_DER_POL: [f64; 3] = [0.4, 1.0, 1.0];
const OSCILLATOR: [f64; 2] = [1.3, 0.4];

fn duffing<T: Scalar>() -> Duffing<T> {
    let [alpha, beta, c] = DUFFING.map(T::from_f64);
    Duffing::new(alpha, beta, c).unwrap()
}

fn modified_van_der_pol<T: Scalar>() -> ModifiedVanDerPol<T> {
    let [mu, alpha, beta] = MODIFIED_VAN_DER_POL.map(T::from_f64);
    ModifiedVanDerPol::new(mu, alpha, beta).unwrap()
}

fn oscillator<T: Scalar>() -> DampedOscillator<T> {
    let [k, b] = OSCILLATOR.map(T::from_f64);
    DampedOscillator::new(k, b).unwrap()
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
fn local_errors<T, S>(system: &S, run: &Run<T>, steps: &[f64], point: (f64, f64)) -> Vec<[f64; 3]>
where
    T: Scalar,
    S: System<Series<T, 24>>,
{
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
        assert!(
            (found - f64::from(order)).abs() < TOLERANCE,
            "{}: {found:.3}, not {order}",
            row.name
        );
    }
}

/// For one degree of freedom a sweep equals its adjoint, so increments are tested with several
/// (increment.rs). Beyond order 4 the errors of these steps are below rounding (collocation.rs uses
/// longer ones).
fn rows() -> impl Iterator<Item = &'static Row> {
    FIXED.iter().filter(|row| !row.name.starts_with("increment") && row.order() <= 4)
}

/// Checks the local orders of every method that binds, at each point in 31 digits, and returns the
/// number of methods.
fn check_fine<S: System<Series<Quad, 24>>>(
    system: &S,
    bind: impl Fn(&Row) -> Bound<Quad>,
) -> usize {
    let bound = rows().filter_map(|row| Some((row, bind(row).ok()?)));
    bound
        .map(|(row, run)| {
            for point in POINTS {
                assert_orders(
                    row,
                    slopes(&FINE_STEPS, &local_errors(system, &run, &FINE_STEPS, point)),
                );
            }
        })
        .count()
}

/// Checks the orders in f64 for the root mean square over all points: at steps this large, a point
/// where the leading error term is small would show the next one.
fn check<S: System<Series<f64, 24>>>(system: &S, bind: impl Fn(&Row) -> Bound<f64>) -> usize {
    let bound = rows().filter_map(|row| Some((row, bind(row).ok()?)));
    bound
        .map(|(row, run)| {
            let mut squares = [[0.0; 3]; STEPS.len()];
            for point in POINTS {
                let errors = local_errors(system, &run, &STEPS, point);
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
    let count = check(&duffing(), |row| nonlinear(row, duffing()));
    assert_eq!(count, nonlinear_rows());
}

#[test]
fn local_orders_on_duffing_in_31_digits() {
    let count = check_fine(&duffing(), |row| nonlinear(row, duffing()));
    assert_eq!(count, nonlinear_rows());
}

#[test]
fn local_orders_on_modified_van_der_pol() {
    let bind = |row: &Row| nonlinear(row, modified_van_der_pol());
    assert_eq!(check(&modified_van_der_pol(), bind), nonlinear_rows());
}

#[test]
fn local_orders_on_modified_van_der_pol_in_31_digits() {
    let bind = |row: &Row| nonlinear(row, modified_van_der_pol());
    assert_eq!(check_fine(&modified_van_der_pol(), bind), nonlinear_rows());
}

/// Binds the oscillator, except to methods that are exact on it (locally_exact.rs).
fn bind_oscillator<T: Number>(row: &Row) -> Bound<T> {
    if row.name == "locally-exact" {
        return Err(InputError::Unsupported { method: row.name, why: "it has no error" });
    }
    linear(row, oscillator())
}

#[test]
fn local_orders_on_the_damped_oscillator() {
    assert_eq!(check(&oscillator(), bind_oscillator), rows().count() - 1);
}

#[test]
fn local_orders_on_the_damped_oscillator_in_31_digits() {
    assert_eq!(check_fine(&oscillator(), bind_oscillator), rows().count() - 1);
}

/// The slopes of the largest errors of q, p and w over [0, 2].
fn global_orders<T, S>(system: &S, run: &Run<T>) -> [f64; 3]
where
    T: Scalar,
    S: System<Series<T, 24>>,
{
    let counts = [50, 64, 80, 100, 128];
    let steps = counts.map(|count| 2.0 / f64::from(count));
    let errors: Vec<[f64; 3]> = counts
        .iter()
        .zip(steps)
        .map(|(&count, h)| {
            let exact =
                trajectory::<_, _, 24>(system, &start(POINTS[0]), T::from_f64(h), count as usize);
            let exact = exact.unwrap();
            let mut worst = [0.0_f64; 3];
            let mut show = |n: u64, state: StateRef<'_, T>| {
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
fn check_global<T, S>(system: &S, bind: impl Fn(&Row) -> Bound<T>)
where
    T: Scalar,
    S: System<Series<T, 24>>,
{
    for name in ["leapfrog", "rk4", "moddg", "moddg-fixed-point"] {
        let row = find(name).unwrap();
        assert_orders(row, global_orders(system, &bind(row).unwrap()));
    }
}

#[test]
fn global_orders_on_duffing() {
    check_global::<f64, _>(&duffing(), |row| nonlinear(row, duffing()));
}

#[test]
fn global_orders_on_modified_van_der_pol() {
    check_global::<f64, _>(&modified_van_der_pol(), |row| nonlinear(row, modified_van_der_pol()));
}

#[test]
fn points_are_away_from_the_poles() {
    fn far<S: OrderRaising<f64>>(system: &S) -> bool {
        POINTS.iter().all(|&(q, p)| {
            let force = system.partial(&[q], 0, q) + system.dissipation_of(&[q], &[p], 0).value;
            p.abs() > 0.5 && force.abs() > 0.5
        })
    }
    assert!(far(&duffing()) && far(&modified_van_der_pol()) && far(&oscillator()));
}

#[test]
fn printed_variants_are_refused_where_the_paper_prints_nothing() {
    fn refused<S: OrderRaising<f64> + Curvature<f64> + 'static>(row: &Row, system: S) {
        let Err(error) = nonlinear::<f64, S>(row, system) else { panic!("{} applies", row.name) };
        assert!(
            matches!(error, InputError::Unsupported { method, .. } if method == row.name),
            "{error}"
        );
    }
    fn taken<S: Misprinted<f64> + Linear<f64> + Curvature<f64> + 'static>(row: &Row, system: S) {
        assert!(linear::<f64, S>(row, system).is_ok());
    }
    let printed: Vec<&Row> = FIXED.iter().filter(|row| row.needs == Needs::Printed).collect();
    assert_eq!(printed.len(), 6);
    for row in printed {
        refused(row, duffing());
        refused(row, modified_van_der_pol());
        taken(row, oscillator());
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
    let run = nonlinear::<f64, _>(find("moddg").unwrap(), duffing()).unwrap();
    let found = slopes(&STEPS, &local_errors(&duffing(), &run, &STEPS, POINTS[1]));
    assert!(found.into_iter().all(|found| (found - 3.0).abs() > 9.0 * TOLERANCE), "{found:?}");
}
