//! Each scalar type computes, in each of its lanes, what f64 computes, up to a few roundings.

use afterbay_core::{Corrected, Interval, Mask, Quad, Scalar, Series, Slope, f64x8};

/// Numbers of both signs and several sizes, a different one in each lane.
fn number(seed: usize, lane: usize) -> f64 {
    let x = (0.7 + 1.3 * seed as f64 + 2.1 * lane as f64).sin();
    x * 2_f64.powi((seed + lane) as i32 % 7 - 3)
}

/// Compares each lane with the number that f64 gives.
fn agrees<T: Scalar>(name: &str, found: T, expected: impl Fn(usize) -> f64) {
    for lane in 0..T::LANES {
        let (found, expected) = (found.lane(lane), expected(lane));
        let off = (found - expected).abs();
        assert!(off <= 1e-14 * expected.abs().max(1.0), "{name}: {found:?} is not {expected:?}");
    }
}

fn operations_are_those_of_f64<T: Scalar>() {
    for seed in 0..40 {
        let [x, y, z] = [0, 1, 2].map(|k| move |lane| number(3 * seed + k, lane));
        let [a, b, c] = [T::from_lanes(x), T::from_lanes(y), T::from_lanes(z)];
        agrees("from_lanes", a, x);
        agrees("from_f64", T::from_f64(x(0)), |_| x(0));
        assert!((a.to_f64() - x(0)).abs() <= 1e-15, "to_f64");
        agrees("zero", T::zero(), |_| 0.0);
        agrees("one", T::one(), |_| 1.0);
        agrees("+", a + b, |k| x(k) + y(k));
        agrees("-", a - b, |k| x(k) - y(k));
        agrees("*", a * b, |k| x(k) * y(k));
        let divisor = b * b + T::one();
        agrees("/", a / divisor, |k| x(k) / (y(k) * y(k) + 1.0));
        agrees("recip", divisor.recip(), |k| (y(k) * y(k) + 1.0).recip());
        agrees("neg", -a, |k| -x(k));
        let [mut sum, mut difference, mut product] = [a; 3];
        sum += b;
        difference -= b;
        product *= b;
        agrees("+=", sum, |k| x(k) + y(k));
        agrees("-=", difference, |k| x(k) - y(k));
        agrees("*=", product, |k| x(k) * y(k));
        agrees("mul_add", a.mul_add(b, c), |k| x(k) * y(k) + z(k));
        agrees("half", a.half(), |k| x(k) / 2.0);
        agrees("over", a.over(3.0), |k| x(k) / 3.0);
        agrees("abs", a.abs(), |k| x(k).abs());
        agrees("sqrt", divisor.sqrt(), |k| (y(k) * y(k) + 1.0).sqrt());
        agrees("exp", c.exp(), |k| z(k).exp());
        agrees("exp_m1", c.exp_m1(), |k| z(k).exp_m1());
        agrees("ln", divisor.ln(), |k| (y(k) * y(k) + 1.0).ln());
        let (sin, cos) = a.sin_cos();
        agrees("sin", sin, |k| x(k).sin());
        agrees("cos", cos, |k| x(k).cos());
        agrees("atan", a.atan(), |k| x(k).atan());
        let (share, arc) = (a.atan().half(), |k: usize| x(k).atan() / 2.0);
        agrees("asin", share.asin(), |k| arc(k).asin());
        agrees("acos", share.acos(), |k| arc(k).acos());
        agrees("tan", share.tan(), |k| arc(k).tan());
        agrees("sin alone", a.sin(), |k| x(k).sin());
        agrees("cos alone", a.cos(), |k| x(k).cos());
        agrees("sinh", share.sinh(), |k| arc(k).sinh());
        agrees("cosh", share.cosh(), |k| arc(k).cosh());
        agrees("tanh", a.tanh(), |k| x(k).tanh());
        for n in [0, 1, 2, 3, 7, -1, -4] {
            agrees("powi", divisor.powi(n), |k| (y(k) * y(k) + 1.0).powi(n));
        }
    }
}

/// Masks, for scalars whose comparisons are decided by the numbers alone.
fn comparisons_are_those_of_f64<T: Scalar>() {
    for seed in 0..40 {
        let [x, y] = [0, 1].map(|k| move |lane| number(2 * seed + k, lane));
        let [a, b] = [T::from_lanes(x), T::from_lanes(y)];
        agrees("floor", a.floor(), |k| x(k).floor());
        let (less, least) = (a.lt(b), T::select(a.lt(b), a, b));
        agrees("lt", least, |k| if x(k) < y(k) { x(k) } else { y(k) });
        agrees("not", T::select(less.not(), a, b), |k| if x(k) < y(k) { y(k) } else { x(k) });
        let positive = T::zero().lt(a);
        let [both, either] = [less.and(positive), less.or(positive)];
        agrees(
            "and",
            T::select(both, a, b),
            |k| if x(k) < y(k) && 0.0 < x(k) { x(k) } else { y(k) },
        );
        agrees(
            "or",
            T::select(either, a, b),
            |k| {
                if x(k) < y(k) || 0.0 < x(k) { x(k) } else { y(k) }
            },
        );
        let count = (0..T::LANES).filter(|&k| x(k) < y(k)).count();
        assert_eq!((less.any(), less.all()), (count > 0, count == T::LANES));
        assert!(a.le(a).all() && !a.lt(a).any());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let last = T::from_lanes(|k| if k + 1 == T::LANES { bad } else { x(k) });
            assert!(!last.is_finite().all() && a.is_finite().all());
            assert_eq!(last.is_finite().any(), T::LANES > 1);
        }
    }
}

