//! The exact flow of the damped oscillator against a table of 31 digits, and against itself.

use afterbay_core::{ExactFlow, Quad, Scalar, Series, State, taylor::Expansion};
use afterbay_systems::DampedOscillator;
use num_dual::Dual64;
use proptest::prelude::*;

/// From `damped_oscillator.py` beside it.
const TABLE: &str = include_str!("../data/damped_oscillator.csv");

/// A line of the table: k, b, h, q, p and what the flow makes of it.
struct Row {
    given: [f64; 5],
    /// Δq, Δp, Δw, and the new q and p.
    exact: [Quad; 5],
    /// |M - I| |z| and |M| |z|, the larger of √k times the entry for q and the entry for p.
    sizes: [f64; 2],
}

fn table() -> Vec<Row> {
    let row = |line: &str| {
        let x: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        Row {
            given: std::array::from_fn(|i| x[i]),
            exact: std::array::from_fn(|i| Quad(x[5 + 2 * i], x[6 + 2 * i])),
            sizes: [(x[0].sqrt() * x[15]).max(x[16]), (x[0].sqrt() * x[17]).max(x[18])],
        }
    };
    TABLE.lines().skip(1).map(row).collect()
}

/// The largest error in units of what it is allowed to be: a few roundings of the sizes of the
/// table, plus one for every unit of the phase and of the exponent.
fn worst<T: Scalar>(lift: impl Fn(f64) -> T + Copy, low: impl Fn(T) -> f64) -> f64 {
    let mut worst = 0.0_f64;
    for Row { given, exact, sizes } in table() {
        let [k, b, h, q, p] = given;
        let system = DampedOscillator::new(k, b).unwrap().map(lift);
        let mut state = State::new([lift(q)], [lift(p)]).unwrap();
        system.flow(lift(h), &mut state);
        let [dq, dp, dw] = system.increment(lift(h), lift(q), lift(p));
        assert_eq!(state.w, [dw]);
        // Quadratic in z, so twice; and what H and w exchange in the time h, at the rate of the
        // slower decay.
        let twice_energy = (p * p + k * q * q).max(exact[4].0.powi(2) + k * exact[3].0.powi(2));
        let exchange =
            if b == 0.0 { 1.0 } else { b.abs().min(4.0 * k / b.abs()) * h.abs() * twice_energy };
        let size_w = 2.0 * (exact[2].0.abs() + exchange);
        let roundings = T::EPSILON * (4.0 + 2.0 * (k.sqrt() + b.abs()) * h.abs());
        let found = [dq, dp, dw, state.q[0], state.p[0]];
        let sizes = [sizes[0] / k.sqrt(), sizes[0], size_w, sizes[1] / k.sqrt(), sizes[1]];
        for ((found, exact), size) in found.into_iter().zip(exact).zip(sizes) {
            let error = Quad(found.to_f64(), low(found)).sub_accurate(exact).0.abs();
            assert!(
                error <= roundings * size,
                "{given:?}: {found:?} for {exact:?}, {:e}",
                error / size
            );
            worst = worst.max(error / (roundings * size));
        }
    }
    worst
}

#[test]
fn the_flow_agrees_with_the_table() {
    assert!(table().len() > 350);
    // Were the measure too generous, this would show it.
    assert!(worst(|x: f64| x, |_| 0.0) > 0.2);
    assert!(worst(Quad::from_f64, |x| x.1) > 0.05);
}

#[test]
fn without_damping_the_reservoir_stays_as_it_is() {
    let system = DampedOscillator::new(2.0, 0.0).unwrap();
    let mut state = State { w: [0.3], ..State::new([2.3], [-3.1]).unwrap() };
    system.flow(0.7, &mut state);
    assert_eq!((state.w, state.t), ([0.3], 0.7));
}

/// (Δq, Δp, Δw)' at h = 0 is the vector field, at the critical damping b = 2 too.
#[test]
fn it_starts_along_the_vector_field() {
    let (q, p) = (2.3, -3.1);
    for b in [-5.0, -2.0, 0.0, 0.1, 2.0, 2.0 + 1e-12, 200.0] {
        let system = DampedOscillator::new(1.0, b).unwrap().map(Dual64::from_f64);
        let increment = system.increment(Dual64::new(0.0, 1.0), q.into(), p.into());
        for (found, exact) in increment.into_iter().zip([p, -q - b * p, b * p * p]) {
            assert_eq!(found.re, 0.0);
            assert!(
                (found.eps - exact).abs() <= 1e-15 * b.abs().max(4.0) * 20.0,
                "{b}: {found} {exact}"
            );
        }
    }
}

proptest! {
    #[test]
    fn flows_compose(
        k in 0.1..4.0_f64, b in -4.0..4.0_f64, h1 in 0.0..2.0_f64, h2 in 0.0..2.0_f64, forth: bool,
        q in -3.0..3.0_f64, p in -3.0..3.0_f64,
    ) {
        let system = DampedOscillator::new(k, b).unwrap();
        let (h1, h2) = if forth { (h1, h2) } else { (-h1, -h2) };
        let start = State::new([q], [p]).unwrap();
        let (mut twice, mut once) = (start.clone(), start.clone());
        system.flow(h1, &mut twice);
        system.flow(h2, &mut twice);
        system.flow(h1 + h2, &mut once);
        // No state of this length grows faster; one that starts on the slower mode does not grow
        // like this.
        let size = q.hypot(p) * (-b * (h1 + h2)).exp().max(1.0);
        prop_assert!((twice.q[0] - once.q[0]).abs() < 2e-14 * size, "{twice:?} {once:?}");
        prop_assert!((twice.p[0] - once.p[0]).abs() < 2e-14 * size, "{twice:?} {once:?}");
        let energy = (1.0 + k) * size * size;
        prop_assert!((twice.w[0] - once.w[0]).abs() < 2e-14 * energy, "{twice:?} {once:?}");
        prop_assert!((once.total(&system) - start.total(&system)).abs() < 1e-14 * energy);
    }

    /// What ties the flow to the system it belongs to.
    #[test]
    fn the_flow_is_the_taylor_series(
        k in 0.1..4.0_f64, b in -5.0..5.0_f64, q in -3.0..3.0_f64, p in -3.0..3.0_f64,
    ) {
        let system = DampedOscillator::new(k, b).unwrap();
        let mut exact = State::new([q], [p]).unwrap();
        let series = Expansion::about(&system.map(Series::<f64, 12>::constant), &exact).at(0.01);
        system.flow(0.01, &mut exact);
        for (a, b) in [(exact.q, series.q), (exact.p, series.p), (exact.w, series.w)] {
            prop_assert!((a[0] - b[0]).abs() < 4e-15, "{exact:?} {series:?}");
        }
    }
}
