//! Operations on series cancel, are those of Taylor, and keep count of known terms.

use super::*;

const X: Series<f64, 8> = Series::new([0.7, -1.3, 0.4, 2.0, -0.6, 0.1, 0.9, -0.2]);

fn assert_close(a: Series<f64, 8>, b: Series<f64, 8>) {
    for k in 0..8 {
        assert!(
            (a.c[k] - b.c[k]).abs() < 1e-11 * (1.0 + b.c[k].abs()),
            "coefficient {k}: {a:?} {b:?}"
        );
    }
}

#[test]
fn a_constant_is_a_factor_of_each_term() {
    let [mut nearly, mut lacking] = [Series::constant(3.0), Series::constant(0.0)];
    (nearly.c[7], lacking.c[2]) = (1e-300, 5.0);
    for other in [Series::constant(3.0), nearly, lacking] {
        let full = std::array::from_fn(|k| (0..=k).map(|i| X.c[i] * other.c[k - i]).sum());
        assert_close(X * other, Series::new(full));
        assert_close(other * X, Series::new(full));
    }
    assert_eq!((X * Series::constant(3.0)).c, X.c.map(|c| 3.0 * c));
}

/// Sums in the order of the definition, each term with one rounding.
#[test]
fn products_and_quotients_are_those_of_the_definition_to_the_bit() {
    let mut short = Series { known: 6, ..X };
    short.c[4..].fill(0.0);
    short.c[1] = 0.0;
    let y = Series::new(X.c.map(f64::exp));
    for (x, y) in [(X, y), (short, y), (y, short), (X, short)] {
        let (product, quotient) = (x * y, x / y);
        for k in 0..x.known.min(y.known) {
            let sum = |a: &[f64], from: usize, to: usize| {
                (from..to).fold(0.0, |sum, i| a[i].mul_add(y.c[k - i], sum))
            };
            assert_eq!(product.c[k], sum(&x.c, 0, k + 1), "{k}");
            assert_eq!(quotient.c[k], (x.c[k] - sum(&quotient.c, 0, k)) / y.c[0], "{k}");
        }
    }
}

#[test]
fn inverse_operations_cancel() {
    let y = X * X + Series::from_f64(2.0);
    assert_close(X * y / y, X);
    assert_close(y.sqrt() * y.sqrt(), y);
    assert_close(X.exp() * (-X).exp(), Series::one());
    assert_close(X.exp_m1() + Series::one(), X.exp());
    let (sin, cos) = X.sin_cos();
    assert_close(sin * sin + cos * cos, Series::one());
    assert_close((X + X).sin_cos().0, (sin * cos) * Series::from_f64(2.0));
    assert_close(X.exp().ln(), X);
    assert_close((sin / cos).atan(), X);
}

#[test]
fn what_is_known_of_the_operands_is_known_of_the_result() {
    type Operation = fn(Series<f64, 8>, Series<f64, 8>) -> Series<f64, 8>;
    let operations: [Operation; 17] = [
        |x, y| x + y,
        |x, y| x - y,
        |x, y| x * y,
        |x, y| y * x,
        |x, y| x / y,
        |x, _| -x,
        |x, _| x.sqrt(),
        |x, _| x.exp(),
        |x, _| x.exp_m1(),
        |x, _| x.ln(),
        |x, _| x.atan(),
        |x, _| x.sin_cos().0,
        |x, _| x.sin_cos().1,
        |x, y| y - x,
        |x, y| y / x,
        |x, y| Series::select(x.lt(y), x, y).over(3.0),
        |x, y| Series::select(x.lt(y), y, x),
    ];
    let others = [X + Series::constant(1.5), Series::constant(0.3), Series::zero() - X];
    for (y, operation) in others.iter().flat_map(|y| operations.map(|f| (*y, f))) {
        let whole = operation(X, y);
        for known in 1..8 {
            let mut part = X.c;
            part[known..].fill(0.0);
            let x = Series { c: part, known };
            // The other operand is known to more terms, or to as many as there are.
            let mut longer = Series { known: known + 1, ..y };
            longer.c[known + 1..].fill(0.0);
            let found = operation(x, longer);
            assert_eq!(found, operation(x, y));
            assert_eq!(found.known, known);
            assert_eq!(found.c[..known], whole.c[..known], "{known}");
            assert_eq!(found.c[known..], [0.0; 8][known..], "{known}");
            let (found, whole) = (found.integral(0.1), whole.integral(0.1));
            assert_eq!((found.known, found.c[known]), (known + 1, whole.c[known]));
        }
    }
    assert_eq!(Series::<f64, 8>::zero().first(), Series::zero());
}

#[test]
fn coefficients_are_those_of_taylor() {
    let tau = Series::<f64, 8>::new([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut factorial = 1.0;
    for (k, c) in tau.exp().c.into_iter().enumerate() {
        factorial *= if k == 0 { 1.0 } else { k as f64 };
        assert!((c * factorial - 1.0).abs() < 1e-15);
    }
    assert!((tau.exp().at(0.01) - 0.01_f64.exp()).abs() < 1e-15);
    assert_close(tau.exp().integral(1.0), tau.exp());
}