#[test]
fn every_scalar_computes_and_compares_as_f64_does() {
    fn both<T: Scalar>() {
        operations_are_those_of_f64::<T>();
        comparisons_are_those_of_f64::<T>();
    }
    both::<f64>();
    both::<Quad>();
    both::<f64x8>();
    both::<Corrected<f64>>();
    both::<Corrected<f64x8>>();
    #[cfg(feature = "num-dual")]
    both::<num_dual::Dual64>();
}

/// Their comparisons look at more than the number: at both ends, or at the coefficients.
#[test]
fn intervals_slopes_and_series_compute_as_f64_does() {
    operations_are_those_of_f64::<Interval>();
    operations_are_those_of_f64::<Slope<f64>>();
    operations_are_those_of_f64::<Slope<f64x8>>();
    operations_are_those_of_f64::<Series<f64, 4>>();
}

/// The derivatives that each kind of number carries.
#[test]
fn derivatives_of_functions_are_known() {
    fn all<T: Scalar>(x: T) -> [T; 9] {
        let functions = [T::sin, T::cos, T::tan, T::asin, T::acos, T::sinh, T::cosh, T::tanh];
        let [sin, cos, tan, asin, acos, sinh, cosh, tanh] = functions.map(|f| f(x));
        [sin, cos, tan, asin, acos, sinh, cosh, tanh, x.powi(-3)]
    }
    for x in [-0.9_f64, -0.3, 1e-9, 0.5, 0.99] {
        let root = ((1.0 - x) * (1.0 + x)).sqrt();
        let exact = [
            x.cos(),
            -x.sin(),
            x.cos().powi(-2),
            root.recip(),
            -root.recip(),
            x.cosh(),
            x.sinh(),
            x.cosh().powi(-2),
            -3.0 * x.powi(-4),
        ];
        let mut found = vec![
            all(Slope::between(x, x)).map(|f| f.slope),
            all(Series::<f64, 3>::new([x, 1.0, 0.0])).map(|f| f.c[1]),
        ];
        #[cfg(feature = "num-dual")]
        found.push(all(num_dual::Dual64::new(x, 1.0)).map(|f| f.eps));
        let quad = Quad::from_f64(x);
        found.push(all(Slope::between(quad, quad)).map(|f| f.slope.to_f64()));
        for (kind, found) in found.iter().enumerate() {
            for (i, (found, exact)) in found.iter().zip(exact).enumerate() {
                let off = (found - exact).abs() / exact.abs().max(1.0);
                assert!(off < 3e-15, "{i} at {x} by {kind}: {found:e} is not {exact:e}");
            }
        }
    }
}

#[test]
fn a_number_is_read_to_the_bit() {
    fn check<T: Scalar>() {
        let numbers = [-0.0, 0.0, 5e-324, -1.5, f64::MAX, f64::INFINITY, f64::NAN, -f64::NAN];
        let read = T::from_lanes(|k| numbers[k]).read();
        for (k, number) in numbers[..T::LANES].iter().enumerate() {
            assert_eq!(read.lane(k).to_bits(), number.to_bits(), "{number}");
        }
    }
    check::<f64>();
    check::<f64x8>();
}

#[test]
fn sine_and_cosine_of_large_angles_are_those_of_f64() {
    fn check<T: Scalar>(largest: i32) {
        for power in 0..=largest {
            let angle = |k: usize| 10_f64.powi(power) * number(power as usize, k);
            let (sin, cos) = T::from_lanes(angle).sin_cos();
            agrees("sin", sin, |k| angle(k).sin());
            agrees("cos", cos, |k| angle(k).cos());
        }
    }
    check::<f64>(300);
    check::<f64x8>(300);
    // π/2 has 160 bits there.
    check::<Quad>(30);
    check::<Corrected<f64x8>>(30);
}

#[test]
fn exponentials_of_huge_numbers_overflow_or_vanish() {
    fn check<T: Scalar>() {
        for huge in [800.0, 1e5, 1e300] {
            let x = T::from_f64(huge);
            agrees("exp", (-x).exp(), |_| 0.0);
            agrees("exp_m1", (-x).exp_m1(), |_| -1.0);
            assert!(!x.exp().is_finite().any() && !x.exp_m1().is_finite().any(), "{huge}");
        }
    }
    check::<f64>();
    check::<Quad>();
    check::<f64x8>();
}
