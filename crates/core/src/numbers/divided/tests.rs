//! Divided differences beside 700 digits, in f64, lanes and 106 bits.

use super::*;
use crate::numbers::{Line, Scalar};
use qd::Quad;
use wide::f64x8;

/// Edges with 30 digits of the divided differences, from `divided.py` beside it.
const TABLE: &str = include_str!("../../../tests/data/divided.csv");

fn divided<T: Scalar>(name: &str, a: T, b: T) -> Line<T> {
    match name {
        "sin" => sin(a, b),
        "cos" => cos(a, b),
        "exp" => exp(a, b),
        "sinh" => sinh(a, b),
        "cosh" => cosh(a, b),
        "tanh" => tanh(a, b),
        "ln" => ln(a, b),
        "sqrt" => sqrt(a.sqrt(), b.sqrt()),
        "atan" => atan(a, b),
        "asin" => asin(a, b),
        "acos" => acos(a, b),
        "abs" => abs(a, b),
        _ => panic!("no function called {name}"),
    }
}

/// Name, a, b, and the divided difference as two numbers.
fn table() -> impl Iterator<Item = (&'static str, [f64; 2], Quad)> {
    TABLE.lines().skip(1).map(|line| {
        let (name, numbers) = line.split_once(',').unwrap();
        let numbers: Vec<f64> = numbers.split(',').map(|x| x.parse().unwrap()).collect();
        let &[a, b, high, low] = numbers.as_slice() else { panic!("four numbers in {line}") };
        (name, [a, b], Quad(high, low))
    })
}

#[test]
fn values_agree_with_the_table() {
    let mut points = std::collections::BTreeMap::new();
    for (name, [a, b], exact) in table() {
        let size = exact.0.abs().max(f64::MIN_POSITIVE);
        let off = |found: f64| ((found - exact.0) - exact.1).abs() / size;
        let found = divided(name, a, b).value;
        assert!(off(found) < 5.0 * f64::EPSILON, "{name}[{a:e}, {b:e}]: {found:e} {exact:?}");
        let lanes = divided(name, f64x8::splat(a), f64x8::splat(b)).value.to_array()[5];
        assert!(off(lanes) < 5.0 * f64::EPSILON, "{name}[{a:e}, {b:e}] in lanes: {lanes:e}");
        *points.entry(name).or_insert(0) += 1;
        // Below, the low parts underflow.
        if [a, b].iter().any(|x| x.abs() < 1e-200 && *x != 0.0) || exact.0.abs() < 1e-200 {
            continue;
        }
        let quad = divided(name, Quad::from_f64(a), Quad::from_f64(b)).value;
        let error = quad.sub_accurate(exact).0.abs() / size;
        assert!(error < 1e-30, "{name}[{a:e}, {b:e}] in 106 bits: {error:e}");
    }
    assert!(points.len() == 12 && points.values().all(|&count| count > 60), "{points:?}");
}

#[test]
fn derivatives_are_those_of_the_values() {
    for (name, [a, b], _) in table() {
        let line = divided(name, a, b);
        // Beside kinks and poles a difference of this step says nothing.
        let (step, kink) = (1e-5 * (1.0 + b.abs().min(3.0)), name == "abs" && b.abs() < 0.1);
        let edge = matches!(name, "ln" | "sqrt") && b < 0.01
            || matches!(name, "asin" | "acos") && b.abs() > 0.9
            || a.abs().max(b.abs()) > 300.0;
        if kink || edge || !(1e-3..1e12).contains(&line.value.abs()) {
            continue;
        }
        let at = |x: f64| divided(name, a, x).value;
        let slope = (at(b + step) - at(b - step)) / (2.0 * step);
        let size = slope.abs() + line.value.abs();
        assert!((line.slope - slope).abs() < 1e-4 * size, "{name}[{a}, {b}]: {line:?} {slope}");
    }
}

#[test]
fn what_has_no_value_is_no_number() {
    for (a, b) in [(-1.0, 2.0), (2.0, -1.0), (-3.0, -2.0), (0.0, 1.0), (-1.0, -1.0)] {
        assert!(!ln(a, b).value.is_finite(), "{a} {b}");
    }
    assert!(asin(0.5, 1.5).value.is_nan() && !sqrt(0.0_f64, 0.0).value.is_finite());
}
