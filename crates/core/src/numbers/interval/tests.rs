//! Intervals contain all values that they must, and little more.

use super::*;
use crate::numbers::Series;
use qd::Quad;

/// Some points of an interval, its bounds among them.
fn points(x: Interval) -> impl Iterator<Item = f64> {
    let at = move |i: u32| x.low() + (x.high() - x.low()) * f64::from(i) / 32.0;
    (0..32).map(at).map(move |y| y.min(x.high())).chain([x.high()])
}

fn intervals() -> Vec<Interval> {
    let bounds = [-40.0, -3.3, -1.0, -0.1, -1e-9, 0.0, 1e-300, 0.3, 1.0, 1.1, 6.5, 37.0];
    let pairs = bounds.iter().flat_map(|&a| bounds.iter().map(move |&b| (a, b)));
    pairs.filter(|(a, b)| a <= b).map(|(a, b)| Interval::new(a, b)).collect()
}

/// Whether the interval contains a number of 106 bits. An unbounded interval contains every number.
fn holds(x: Interval, y: Quad) -> bool {
    let [low, high] = [x.low(), x.high()].map(Quad::from_f64);
    !x.is_bounded() || low <= y && y <= high
}

#[test]
fn results_contain_those_of_all_points() {
    type Unary = [(fn(Interval) -> Interval, fn(Quad) -> Quad); 9];
    let functions: Unary = [
        (Scalar::sqrt, Scalar::sqrt),
        (Scalar::exp, Scalar::exp),
        (Scalar::exp_m1, Scalar::exp_m1),
        (Scalar::ln, Scalar::ln),
        (|x| x.sin_cos().0, |x| x.sin_cos().0),
        (|x| x.sin_cos().1, |x| x.sin_cos().1),
        (Scalar::atan, Scalar::atan),
        (Scalar::abs, Scalar::abs),
        (Interval::square, |x| x * x),
    ];
    for x in intervals() {
        for (i, (wide, exact)) in functions.into_iter().enumerate() {
            let wide = wide(x);
            for y in points(x) {
                let y = exact(Quad::from_f64(y));
                assert!(holds(wide, y), "{i} of {x:?}: {wide:?} {y:?}");
            }
        }
        for other in intervals() {
            let wide = [x + other, x - other, x * other, x / other];
            for a in points(x) {
                for b in points(other).step_by(5) {
                    let (a, b) = (Quad::from_f64(a), Quad::from_f64(b));
                    let exact = [a + b, a.sub_accurate(b), a * b, a / b];
                    for (i, (wide, exact)) in wide.into_iter().zip(exact).enumerate() {
                        assert!(holds(wide, exact), "{i}: {x:?} {other:?}");
                    }
                }
            }
        }
    }
}

/// A product and a sum that may cancel, near underflow and overflow too.
#[test]
fn a_product_and_a_sum_contain_those_of_all_points() {
    let sums = |product: f64| {
        let near = [product, product.next_up(), 0.999 * product, 1e-5 * product, 1e17 * product];
        near.into_iter().flat_map(|c| [-c, c]).chain([0.0, 1.0, -5e-324])
    };
    let sides = [-1e200, -3.7, -0.1, -1e-150, -1e-160, 0.0, 2e-310, 1e-130, 0.3, 1.1, 7.0, 1e110];
    for (a, b) in sides.into_iter().flat_map(|a| sides.map(|b| (a, b))) {
        for c in sums(a * b).filter(|c| c.is_finite()) {
            let [x, y, z] = [a, b, c].map(Interval::from_f64);
            let wide = x.mul_add(y, z);
            // Everything is scaled by k², so that a small product keeps its digits. The result is
            // exact in 106 bits, or nearly so.
            let k = if (a * b).abs() < 1e-250 { 2_f64.powi(400) } else { 1.0 };
            let exact = (Quad::from_f64(a * k) * Quad::from_f64(b * k))
                .add_accurate(Quad::from_f64(c * k) * Quad::from_f64(k));
            let scaled = |x: f64| Quad::from_f64(x * k) * Quad::from_f64(k);
            if wide.is_bounded() && exact.is_finite() {
                let slack = Quad::from_f64(1e-31 * exact.0.abs());
                assert!(scaled(wide.low()) <= exact + slack, "{a:e} {b:e} {c:e}: {wide:?}");
                assert!(exact - slack <= scaled(wide.high()), "{a:e} {b:e} {c:e}: {wide:?}");
            }
            let two = x * y + z;
            assert!(wide.is_bounded() == two.is_bounded(), "{a:e} {b:e} {c:e}");
        }
    }
    for x in intervals() {
        for (y, z) in intervals().into_iter().zip(intervals().into_iter().rev()) {
            let (wide, two) = (x.mul_add(y, z), x * y + z);
            let apart = 1e-15 * (two.magnitude() + z.magnitude());
            assert!((wide.low() - two.low()).abs() <= apart, "{x:?} {y:?} {z:?}");
            assert!((wide.high() - two.high()).abs() <= apart, "{x:?} {y:?} {z:?}");
        }
    }
}

#[test]
fn bounds_are_the_next_numbers() {
    for value in [0.0, -0.0, 5e-324, -5e-324, 1e-310, 1.0, -1.0, 1e300, -f64::MAX, f64::MAX] {
        assert_eq!(below((value, -1.0)), value.next_down(), "{value:e}");
        assert_eq!(above((value, f64::NAN)), value.next_up(), "{value:e}");
        assert_eq!([below((value, 0.0)), above((value, -1.0))], [value; 2]);
    }
}

#[test]
fn enclosures_are_tight() {
    let one = Interval::one();
    assert_eq!((one + one, one * one, one / one), (one + one, one, one));
    assert_eq!((one + one).low(), (one + one).high());
    let third = one / Interval::from_f64(3.0);
    assert_eq!(third.low().next_up(), third.high());
    let (sin, cos) = Interval::new(1.0, 2.0).sin_cos();
    assert!(sin.high() == 1.0 && sin.low() > 0.84 && cos.high() < 0.541 && cos.low() > -0.417);
    assert!(Interval::new(0.3, 0.4).exp().width() < 0.142_001);
    assert_eq!(Interval::new(-3.0, 2.0).abs(), Interval::new(0.0, 3.0));
}

#[test]
fn a_singularity_is_seen_behind_bounded_functions() {
    let (zero, one) = (Interval::new(-1e-3, 1.0), Interval::one());
    let huge = Interval::from_f64(1e300);
    for pole in [one / zero, zero.ln(), zero.sqrt(), huge * huge, huge.exp()] {
        assert_eq!(pole, Interval::WHOLE);
        let hidden = [pole.atan(), pole.sin_cos().0, pole.exp(), one / (one + pole.square())];
        for hidden in hidden.into_iter().chain([pole * Interval::zero(), pole.abs()]) {
            assert!(!hidden.is_finite().any(), "{hidden:?}");
        }
    }
    assert!(zero.is_finite().all());
    assert_eq!(Interval::new(f64::NAN, 1.0), Interval::WHOLE);
    assert_eq!(Interval::new(1.0, f64::NAN), Interval::WHOLE);
}

#[test]
fn comparisons_may_be_undecided() {
    let (a, b, c) = (Interval::new(0.0, 2.0), Interval::new(1.0, 3.0), Interval::new(4.0, 5.0));
    let (certain, open) = (a.lt(c), a.lt(b));
    assert!(certain.all() && certain.any() && !c.lt(a).any() && !c.lt(a).all());
    assert!(open.any() && !open.all() && open.not().any() && !open.not().all());
    assert!(open.and(certain) == open && open.or(certain) == certain);
    assert_eq!(Interval::select(open, a, c), Interval::new(0.0, 5.0));
    assert_eq!((Interval::select(certain, a, c), Interval::select(certain.not(), a, c)), (a, c));
}

#[test]
fn series_of_intervals_enclose_the_coefficients_along_an_edge() {
    let at = |x: Interval| {
        Series::<Interval, 4>::new([x, Interval::one(), Interval::zero(), Interval::zero()])
    };
    let series = |x| {
        let x = at(x);
        (x * x + Series::one()).recip()
    };
    let wide = series(Interval::new(0.5, 0.6));
    for x in points(Interval::new(0.5, 0.6)) {
        let exact = series(Interval::from_f64(x));
        for (wide, exact) in wide.c.into_iter().zip(exact.c) {
            assert!(wide.low() <= exact.low() && exact.high() <= wide.high());
        }
    }
}
